"""Run times for the problem sizes of published models, with all of our physics.

The published times are from their papers and machines; they are not measured here.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from slider_drilling.benchmarks.timing import wall_seconds
from slider_drilling.benchmarks.workload import rocking_commands
from slider_drilling.drillstring import simulate
from slider_drilling.rig import Rig
from slider_drilling.rig.example import example_rig


@dataclass(frozen=True)
class PublishedRun:
    """A published run: elements, length of the string in m, simulated time and published run time in s."""

    name: str
    elements: int
    length: float
    duration: float
    seconds: float


RUNS = (
    PublishedRun("torsional waves of Aarsnes and Shor, Octave", 1000, 2500.0, 60.0, 13.0),
    PublishedRun("Dixit's model of ExxonMobil, Python", 45, 4000.0, 60.0, 27.0),
)


def compare() -> list[tuple[PublishedRun, float]]:
    """Each published run and our run time for the same size, s."""
    rows = []
    for run in RUNS:
        rig = shortened(example_rig(), run.length)
        commands = rocking_commands(rig, run.duration)
        simulate(rig, rocking_commands(rig, 0.2), run.elements)
        rows.append((run, wall_seconds(lambda r=rig, c=commands, n=run.elements: simulate(r, c, n), 5)))
    return rows


def shortened(rig: Rig, length: float) -> Rig:
    """The rig with its top pipe shortened to give the string this length, m."""
    first, *rest = rig.string.sections
    first = dataclasses.replace(first, length=first.length + length - rig.string.length)
    intervals = tuple(
        dataclasses.replace(interval, to=min(interval.to, length)) for interval in rig.well.friction_intervals
    )
    return dataclasses.replace(
        rig,
        string=dataclasses.replace(rig.string, sections=(first, *rest)),
        well=dataclasses.replace(rig.well, friction_intervals=intervals),
    )


def markdown(rows: list[tuple[PublishedRun, float]]) -> str:
    """A table."""
    lines = ["| run | published | ours | times faster |", "|---|---|---|---|"]
    for run, seconds in rows:
        size = f"{run.elements} elements, {run.length / 1000.0:g} km, {run.duration:g} s"
        lines.append(f"| {run.name}: {size} | {run.seconds:g} s | {seconds:.3f} s | {run.seconds / seconds:.0f} |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(markdown(compare()))
