"""`slider-drilling blind-check`: how often the diagnosis is right on logs that it has not seen."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import seeds as seed_range

if TYPE_CHECKING:
    from slider_drilling.blind.check import Scored


@click.command(epilog="Example:\n\n  slider-drilling blind-check --effect stribeck --effect none -o blind")
@click.option("--effect", "names", multiple=True, help="What to seal; repeatable; everything if not given.")
@click.option("--seeds", default=1, show_default=True, type=click.IntRange(1, 10**6), help="Logs of each.")
@click.option("--first-seed", default=1, show_default=True, type=seed_range, help="Of the first log of each.")
@click.option("--rig", "rig_path", type=click.Path(path_type=Path), help="Rig file that wells are varied from.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default="blind", show_default=True,
              help="Folder for the logs, seals.json and blind_check.json.")  # fmt: skip
def command(names: tuple[str, ...], seeds: int, first_seed: int, rig_path: Path | None, output: Path) -> None:
    """Seal logs, diagnose them from the logs alone, then open the seals and score.

    The sealed plant has a finer mesh, another step, other nuisance parameters, noise, and laws that differ in form
    from the catalogue's; some are in no catalogue.
    """
    # Before numpy is imported: its matrices here are small, and threads that wait for work of theirs keep the
    # simulations' threads from a third of the processor.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

    import json

    from slider_drilling.blind.check import blind_check, totals
    from slider_drilling.blind.laws import CATALOGUE, OUTSIDE
    from slider_drilling.console import stderr, stdout
    from slider_drilling.errors import InputError
    from slider_drilling.files import make_folder, prepare_outputs, write_whole
    from slider_drilling.gap.progress import progress_bar
    from slider_drilling.rig import load_rig
    from slider_drilling.share import share_file

    known = [*CATALOGUE, *OUTSIDE, "none"]
    for name in names:
        if name not in known:
            raise InputError(f"--effect {name}: not one of {', '.join(known)}")
    base = load_rig(rig_path if rig_path is not None else share_file("config/rig.example.yaml"))
    make_folder(output)
    prepare_outputs((output / "seals.json", output / "blind_check.json"), (rig_path,))
    with progress_bar(stderr()) as progress:
        results = blind_check(
            names or known, range(first_seed, first_seed + seeds), base, output,
            lambda scored: stdout().print(_line(scored)), progress,
        )  # fmt: skip
    tally = totals(results)
    write_whole(output / "blind_check.json", json.dumps(tally, indent=1).encode("utf-8"))
    for name, value in tally.items():
        if name != "confusion":
            stdout().print(f"{name.replace('_', ' ')}: {value[0]} of {value[1]}")


def _line(scored: Scored) -> str:
    said = " + ".join(scored.named) or "nothing"
    group = f" (or {', '.join(scored.group)})" if scored.group else ""
    mark = "right" if scored.right else "WRONG"
    return (
        f"{mark}: {scored.truth} at {scored.size:.1f} noise floors -> {scored.verdict}: {said}{group}, "
        f"closes {scored.closed:.2f}, oracle {scored.oracle:.2f}, {scored.runtime:.0f} s"
    )
