"""Cost against elements, runs and threads."""

from __future__ import annotations

from slider_drilling.benchmarks.timing import processor_seconds, wall_seconds
from slider_drilling.benchmarks.workload import RockingPlant, rocking_commands, variants
from slider_drilling.drillstring import simulate_batch
from slider_drilling.rig.example import example_rig

ELEMENTS = (25, 50, 100, 200, 500, 1000, 2000)
RUNS = (1, 2, 4, 8, 16, 32, 64, 128, 256)
WORK = 2e7  # element-steps a measurement


def by_elements() -> list[tuple[int, float]]:
    """ns of processor time per element-step of a single run."""
    rows = []
    for elements in ELEMENTS:
        plant = RockingPlant(example_rig(), elements)
        duration = max(round(WORK / plant.element_steps(1.0), 1), 0.2)
        seconds = processor_seconds(lambda p=plant, d=duration: p.advance(d))
        rows.append((elements, 1e9 * seconds / plant.element_steps(duration)))
    return rows


def by_runs(elements: int = 200) -> list[tuple[int, float]]:
    """ns of processor time per element-step of a batch on one core, assembly included."""
    rig = example_rig()
    steps = RockingPlant(rig, elements).element_steps(1.0)
    rows = []
    for runs in RUNS:
        duration = max(round(4.0 * WORK / steps / runs, 1), 5.0)
        rigs, commands = variants(rig, runs), rocking_commands(rig, duration)
        seconds = processor_seconds(lambda r=rigs, c=commands: simulate_batch(r, c, elements), 3)
        rows.append((runs, 1e9 * seconds / (steps * duration * runs)))
    return rows


def by_threads(runs: int = 64) -> list[tuple[int, float]]:
    """Wall s of a batch of 60 s on one, two and four threads."""
    rig = example_rig()
    rigs, commands = variants(rig, runs), rocking_commands(rig, 60.0)
    return [
        (workers, wall_seconds(lambda w=workers: simulate_batch(rigs, commands, workers=w), 3)) for workers in (1, 2, 4)
    ]


def table(first: str, second: str, rows: list[tuple[int, float]], form: str) -> str:
    """A table of two columns."""
    lines = [f"| {first} | {second} |", "|---|---|"]
    return "\n".join([*lines, *(f"| {count} | {value:{form}} |" for count, value in rows)])


if __name__ == "__main__":
    print(table("elements", "ns per element-step", by_elements(), ".2f"))
    print(table("runs", "ns per element-step", by_runs(), ".2f"))
    print(table("threads", "s", by_threads(), ".2f"))
