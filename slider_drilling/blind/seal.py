"""Make a sealed log, its label in another folder, and its twins, repeats of the same run, in a third."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.blind.cases import NO_EFFECT, SIZE_TOLERANCE, Case, case_from_json
from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS
from slider_drilling.blind.foreign.structure import draw_structure
from slider_drilling.blind.label import Label
from slider_drilling.blind.log_defects import LOG_DEFECTS
from slider_drilling.blind.manoeuvres import MANOEUVRES
from slider_drilling.blind.outside_laws import OUTSIDE_LAWS
from slider_drilling.blind.plant_law import LawFactory, PlantLaw, combine, no_effect
from slider_drilling.blind.recorder import random_recorder_model, write_sealed_log
from slider_drilling.blind.sealed_plant import (
    PlantPerturbation,
    random_perturbation,
    simulate_foreign,
    simulate_sealed,
    size_in_noise,
)
from slider_drilling.blind.wells import WELLS
from slider_drilling.campaign.job import Job
from slider_drilling.drillstring import Commands, Response
from slider_drilling.files.output_files import write_atomically
from slider_drilling.rig import Rig, load_rig

_LAWS: dict[str, LawFactory] = {**CATALOGUE_LAWS, **OUTSIDE_LAWS, NO_EFFECT: no_effect}
# Search for the amount that gives the target size. Ten times a usual amount is the limit: no top drive has a dead zone
# of two turns.
_TRIALS, _MAX_AMOUNT, _MIN_AMOUNT = 7, 10.0, 1e-3
# A law that makes the string break free or stick changes the response in a jump, so the amount changes in small steps.
_MAX_STEP = 6.0
REPEATS = 3
"""Twins of each log: together they show what the true effects close in such a run better than the log alone."""


def seal_job(case: Case, rig: Path, logs: Path, labels: Path, twins: Path, repeats: int) -> Job:
    """Returns the job that makes a case.

    Args:
        case: What to seal.
        rig: Rig file.
        logs: Folder of the log.
        labels: Folder of the label.
        twins: Folder of the twins; only cases with catalogued effects have any.
        repeats: Number of twins.
    """
    stem = case.file_stem()
    outputs = [str(logs / f"{stem}.mcap"), str(labels / f"{stem}.json")]
    if case.kind in ("single", "two"):
        outputs += [str(twins / f"{stem}_{number + 1}.mcap") for number in range(repeats)]
    # `seal` reads the outputs in this order.
    return Job("slider_drilling.blind.seal:seal", stem, {"rig": str(rig)}, case.to_json(), case.seed, tuple(outputs))


def seal(job: Job) -> dict[str, Any]:
    """Writes the log and its twins, then the label."""
    log, label_path, *twins = (Path(output) for output in job.outputs)
    label = make(case_from_json(dict(job.options)), load_rig(job.inputs["rig"]), log, twins)
    write_atomically(label_path, (json.dumps(asdict(label), indent=1) + "\n").encode("utf-8"))
    return {}


def make(case: Case, base: Rig, path: Path, twins: Sequence[Path] = ()) -> Label:
    """Writes one sealed log and returns its label.

    Args:
        case: What to seal.
        base: Rig that wells, string and fluids are drawn from.
        path: Of the log.
        twins: Paths of repeats: the same run with another draw of noise and losses each.
    """
    # The order of the draws defines the logs of a seed.
    generator = np.random.default_rng(case.seed)
    rig = WELLS[case.well](generator, base)
    commands = MANOEUVRES[case.manoeuvre](generator, rig, case.duration)
    # A generator of its own: the run is the same whatever its log leaves out.
    defect = LOG_DEFECTS[case.log_defect](np.random.default_rng([case.seed, 2]))
    perturbation, recorder = random_perturbation(generator), random_recorder_model(generator, defect)
    neutral = simulate_sealed(rig, perturbation, no_effect(generator, rig, 1.0), commands)
    laws, sizes = [], []
    for name in case.effects:
        seed = int(generator.integers(2**31))
        law, size = _law_of_size(_LAWS[name], case, rig, perturbation, commands, neutral, seed)
        laws.append(law)
        sizes.append(size)
    law = laws[0] if len(laws) == 1 else combine(*laws)
    response = neutral if law.name == NO_EFFECT else simulate_sealed(rig, perturbation, law, commands)
    structure: dict[str, Any] = {}
    if case.plant == "foreign":
        # Sizes are those in the model's own plant. What the foreign plant differs by is drawn for every log alike.
        foreign = draw_structure(np.random.default_rng([case.seed, 3]))
        commands, response = simulate_foreign(rig, perturbation, law, commands, foreign, case.seed)
        structure = asdict(foreign)
    write_sealed_log(path, rig, commands, response, generator, recorder)
    for number, twin in enumerate(twins):
        write_sealed_log(twin, rig, commands, response, np.random.default_rng([case.seed, 1, number]), recorder)
    return Label(
        log=path.name, kind=case.kind, effects=tuple(law.name for law in laws if law.name != NO_EFFECT),
        sites=tuple((law.site, *law.other_sites) for law in laws if law.site is not None), size=case.size,
        sizes=tuple(sizes), well=case.well, manoeuvre=case.manoeuvre, seed=case.seed,
        depth_interval=law.depth_interval, plant=asdict(perturbation), recorder=asdict(recorder),
        log_defect=case.log_defect, structure=structure,
    )  # fmt: skip


def _law_of_size(
    factory: LawFactory, case: Case, rig: Rig, perturbation: PlantPerturbation, commands: Commands, neutral: Response,
    seed: int,
) -> tuple[PlantLaw, float]:  # fmt: skip
    """Returns the law whose size is nearest to the case's, and that size in noise floors."""
    if case.size == 0.0:
        return factory(np.random.default_rng(seed), rig, 1.0), 0.0
    amount, best, best_size, best_error = 1.0, None, 0.0, np.inf
    for _ in range(_TRIALS):
        # The same draw each time: only the amount differs.
        law = factory(np.random.default_rng(seed), rig, amount)
        size = size_in_noise(rig, neutral, simulate_sealed(rig, perturbation, law, commands))
        error = abs(np.log(max(size, 1e-6) / case.size))
        if best is None or error < best_error:
            best, best_size, best_error = law, size, error
        if error < np.log(SIZE_TOLERANCE):
            break
        step = float(np.clip(case.size / max(size, 1e-6), 1.0 / _MAX_STEP, _MAX_STEP))
        amount = float(np.clip(amount * step, _MIN_AMOUNT, _MAX_AMOUNT))
    assert best is not None
    return best, best_size
