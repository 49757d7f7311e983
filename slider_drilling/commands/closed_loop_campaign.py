"""What `slider-drilling closed-loop --campaign` does: random rigs, controllers side by side."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from slider_drilling.commands.options import write_and_print

if TYPE_CHECKING:
    from slider_drilling.campaign.run import WorkerSettings
    from slider_drilling.closed_loop.campaign import CampaignOptions, ScoredSlide
    from slider_drilling.closed_loop.scenario import Scenario
    from slider_drilling.units import Units

FILE, PAGE, RESULTS = "closed_loop_campaign.json", "closed_loop_campaign.html", "results"


def run_campaign(
    controllers: Sequence[str],
    slides: int,
    setting: CampaignOptions,
    where: WorkerSettings,
    output: Path,
    own_rig: bool,
    as_json: bool,
    units: Units,
) -> int:
    """Every controller through every slide; the exit code. The first controller is the one under test."""
    from slider_drilling.campaign.code_version import code_version
    from slider_drilling.campaign.progress import run_with_progress
    from slider_drilling.closed_loop import campaign_page
    from slider_drilling.closed_loop.campaign import repeat_command, slide_job, slide_of
    from slider_drilling.files.output_files import check_outputs, make_folder, write_atomically
    from slider_drilling.pages import write_page

    make_folder(output)
    check_outputs((output / FILE, output / PAGE), (setting.rig,))
    jobs = [slide_job(number, name, setting) for number in range(slides) for name in controllers]
    ran = run_with_progress("sliding", jobs, output / RESULTS, where)
    found: dict[str, list[ScoredSlide]] = {name: [] for name in controllers}
    for job, key in zip(jobs, ran.keys, strict=True):
        if (result := ran.result(key)) is not None:
            found[job.options["controller"]].append(slide_of(result.tree))
    found = {name: of for name, of in found.items() if of}
    if not found:
        return ran.exit_code
    repeat = {name: partial(repeat_command, controller=name, setting=setting, own_rig=own_rig) for name in found}
    tree = campaign_page.as_json(found, setting, code_version(), repeat)

    def write() -> tuple[Path, ...]:
        write_atomically(output / FILE, json.dumps(tree, indent=1, allow_nan=False).encode("utf-8"))
        write_page(output / PAGE, campaign_page.campaign_page(found, setting, code_version(), repeat), units)
        return output / FILE, output / PAGE

    write_and_print(tree if as_json else None, lambda: _print(found), write)
    return ran.exit_code


def drawn_scenario(number: int, setting: CampaignOptions) -> tuple[Scenario, int]:
    """One slide of a campaign, and the seed of its noise."""
    from slider_drilling.closed_loop.campaign import noise_seed
    from slider_drilling.closed_loop.drawn import draw_slide
    from slider_drilling.rig import load_rig

    return draw_slide(number, setting.seed, load_rig(setting.rig), setting.duration), noise_seed(setting.seed, number)


def _print(found: Mapping[str, Sequence[ScoredSlide]]) -> None:
    from rich.table import Table

    from slider_drilling.closed_loop.campaign import summarise
    from slider_drilling.closed_loop.campaign_page import BRIEF, brief_cells, pair_sentences
    from slider_drilling.console.streams import stdout

    table = Table(*BRIEF, title="mean error, deg, that this share of slides stays below; slides held, set, idle")
    for name, slides in found.items():
        table.add_row(*brief_cells(name, summarise(slides)))
    stdout().print(table)
    for sentence in pair_sentences(found):
        stdout().print(sentence)
