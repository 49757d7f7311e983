"""Detectable sizes, predicted against found: how large an effect must be for its evidence in half of all logs.

    python -m slider_drilling.benchmarks.detectable_sizes model|foreign [EFFECT ...]

The run is the commissioning programme in the example well. Predicted: by the planner, before any log. Found: on sealed
plants, each with its own mesh, numbers, noise and form of the law, by the likelihood of the true effect alone
(`slider_drilling.blind.evidence_for_truth`). On plants of foreign structure an effect may have its evidence without
being there: what the structure does looks like it. Sizes go up after a miss and down after a hit (Dixon and Mood,
Journal of the American Statistical Association 43, 1948), from the predicted size on.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import exp
from pathlib import Path

import numpy as np

from slider_drilling.blind.cases import PLANTS
from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS
from slider_drilling.blind.evidence_for_truth import as_diagnosis, evidence_for
from slider_drilling.blind.foreign.structure import draw_structure
from slider_drilling.blind.log_defects import LOG_DEFECTS
from slider_drilling.blind.plant_law import no_effect
from slider_drilling.blind.recorder import random_recorder_model, write_sealed_log
from slider_drilling.blind.sealed_plant import (
    INTERVAL_S,
    random_perturbation,
    simulate_foreign,
    simulate_sealed,
    size_in_noise,
)
from slider_drilling.blind.sealed_rig import law_of_size
from slider_drilling.diagnosis.build_model import model_without_logs
from slider_drilling.drillstring import Commands
from slider_drilling.files.installed_files import installed_file
from slider_drilling.gap.experiment_design.criterion import planned_information
from slider_drilling.gap.experiment_design.detectable_size import ProbedShape, evident_amplitude
from slider_drilling.gap.experiment_design.knowledge import before_any_log
from slider_drilling.log import read_log
from slider_drilling.programmes import load_programme, open_loop_commands
from slider_drilling.rig import Rig, load_rig

TRIALS, _STEP, _FIRST_SEED = 8, 1.6, 7400
# Elements of the plants: a mesh that no diagnosis uses, and cheap.
_ELEMENTS = 90
_MOST, _LEAST = 30.0, 0.02  # noise levels


@dataclass(frozen=True)
class Detectable:
    """One effect; sizes are RMS changes of the most affected channel in noise levels.

    Attributes:
        name: Of the effect.
        predicted: Size that has its evidence in half of all logs, by the planner.
        found: The same on sealed plants.
        hits: Whether the evidence was there, trial by trial.
    """

    name: str
    predicted: float
    found: float
    hits: tuple[bool, ...]

    @property
    def ratio(self) -> float:
        """Found over predicted."""
        return self.found / self.predicted


class Commissioning:
    """The example rig in the commissioning programme, as the planner sees it.

    Args:
        plant: ``model``, whose equations are the model's own, so that the model's error is none; or ``foreign``.
    """

    def __init__(self, plant: str = "model") -> None:
        self.plant = plant
        self.rig: Rig = load_rig(installed_file("config/rig.example.yaml"))
        programme = load_programme(installed_file("config/programmes/commissioning.yaml"))
        self.commands: Commands = open_loop_commands(programme, self.rig, INTERVAL_S)
        seconds = float(self.commands.time[-1])
        self._model = model_without_logs(self.rig, seconds)
        self._programmes = self._model.programmes(seconds)
        self._run = self._programmes.fixed["commissioning"]
        none = dict.fromkeys(("surface_torque", "hook_load", "standpipe_pressure"), 0.0)
        self._knowledge = replace(before_any_log(self._model), model_error=none if plant == "model" else {})
        self._shapes = self._knowledge.shapes()
        information = planned_information(self._knowledge, self._run, self._shapes)
        schur, _ = information.beyond_free()
        self._seen = dict(zip(information.changes, np.diag(schur), strict=True))

    def predicted(self, name: str) -> float:
        """Size, noise levels, that has its evidence in half of all logs: the median of an effect's shapes."""
        shapes = [shape for shape in self._shapes if shape.effect.name == name]
        sizes = sorted(self._size(shape, self._amplitude(shape)) for shape in shapes)
        return sizes[len(sizes) // 2]

    def _amplitude(self, shape: ProbedShape) -> float:
        seen = np.array([self._seen[shape.name(point)] for point in shape.points])
        return evident_amplitude(shape, seen, self._knowledge.candidates, 0.5)

    def _size(self, shape: ProbedShape, amplitude: float) -> float:
        parameter, point = shape.effect.parameters[0], shape.points[0]
        sign = 1.0 if point[0] >= parameter.nominal else -1.0
        value = min(max(parameter.nominal + sign * amplitude, parameter.lower), parameter.upper)
        sets = [{}, shape.effect.values((value, *point[1:]))]
        neutral, changed = self._programmes.responses(self._run, sets)
        return size_in_noise(self.rig, neutral, changed)


def detectable(run: Commissioning, name: str, trials: int = TRIALS, first_seed: int = _FIRST_SEED) -> Detectable:
    """Find the size of one effect by a staircase.

    Args:
        run: The rig and its programme.
        name: Of the effect.
        trials: Plants to try.
        first_seed: Of the first plant.
    """
    predicted = run.predicted(name)
    size, tried, hits = min(max(predicted, _LEAST), _MOST), [], []
    for seed in range(first_seed, first_seed + trials):
        reached, hit = _trial(run, name, size, seed)
        tried.append(reached)
        hits.append(hit)
        size = min(max(size / _STEP if hit else size * _STEP, _LEAST), _MOST)
    # The first sizes depend on where the staircase began; the next one to try counts, too.
    found = exp(float(np.mean(np.log([*tried[2:], size]))))
    return Detectable(name, predicted, found, tuple(hits))


def _trial(run: Commissioning, name: str, size: float, seed: int) -> tuple[float, bool]:
    """Size that the law of one plant reaches, and whether its log has the evidence."""
    generator = np.random.default_rng(seed)
    perturbation = replace(random_perturbation(generator), elements=_ELEMENTS)
    recorder = random_recorder_model(generator, LOG_DEFECTS["none"](generator))
    law_seed = int(generator.integers(2**31))
    neutral = simulate_sealed(run.rig, perturbation, no_effect(generator, run.rig, 1.0), run.commands)
    law, reached = law_of_size(
        CATALOGUE_LAWS[name], size, run.rig, perturbation, run.commands, neutral, law_seed
    )
    if run.plant == "foreign":
        structure = draw_structure(np.random.default_rng([seed, 3]))
        shown, response = simulate_foreign(run.rig, perturbation, law, run.commands, structure, seed)
    else:
        shown, response = run.commands, simulate_sealed(run.rig, perturbation, law, run.commands)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        write_sealed_log(path, run.rig, shown, response, generator, recorder)
        tree = evidence_for([read_log(path)], [name])
    return max(reached, 1e-6), name in as_diagnosis(tree).named_effects


def table(plant: str, names: Sequence[str]) -> Iterator[str]:
    """The lines of a Markdown table."""
    run = Commissioning(plant)
    yield "| effect | predicted | found | found / predicted | evidence, trial by trial |"
    yield "|---|---|---|---|---|"
    for name in names:
        row = detectable(run, name)
        marks = "".join("+" if hit else "-" for hit in row.hits)
        yield f"| {row.name} | {row.predicted:.2f} | {row.found:.2f} | {row.ratio:.2f} | {marks} |"


if __name__ == "__main__":
    kind, *chosen = sys.argv[1:] or ["model"]
    if kind not in PLANTS or not set(chosen) <= set(CATALOGUE_LAWS):
        sys.exit(f"give model or foreign, then effects of {', '.join(CATALOGUE_LAWS)}")
    for line in table(kind, chosen or tuple(CATALOGUE_LAWS)):
        print(line, flush=True)
