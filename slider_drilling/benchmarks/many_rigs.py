"""Speed of many rigs at once, as those need who train controllers."""

from __future__ import annotations

import importlib.util
import time

import numpy as np

from slider_drilling.benchmarks.result import BenchmarkResult
from slider_drilling.benchmarks.timing import processor_seconds, wall_seconds

SLOTS, DRAWN, ELEMENTS = 512, 64, 40
STEPS = 40  # per slot
_SINGLE_STEPS = 200
REPEATS = 3


def environment_rates() -> list[BenchmarkResult]:
    """Steps a second of a vector environment beside a loop over single ones, and with foreign plants."""
    names = ("environment_steps_per_s", "environment_steps_per_core_s", "environment_samples_per_s",
             "foreign_environment_steps_per_s")  # fmt: skip
    if importlib.util.find_spec("gymnasium") is None:
        note = "not available: gymnasium is not installed (pip install 'slider_drilling[gym]')"
        return [BenchmarkResult(name, None, "1/s", note=note) for name in names]
    single = 1.0 / _single_step()
    (held, per_core), (sampled, _), (foreign, _) = _rates(10, 0.0), _rates(1, 0.0), _rates(10, 1.0)
    about = f"{SLOTS} slots on {DRAWN} drawn rigs of {ELEMENTS} elements, all cores"
    loop = "a loop over single environments on one core"
    return [
        BenchmarkResult(names[0], held, "1/s", single, loop, f"{about}; a step is ten samples, 1 s"),
        BenchmarkResult(names[1], per_core, "1/s", single, loop, "as the first, by processor time of all threads"),
        BenchmarkResult(names[2], sampled, "1/s", note=f"{about}; a step is one sample, 0.1 s"),
        BenchmarkResult(names[3], foreign, "1/s", held, "plants of our own structure", "as the first; foreign plants"),
    ]


def _rates(samples: int, foreign: float) -> tuple[float, float]:
    """Steps a second, by the clock and by the processor time of all threads."""
    from slider_drilling.api.vector_env import vector_env

    environment = vector_env(SLOTS, drawn=DRAWN, foreign=foreign, samples=samples, elements=ELEMENTS)
    environment.reset(seed=0)
    actions = np.tile(np.array([0.0, 0.0025], np.float32), (SLOTS, 1))
    environment.step(actions)

    def rock() -> None:
        for step in range(STEPS):
            actions[:, 0] = 3.0 * np.sin(0.25 * step)
            environment.step(actions)

    started = time.process_time()
    wall = wall_seconds(rock, REPEATS)
    return SLOTS * STEPS / wall, REPEATS * SLOTS * STEPS / (time.process_time() - started)


def _single_step() -> float:
    """Seconds of a step of one environment, of a rig of the same kind."""
    from slider_drilling.training.registered import make_slide

    environments = [make_slide(number, elements=ELEMENTS) for number in range(4)]
    for environment in environments:
        environment.reset(seed=0)
    action = np.array([0.0, 0.0025], np.float32)

    def rock() -> None:
        for step in range(_SINGLE_STEPS // len(environments)):
            action[0] = 3.0 * np.sin(0.25 * step)
            for environment in environments:
                environment.step(action)

    return processor_seconds(rock, REPEATS) / _SINGLE_STEPS
