"""Make a sealed log, its label in another place, and its twins, the same run made again, in a third."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.blind.cases import NONE, SIZE_TOLERANCE, Case, case_from_json
from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS
from slider_drilling.blind.label import Label
from slider_drilling.blind.log_defects import LOG_DEFECTS
from slider_drilling.blind.manoeuvres import MANOEUVRES
from slider_drilling.blind.outside_laws import OUTSIDE_LAWS
from slider_drilling.blind.plant_law import LawFactory, PlantLaw, combine, no_effect
from slider_drilling.blind.recorder import random_recorder_model, write_sealed_log
from slider_drilling.blind.sealed_plant import PlantPerturbation, random_perturbation, simulate_sealed, size_in_noise
from slider_drilling.blind.wells import WELLS
from slider_drilling.campaign.job import Job
from slider_drilling.drillstring import Commands, Response
from slider_drilling.files.output_files import write_atomically
from slider_drilling.rig import Rig, load_rig

_MAKERS: dict[str, LawFactory] = {**CATALOGUE_LAWS, **OUTSIDE_LAWS, NONE: no_effect}
# A law is made larger or smaller until it moves the plant by about the size that is asked for (`NEAR`); at most ten
# times as large as is usual: a top drive has no dead zone of two turns.
_TRIALS, _LARGEST, _SMALLEST = 7, 10.0, 1e-3
# So many twins say together what the truth closes in such a run more surely than the log does.
REPEATS = 3


def seal_job(case: Case, rig: Path, logs: Path, labels: Path, twins: Path, repeats: int) -> Job:
    """The job that makes a case: its log in one folder, its label in another, and what has a truth so many twins."""
    name = case.file_stem()
    outputs = [str(logs / f"{name}.mcap"), str(labels / f"{name}.json")]
    if case.kind in ("single", "two"):
        outputs += [str(twins / f"{name}_{number + 1}.mcap") for number in range(repeats)]
    # Outputs in the order that `seal` reads them.
    return Job("slider_drilling.blind.seal:seal", name, {"rig": str(rig)}, case.to_json(), case.seed, tuple(outputs))


def seal(job: Job) -> dict[str, Any]:
    """Write the log and its twins, then the label that says what is in them."""
    log, label, *twins = (Path(output) for output in job.outputs)
    written = make(case_from_json(dict(job.options)), load_rig(job.inputs["rig"]), log, twins)
    write_atomically(label, (json.dumps(asdict(written), indent=1) + "\n").encode("utf-8"))
    return {}


def make(case: Case, base: Rig, path: Path, twins: Sequence[Path] = ()) -> Label:
    """Write one sealed log; what is behind its seal.

    twins: the same run with another draw of noise and losses each.
    """
    generator = np.random.default_rng(case.seed)
    rig = WELLS[case.well](generator, base)
    commands = MANOEUVRES[case.manoeuvre](generator, rig, case.duration)
    # Of a generator of its own: the run is the same whatever its log lacks.
    lack = LOG_DEFECTS[case.log_defect](np.random.default_rng([case.seed, 2]))
    hidden, recorder = random_perturbation(generator), random_recorder_model(generator, lack)
    plain = simulate_sealed(rig, hidden, no_effect(generator, rig, 1.0), commands)
    laws, sizes = [], []
    for name in case.effects:
        law, size = _of_size(_MAKERS[name], case, rig, hidden, commands, plain, int(generator.integers(2**31)))
        laws.append(law)
        sizes.append(size)
    law = laws[0] if len(laws) == 1 else combine(*laws)
    response = plain if law.name == NONE else simulate_sealed(rig, hidden, law, commands)
    write_sealed_log(path, rig, commands, response, generator, recorder)
    for number, twin in enumerate(twins):
        again = np.random.default_rng([case.seed, 1, number])
        write_sealed_log(twin, rig, commands, response, again, recorder)
    return Label(
        log=path.name, kind=case.kind, effects=tuple(law.name for law in laws if law.name != NONE),
        sites=tuple((law.site, *law.other_sites) for law in laws if law.site is not None), size=case.size,
        sizes=tuple(sizes), well=case.well, manoeuvre=case.manoeuvre, seed=case.seed, depth_interval=law.depth_interval,
        plant=asdict(hidden), recorder=asdict(recorder), log_defect=case.log_defect,
    )  # fmt: skip


def _of_size(
    maker: LawFactory, case: Case, rig: Rig, hidden: PlantPerturbation, commands: Commands, plain: Response, seed: int
) -> tuple[PlantLaw, float]:
    """The law that moves the plant by the case's size, or comes nearest to it; and by how much it does."""
    if case.size == 0.0:
        return maker(np.random.default_rng(seed), rig, 1.0), 0.0
    amount, best, nearest = 1.0, None, (0.0, np.inf)
    for _ in range(_TRIALS):
        # The same draw every time: only the size differs.
        law = maker(np.random.default_rng(seed), rig, amount)
        reached = size_in_noise(rig, plain, simulate_sealed(rig, hidden, law, commands))
        off = abs(np.log(max(reached, 1e-6) / case.size))
        if best is None or off < nearest[1]:
            best, nearest = law, (reached, off)
        if off < np.log(SIZE_TOLERANCE):
            break
        # What breaks free or not makes the response jump: go at most a factor of six at a time.
        step = float(np.clip(case.size / max(reached, 1e-6), 1.0 / 6.0, 6.0))
        amount = float(np.clip(amount * step, _SMALLEST, _LARGEST))
    assert best is not None
    return best, nearest[0]
