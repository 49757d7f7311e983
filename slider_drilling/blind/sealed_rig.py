"""A sealed rig: drawn once, it can be run as often as one likes, and every run gives a log that hides the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.blind.cases import NO_EFFECT, SIZE_TOLERANCE, Case
from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS
from slider_drilling.blind.foreign.structure import Structure, draw_structure
from slider_drilling.blind.label import Label
from slider_drilling.blind.log_defects import LOG_DEFECTS
from slider_drilling.blind.manoeuvres import MANOEUVRES
from slider_drilling.blind.outside_laws import OUTSIDE_LAWS
from slider_drilling.blind.plant_law import LawFactory, PlantLaw, combine, no_effect
from slider_drilling.blind.recorder import RecorderModel, random_recorder_model, write_sealed_log
from slider_drilling.blind.sealed_plant import (
    PlantPerturbation,
    draw_start,
    random_perturbation,
    simulate_foreign,
    simulate_sealed,
    size_in_noise,
)
from slider_drilling.blind.wells import WELLS
from slider_drilling.diagnosis.drilling_programmes import ProgrammeLimits, programme_limits
from slider_drilling.drillstring import Commands, Response
from slider_drilling.rig import Rig

_LAWS: dict[str, LawFactory] = {**CATALOGUE_LAWS, **OUTSIDE_LAWS, NO_EFFECT: no_effect}
# Search for the amount that gives the target size. Ten times a usual amount is the limit: no top drive has a dead zone
# of two turns.
_TRIALS, _MAX_AMOUNT, _MIN_AMOUNT = 7, 10.0, 1e-3
# A law that makes the string break free or stick changes the response in a jump, so the amount changes in small steps.
_MAX_STEP = 6.0
# s between the starts of two runs of a rig.
_BETWEEN_RUNS_S = 1800.0


@dataclass(frozen=True)
class SealedRig:
    """A rig whose truth is sealed.

    Attributes:
        case: What it was drawn for.
        rig: The rig as its file states it.
        routine: Commands of its first run.
        laws: What the plant does besides, one for each effect.
        sizes: Size that each effect reaches alone in the first run, in noise floors.
        perturbation: How the plant's numbers differ from the file.
        structure: How a foreign plant's equations differ; None for one of the model's own.
        recorder: Errors of sensors and recorder.
        generator: Source of the first log's noise, as it stands after the draws.
        neutral: Response of the first run without any law, where it is known.
    """

    case: Case
    rig: Rig
    routine: Commands
    laws: tuple[PlantLaw, ...]
    sizes: tuple[float, ...]
    perturbation: PlantPerturbation
    structure: Structure | None
    recorder: RecorderModel
    generator: np.random.Generator
    neutral: Response

    @property
    def law(self) -> PlantLaw:
        """All laws together."""
        return self.laws[0] if len(self.laws) == 1 else combine(*self.laws)

    @property
    def limits(self) -> ProgrammeLimits:
        """What no run may exceed, by the rig file."""
        return programme_limits(self.rig)

    def label(self, log: str) -> Label:
        """The truth, for the log with this file name."""
        case, law = self.case, self.law
        structure: dict[str, Any] = {} if self.structure is None else asdict(self.structure)
        return Label(
            log=log, kind=case.kind, effects=tuple(law.name for law in self.laws if law.name != NO_EFFECT),
            sites=tuple((law.site, *law.other_sites) for law in self.laws if law.site is not None), size=case.size,
            sizes=self.sizes, well=case.well, manoeuvre=case.manoeuvre, seed=case.seed,
            depth_interval=law.depth_interval, plant=asdict(self.perturbation), recorder=asdict(self.recorder),
            log_defect=case.log_defect, structure=structure,
        )  # fmt: skip

    def first_run(self) -> tuple[Commands, Response]:
        """What the instruments show of the first run, without noise."""
        if self.structure is not None:
            return simulate_foreign(self.rig, self.perturbation, self.law, self.routine, self.structure, self.case.seed)
        if self.law.name == NO_EFFECT:
            return self.routine, self.neutral
        return self.routine, simulate_sealed(self.rig, self.perturbation, self.law, self.routine)

    def later_run(self, commands: Commands, number: int) -> tuple[Commands, Response]:
        """What the instruments show of a later run, without noise.

        It has its own start, and its own slow changes. Waves go on between the runs.

        Args:
            commands: What the controller asks for.
            number: Of the run, from 1 on.
        """
        start = draw_start(np.random.default_rng([self.case.seed, 4, number]))
        perturbation = replace(self.perturbation, start=start)
        law = _later(self.law, _BETWEEN_RUNS_S * number)
        if self.structure is None:
            return commands, simulate_sealed(self.rig, perturbation, law, commands)
        seed = int(np.random.default_rng([self.case.seed, 5, number]).integers(2**31))
        return simulate_foreign(self.rig, perturbation, law, commands, self.structure, seed)

    def record_later_run(self, path: Path, commands: Commands, number: int) -> Response:
        """Write the log of a later run, without the first log's defects of the recorder's set-up; returns the truth."""
        shown, response = self.later_run(commands, number)
        generator = np.random.default_rng([self.case.seed, 6, number])
        write_sealed_log(path, self.rig, shown, response, generator, self.recorder)
        return response


def draw_sealed_rig(case: Case, base: Rig) -> SealedRig:
    """Draw a sealed rig.

    Args:
        case: What to draw.
        base: Rig that wells, string and fluids are drawn from.
    """
    # The order of the draws defines the logs of a seed.
    generator = np.random.default_rng(case.seed)
    rig = WELLS[case.well](generator, base)
    commands = MANOEUVRES[case.manoeuvre](generator, rig, case.duration)
    # A generator of its own: the run is the same whatever its log leaves out.
    defect = LOG_DEFECTS[case.log_defect](np.random.default_rng([case.seed, 2]))
    perturbation, recorder = random_perturbation(generator), random_recorder_model(generator, defect)
    neutral = simulate_sealed(rig, perturbation, no_effect(generator, rig, 1.0), commands)
    drawn = []
    for name in case.effects:
        seed = int(generator.integers(2**31))
        drawn.append(law_of_size(_LAWS[name], case.size, rig, perturbation, commands, neutral, seed))
    # Sizes are those in the model's own plant. What the foreign plant differs by is drawn for every log alike.
    structure = draw_structure(np.random.default_rng([case.seed, 3])) if case.plant == "foreign" else None
    return SealedRig(
        case, rig, commands, tuple(law for law, _ in drawn), tuple(size for _, size in drawn), perturbation, structure,
        recorder, generator, neutral,
    )  # fmt: skip


def write_first_log(sealed: SealedRig, path: Path, twins: Sequence[Path] = ()) -> Label:
    """Write the log of the first run and return its label.

    Args:
        sealed: A rig that was just drawn.
        path: Of the log.
        twins: Paths of repeats: the same run with another draw of noise and losses each.
    """
    commands, response = sealed.first_run()
    write_sealed_log(path, sealed.rig, commands, response, sealed.generator, sealed.recorder)
    for number, twin in enumerate(twins):
        generator = np.random.default_rng([sealed.case.seed, 1, number])
        write_sealed_log(twin, sealed.rig, commands, response, generator, sealed.recorder)
    return sealed.label(path.name)


def _later(law: PlantLaw, seconds: float) -> PlantLaw:
    """The law in a run that starts so much later: what the rig does by the clock has gone on."""

    def change(commands: Commands) -> Commands:
        shifted = law.change_commands(replace(commands, time=commands.time + seconds))
        return replace(shifted, time=commands.time)

    return replace(law, change_commands=change)


def law_of_size(
    factory: LawFactory, wanted: float, rig: Rig, perturbation: PlantPerturbation, commands: Commands,
    neutral: Response, seed: int,
) -> tuple[PlantLaw, float]:  # fmt: skip
    """Returns the law whose size is nearest to the wanted one, and that size, in noise floors.

    Args:
        factory: Of the law.
        wanted: Size, in noise floors.
        rig: As its file states it.
        perturbation: How the plant's numbers differ from the file.
        commands: Of the run that the size is measured in.
        neutral: Response of that run without the law.
        seed: Of the law's own draws.
    """
    if wanted == 0.0:
        return factory(np.random.default_rng(seed), rig, 1.0), 0.0
    amount, best, best_size, best_error = 1.0, None, 0.0, np.inf
    for _ in range(_TRIALS):
        # The same draw each time: only the amount differs.
        law = factory(np.random.default_rng(seed), rig, amount)
        size = size_in_noise(rig, neutral, simulate_sealed(rig, perturbation, law, commands))
        error = abs(np.log(max(size, 1e-6) / wanted))
        if best is None or error < best_error:
            best, best_size, best_error = law, size, error
        if error < np.log(SIZE_TOLERANCE):
            break
        step = float(np.clip(wanted / max(size, 1e-6), 1.0 / _MAX_STEP, _MAX_STEP))
        amount = float(np.clip(amount * step, _MIN_AMOUNT, _MAX_AMOUNT))
    assert best is not None
    return best, best_size
