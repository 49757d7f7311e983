"""The gap engine on public recordings of real machines: what is found, and what it closes where no fit has looked."""

from __future__ import annotations

import importlib.util
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from slider_drilling.benchmarks.machine_records import find_records, records_folder
from slider_drilling.benchmarks.result import BenchmarkResult
from slider_drilling.gap import GapDiagnosis, explain

_EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


@dataclass(frozen=True)
class Machine:
    """A real machine with recordings.

    Attributes:
        name: Of its folder of recordings and of its example.
        title: What it is.
        model: Name of the example's model.
        reader: Name of the example's function that reads a recording.
        fitted: Names of the recordings that are fitted.
        unseen: Names of those that no fit sees.
    """

    name: str
    title: str
    model: str
    reader: str
    fitted: tuple[str, ...]
    unseen: tuple[str, ...]


_TRAJECTORIES = ("sin_sin", "lift_and_drop", "up_and_down", "sin_time_square")
MACHINES = (
    Machine("emps", "machine axis (EMPS), force; unseen: the record with pulses", "Axis", "read_record",
            ("DATA_EMPS.mat",), ("DATA_EMPS_PULSES.mat",)),
    Machine("servo", "position servo (XL330), angle; fitted at gain 200, unseen at gain 800", "Servo", "read_servo_log",
            tuple(f"xl330_kp200_{name}.json" for name in _TRAJECTORIES),
            tuple(f"xl330_kp800_{name}.json" for name in _TRAJECTORIES)),
    Machine("robot_joint", "robot joint (Franka), torque; unseen: the middle speed", "Joint", "read_record",
            ("case4_slow.csv", "case4_high.csv"), ("case4_middle.csv",)),
)  # fmt: skip


@dataclass(frozen=True)
class MachineAnswer:
    """What the engine finds on a machine.

    Attributes:
        machine: The machine.
        answer: The engine's answer.
        closed_calibrated: Share of the unseen squared error as given that calibration closes.
        closed_unseen: Share of what calibration leaves there that the named effects close, None without any.
        seconds: Wall time.
    """

    machine: Machine
    answer: GapDiagnosis
    closed_calibrated: float
    closed_unseen: float | None
    seconds: float


def example_module(name: str) -> ModuleType:
    """An example of ``docs/examples`` as a module.

    Raises:
        FileNotFoundError: This installation has no examples.
    """
    if name in sys.modules and getattr(sys.modules[name], "__file__", None) == str(_EXAMPLES / f"{name}.py"):
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, _EXAMPLES / f"{name}.py")
    if spec is None or spec.loader is None or not (_EXAMPLES / f"{name}.py").is_file():
        raise FileNotFoundError(f"{_EXAMPLES / name}.py")
    module = importlib.util.module_from_spec(spec)
    # Examples may import each other.
    if str(_EXAMPLES) not in sys.path:
        sys.path.append(str(_EXAMPLES))
    # Dataclasses look their module up.
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def diagnose_machine(machine: Machine, folder: Path) -> MachineAnswer | None:
    """Diagnose a machine's recordings, None where they are missing."""
    paths = find_records(machine.name, folder)
    if paths is None:
        return None
    example = example_module(machine.name)
    read = getattr(example, machine.reader)
    fitted, unseen = ([read(paths[name]) for name in names] for names in (machine.fitted, machine.unseen))
    started = time.perf_counter()
    answer = explain(getattr(example, machine.model)(tuple(fitted)))
    seconds = time.perf_counter() - started
    calibrated = answer.state.calibrated.fit.values
    closed = example.closed(unseen, calibrated, answer.parameters) if answer.effects else None
    return MachineAnswer(machine, answer, example.closed(unseen, {}, calibrated), closed, seconds)


def machine_results(machines: Sequence[Machine] = MACHINES) -> list[BenchmarkResult]:
    """A row for each machine; without a value where its recordings or the examples are missing."""
    return [_result(machine) for machine in machines]


def _result(machine: Machine) -> BenchmarkResult:
    name, folder = f"{machine.name}_unseen_gap_closed", records_folder()
    try:
        found = diagnose_machine(machine, folder)
    except FileNotFoundError as error:
        return BenchmarkResult(name, None, "-", note=f"not available: no example {error}")
    if found is None:
        fetch = "python -m slider_drilling.benchmarks.machine_records"
        return BenchmarkResult(name, None, "-", note=f"not available: no recordings in {folder}; {fetch} fetches them")
    answer = found.answer
    named = " and ".join(answer.effects) or f"nothing ({answer.verdict})"
    gaps = f"E {answer.gap_nominal:.3g} as given, {answer.gap_calibrated:.3g} calibrated"
    gaps += f", {answer.gap_with_effects:.3g} with it" if answer.effects else ""
    note = f"{machine.title}; named: {named}; {gaps}; {answer.simulation_count} simulations, {found.seconds:.0f} s"
    return BenchmarkResult(
        name,
        found.closed_unseen,
        "-",
        found.closed_calibrated,
        "share that calibration closes of the gap as given",
        note,
    )
