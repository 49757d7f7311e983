"""`slider-drilling completion`: shell completion of commands, options and values."""

from __future__ import annotations

import click

EPILOG = """\
Examples:

\b
  slider-drilling completion bash > ~/.local/share/bash-completion/completions/slider-drilling
  slider-drilling completion zsh > ~/.zfunc/_slider-drilling      (~/.zfunc must be in fpath)
  slider-drilling completion fish > ~/.config/fish/completions/slider-drilling.fish
"""
PROGRAM = "slider-drilling"


@click.command(epilog=EPILOG)
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@click.pass_context
def command(context: click.Context, shell: str) -> None:
    """Print the completion script for SHELL."""
    from click.shell_completion import BashComplete, FishComplete, ZshComplete

    kind = {"bash": BashComplete, "zsh": ZshComplete, "fish": FishComplete}[shell]
    click.echo(kind(context.find_root().command, {}, PROGRAM, "_SLIDER_DRILLING_COMPLETE").source())
