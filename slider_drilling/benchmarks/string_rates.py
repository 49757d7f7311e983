"""Speed of the string's step: a single run, a batch, and the bare arithmetic."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from slider_drilling.benchmarks.result import BenchmarkResult
from slider_drilling.benchmarks.timing import processor_seconds, wall_seconds
from slider_drilling.benchmarks.workload import ELEMENTS, RockingPlant, rocking_commands, variants
from slider_drilling.drillstring import kernel, simulate_batch
from slider_drilling.process.jit_cache import JIT_OPTIONS, njit
from slider_drilling.rig.example import example_rig

BATCH = 64
_CACHED = 96  # elements whose arrays, 18 kB, stay in any processor's first-level cache
_ARITHMETIC = "the step's loops on 96 elements, which stay in the first-level cache"


def string_rates() -> list[BenchmarkResult]:
    """Cost of an element-step in a single run and in a batch, and real-time factor, beside the bare arithmetic."""
    rig = example_rig()
    bare = arithmetic_ns()
    plant, duration = RockingPlant(rig), 30.0
    single = processor_seconds(lambda: plant.advance(duration)) / plant.element_steps(duration)
    wall = wall_seconds(lambda: plant.advance(duration))
    rigs, commands = variants(rig, BATCH), rocking_commands(rig, 20.0)

    def batch(narrow: bool) -> float:
        simulate_batch(rigs[:1], rocking_commands(rig, 0.1), single_precision=narrow)
        taken = processor_seconds(lambda: simulate_batch(rigs, commands, single_precision=narrow), repeats=3)
        return taken / (BATCH * plant.element_steps(20.0))

    double, narrow = batch(False), batch(True)
    steps_a_second = plant.element_steps(1.0)
    return [
        BenchmarkResult("single_ns_per_element_step", 1e9 * single, "ns", bare, _ARITHMETIC, f"{ELEMENTS} elements"),
        BenchmarkResult("batch_ns_per_element_step", 1e9 * double, "ns", bare, _ARITHMETIC,
               f"{BATCH} runs of {ELEMENTS} elements on one core, assembly included"),
        BenchmarkResult("single_precision_ns_per_element_step", 1e9 * narrow, "ns", 1e9 * double,
               "the same batch in double precision", "as a diagnosis simulates"),
        BenchmarkResult("real_time_factor", duration / wall, "-", 1e9 / (steps_a_second * bare),
               "the factor at the bare arithmetic's cost", f"{ELEMENTS} elements, all channels, one core"),
    ]  # fmt: skip


def machine_rates() -> list[BenchmarkResult]:
    """Cost of the square roots and exponentials that the step avoids."""
    values = np.linspace(0.1, 2.0, 4096)
    out = np.empty_like(values)
    root, exponential = (_ns_each(partial(function, values, out=out), len(values)) for function in (np.sqrt, np.exp))
    how = "vectorised, within the first-level cache, a value"
    return [
        BenchmarkResult("numpy_sqrt_ns", root, "ns", note=how),
        BenchmarkResult("numpy_exp_ns", exponential, "ns", note=how),
    ]


def arithmetic_ns() -> float:
    """Cost of a step's arithmetic without memory traffic, ns per element: the kernel's loops on few elements."""
    rounds = 2000
    constants = np.full((16, _CACHED), 0.1)
    moving = np.full((8, _CACHED), 0.1)
    polynomial = np.linspace(4.0, 0.1, 8)
    repeat_arithmetic(1, _CACHED, constants, moving, polynomial)
    return _ns_each(lambda: repeat_arithmetic(rounds, _CACHED, constants, moving, polynomial), rounds * _CACHED)


def _ns_each(work: Callable[[], object], count: int) -> float:
    return 1e9 * processor_seconds(work, repeats=15) / count


@njit(**JIT_OPTIONS)
def repeat_arithmetic(rounds, count, constants, moving, polynomial):
    """Sliding at constant speed: no forcing and no decay, so the numbers do not become denormal."""
    zero, one, some = constants[0], constants[1], constants[2]
    zero[:], one[:] = 0.0, 1.0
    place, angle, along, across, speed, rotation_speed, stretch, twist = (
        moving[0], moving[1], moving[2], moving[3], moving[4], moving[5], moving[6], moving[7]
    )  # fmt: skip
    force, weight, bend, turn, rough, soft, radius, yielding, still, fixed = (
        constants[3], constants[4], constants[5], constants[6], constants[7], constants[8], constants[9],
        constants[10], constants[11], constants[12],
    )  # fmt: skip
    for _ in range(rounds):
        kernel.compute_stretch(count, place, still, angle, fixed, stretch, twist)
        kernel.update_speeds(
            count, some, some, some, some, zero, zero, one, one, force, weight, bend, turn, rough, soft, radius,
            stretch, still, twist, fixed, along, across, speed, rotation_speed,
        )  # fmt: skip
        kernel.update_contacts(
            count, 1e-3, polynomial, 1.0, 1.0, 0.0, radius, yielding, False, zero, zero, speed,
            rotation_speed, along, across,
        )  # fmt: skip
        kernel.update_positions(count, 1e-3, speed, rotation_speed, place, angle)
