"""`slider-drilling closed-loop --campaign`: controllers compared on random rigs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from slider_drilling.commands.options import write_and_print

if TYPE_CHECKING:
    from slider_drilling.campaign.results import JobResult
    from slider_drilling.campaign.run import WorkerSettings
    from slider_drilling.slide_scenarios.campaign import CampaignOptions, ScoredSlide
    from slider_drilling.slide_scenarios.scenario import Scenario
    from slider_drilling.units import Units

FILE, PAGE, RESULTS = "closed_loop_campaign.json", "closed_loop_campaign.html", "results"


def run_campaign(
    controllers: Sequence[str],
    slides: int,
    options: CampaignOptions,
    workers: WorkerSettings,
    output: Path,
    custom_rig: bool,
    as_json: bool,
    units: Units,
) -> int:
    """Run every controller through every slide.

    Args:
        controllers: Names, the controller under test first.
        slides: Number of slides.
        options: What all jobs share.
        workers: Where the jobs run.
        output: Folder of the results.
        custom_rig: Whether `options.rig` is not the default.
        as_json: Print JSON instead of the table.
        units: Of the page.

    Returns:
        The exit code.
    """
    from slider_drilling.campaign.code_version import code_version
    from slider_drilling.campaign.progress import run_with_progress
    from slider_drilling.files.output_files import check_outputs, make_folder, make_subfolder, write_atomically
    from slider_drilling.pages import write_page
    from slider_drilling.slide_scenarios import campaign_page
    from slider_drilling.slide_scenarios.campaign import repeat_command, slide_job

    make_folder(output)
    check_outputs((output / FILE, output / PAGE), (options.rig,))
    jobs = [slide_job(number, name, options) for number in range(slides) for name in controllers]
    run = run_with_progress("slides", jobs, make_subfolder(output, RESULTS), workers)
    scored: dict[str, list[ScoredSlide]] = {name: [] for name in controllers}
    for job, key in zip(jobs, run.keys, strict=True):
        if (slide := run.parse(key, partial(_slide, number=job.options["number"]))) is not None:
            scored[job.options["controller"]].append(slide)
    scored = {name: results for name, results in scored.items() if results}
    if not scored:
        return run.exit_code
    repeat = {name: partial(repeat_command, controller=name, campaign=options, custom_rig=custom_rig)
              for name in scored}  # fmt: skip
    tree = campaign_page.as_json(scored, options, code_version(), repeat)

    def write() -> tuple[Path, ...]:
        write_atomically(output / FILE, json.dumps(tree, indent=1, allow_nan=False).encode("utf-8"))
        write_page(output / PAGE, campaign_page.campaign_page(scored, options, code_version(), repeat), units)
        return output / FILE, output / PAGE

    write_and_print(tree if as_json else None, lambda: _print(scored), write)
    return run.exit_code


def _slide(result: JobResult, number: int) -> ScoredSlide:
    from slider_drilling.slide_scenarios.campaign import slide_of

    return slide_of(result.tree, number)


def drawn_scenario(number: int, options: CampaignOptions) -> tuple[Scenario, int]:
    """Return one slide of a campaign, and the seed of its noise."""
    from slider_drilling.rig import load_rig
    from slider_drilling.slide_scenarios.campaign import noise_seed
    from slider_drilling.slide_scenarios.drawn import draw_slide

    scenario = draw_slide(number, options.seed, load_rig(options.rig), options.duration, foreign=options.foreign)
    return scenario, noise_seed(options.seed, number)


def _print(scored: Mapping[str, Sequence[ScoredSlide]]) -> None:
    from rich.table import Table

    from slider_drilling.console.streams import stdout
    from slider_drilling.slide_scenarios.campaign import summarise
    from slider_drilling.slide_scenarios.campaign_page import TERMINAL_HEADER, comparison_sentences, terminal_row

    table = Table(*TERMINAL_HEADER, title="mean toolface error that this share of slides stays below")
    for name, slides in scored.items():
        table.add_row(*terminal_row(name, summarise(slides)))
    stdout().print(table)
    for sentence in comparison_sentences(scored):
        stdout().print(sentence)
