"""`slider-drilling watch`: a twin beside a log, a recording that grows, or a stream of WITS."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.campaign_options import jobs_option, scheduler_option
from slider_drilling.commands.options import SEED, json_option, namespace_option, topics_option, units_option

if TYPE_CHECKING:
    from slider_drilling.twin import Twin
    from slider_drilling.units import Units

EXAMPLES = """\
SOURCE is a log, a recording or its folder while it is written, - for WITS on standard input, wits://HOST:PORT or
serial:///dev/ttyS0. WITS needs --rig and --wits-units.

Examples:

\b
  slider-drilling watch run.mcap
  slider-drilling watch recordings/today --json
  slider-drilling watch --campaign 40 --jobs 4 -o twin_campaign
  nc rig 5000 | slider-drilling watch - --rig rig.yaml --wits-units field
"""
# Options that mean nothing without the kind of run, or of source, that they are for.
_WITH_CAMPAIGN = ("begins", "duration", "driven_by", "seed", "output", "jobs", "scheduler")
_WITH_RECORDING = ("follow", "namespace", "topics_path")
_WITH_SOURCE = (*_WITH_RECORDING, "wits_units", "save_rig", "units")


@click.command(epilog=EXAMPLES)
@click.argument("source", type=str, required=False)
@click.option("--rig", "rig_path", type=click.Path(path_type=Path), help="Rig file instead of the log's own.")
@click.option("--diagnose/--no-diagnose", default=True, show_default=True,
              help="Ask after a detection what is different, in a process of its own.")  # fmt: skip
@click.option("--follow", is_flag=True, help="Wait for more of a recording that no program of this machine writes.")
@click.option("--wits-units", type=click.Choice(["field", "metric"]), help="Units of WITS, which does not tell them.")
@click.option("--save-rig", type=click.Path(path_type=Path),
              help="Write the calibrated rig file here at the end, or on Ctrl-C.")  # fmt: skip
@click.option("--campaign", type=click.IntRange(1, 10000), metavar="N",
              help="Instead of a source: N sealed slides of foreign rigs, scored against their labels.")  # fmt: skip
@click.option("--begins", default="", metavar="NAME,...", help="With --campaign: what may begin. [default: all]")
@click.option("--duration", default=2400.0, show_default=True, help="With --campaign: length of each slide, s.")
@click.option("--driven-by", type=click.Choice(["controller", "crew"]), default="controller", show_default=True,
              help="With --campaign: who slides; a crew rocks by hand, in other ways now and then.")  # fmt: skip
@click.option("--seed", default=1, show_default=True, type=SEED, help="With --campaign: of everything drawn.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default="twin_campaign", show_default=True,
              help="With --campaign: folder of logs, labels, results and twin_campaign.json.")  # fmt: skip
@jobs_option
@scheduler_option
@namespace_option
@topics_option
@json_option
@units_option
def command(
    source: str | None,
    rig_path: Path | None,
    diagnose: bool,
    follow: bool,
    wits_units: str | None,
    save_rig: Path | None,
    campaign: int | None,
    begins: str,
    duration: float,
    driven_by: str,
    seed: int,
    output: Path,
    jobs: int,
    scheduler: str,
    namespace: str | None,
    topics_path: Path | None,
    as_json: bool,
    units: Units,
) -> int:
    """Simulate alongside SOURCE: the gap live, what changed, since when, and why.

    With --json a line a second: t, gap over 60 s and its threshold by channel, detections; times in s from the start.
    """
    from slider_drilling.campaign.run import WorkerSettings
    from slider_drilling.commands.options import refuse_ignored
    from slider_drilling.commands.watch_campaign import watch_campaign
    from slider_drilling.commands.watch_output import JsonLines, TableLines, print_note
    from slider_drilling.commands.watch_sources import open_feed, source_name
    from slider_drilling.errors import InputError
    from slider_drilling.files.output_files import check_outputs
    from slider_drilling.table_import.live_wits import is_live
    from slider_drilling.twin import Twin, diagnose_after
    from slider_drilling.twin.watch import watch

    if (campaign is None) == (source is None):
        raise InputError("watch: give a SOURCE, or --campaign N")
    if campaign is not None:
        refuse_ignored("with --campaign", _WITH_SOURCE)
    else:
        refuse_ignored("without --campaign", _WITH_CAMPAIGN)
    if source is not None and is_live(source):
        refuse_ignored("with a stream of WITS", _WITH_RECORDING)
    if campaign is not None:
        names = tuple(name.strip() for name in begins.split(",") if name.strip())
        workers = WorkerSettings(jobs, scheduler)
        return watch_campaign(
            campaign, seed, names, duration, driven_by, rig_path, output, workers, as_json, diagnose
        )
    assert source is not None
    if save_rig is not None:
        check_outputs((save_rig,), (Path(source), rig_path, topics_path))
    with open_feed(source, rig_path, namespace, topics_path, follow, wits_units or "") as (feed, rig, replayed):
        twin = Twin(rig, ask=diagnose_after if diagnose else None, replayed=replayed)
        lines = JsonLines(twin) if as_json else TableLines(twin, units)
        try:
            watch(twin, feed, lines.show, source=source_name(source))
        except (InputError, KeyboardInterrupt):
            # The usual end of a stream, or one that cannot go on, such as after its clock was set back.
            lines.end()
            if save_rig is not None:
                unsaved = _save_rig(twin, save_rig)
                print_note(f"{save_rig}: {'not written: the rig is not learnt' if unsaved else 'the calibrated rig'}")
            raise
        finally:
            twin.close()
        lines.end()
    if save_rig is not None and (why := _save_rig(twin, save_rig)):
        raise InputError(why)
    return 0


def _save_rig(twin: Twin, path: Path) -> str:
    """Write the calibrated rig. Returns why it was not written; empty if it was."""
    from slider_drilling.files.output_files import write_atomically
    from slider_drilling.rig import dump_rig

    if not twin.learnt:
        return f"--save-rig {path}: not written: {twin.not_compared}"
    write_atomically(path, dump_rig(twin.calibrated_rig()).encode())
    return ""
