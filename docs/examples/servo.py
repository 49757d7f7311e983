"""The gap engine on a real servo: what does its simulation leave out, and how much does each effect close?

A position servo (Dynamixel XL330) swings a rigid arm. The model knows the arm, the motor, its firmware, and Coulomb and
viscous friction. Whatever else is at work is asked of the logs:

    python docs/examples/servo.py kp100_*.csv --test kp400_*.csv

and `--ask` says which swing would show most of what these logs leave open. A log is a CSV table with a header line, in
any order of columns: time_s, goal_rad, position_rad, and torque_enabled (0 where the motor is off; on all the time
where there is no such column). The firmware's gain stands in the file's name (kp100) or is given with --gain. Logs as
published (github.com/Rhoban/bam, JSON) are read too.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from servo_plant import COUNTS, Log

from slider_drilling.errors import InputError
from slider_drilling.gap import Channel, Effect, GapDiagnosis, LoggedRun, Manoeuvre, Parameter, SimulationOptions
from slider_drilling.gap.model import Array, Values

NUISANCE = (
    Parameter("arm", 0.0, 0.0, 0.15, 0.005, "kg", spread=0.02),
    Parameter("torque_constant", 0.387, 0.2, 0.7, 0.01, "N m/A", spread=0.04),
    Parameter("resistance", 4.0, 2.0, 8.0, 0.1, "ohm", spread=0.4),
    Parameter("armature", 1.8e-3, 1e-4, 1e-2, 1e-4, "kg m2", spread=6e-4),
    Parameter("coulomb", 0.0128, 0.0, 0.1, 1e-3, "N m", spread=0.006),
    Parameter("viscous", 0.0037, 0.0, 0.05, 5e-4, "N m s/rad", spread=0.002),
)
EFFECTS = (
    Effect(
        "stribeck", "gear",
        (Parameter("stribeck.drop", 0.0, -0.03, 0.2, 2e-3, "N m"),
         Parameter("stribeck.speed", 0.2, 0.01, 3.0, 0.05, "rad/s")),
        scan=((0.02, 0.05), (0.02, 0.2), (0.02, 1.0)), physical=(0.0, np.inf),
        nonphysical="friction that rises with speed", law="friction + drop exp(-|v| / speed)",
    ),
    Effect(
        "load_friction_motor", "gear", (Parameter("load_friction_motor.share", 0.0, 0.0, 1.0, 0.02),),
        scan=((0.05,), (0.2,), (0.5,)), law="friction + share |motor torque|",
    ),
    Effect(
        "load_friction_external", "gear", (Parameter("load_friction_external.share", 0.0, 0.0, 1.0, 0.02),),
        scan=((0.05,), (0.2,), (0.5,)), law="friction + share |torque of the weight|",
    ),
    Effect(
        "quadratic_load", "gear", (Parameter("quadratic_load.factor", 0.0, 0.0, 5.0, 0.05, "1/(N m)"),),
        scan=((0.1,), (0.5,), (1.5,)), law="friction + factor (motor torque - torque of the weight)^2",
    ),
    Effect(
        "backlash", "gear", (Parameter("backlash.angle", 0.0, 0.0, 0.2, 2e-3, "rad"),),
        scan=((0.005,), (0.02,), (0.06,)), law="dead zone between gear and arm",
    ),
    Effect(
        "encoder_offset", "encoder", (Parameter("encoder_offset.angle", 0.0, -0.3, 0.3, 5e-3, "rad"),),
        scan=((0.02,), (-0.02,), (0.06,)), law="arm's angle = angle shown + offset",
    ),
    Effect(
        "supply_sag", "supply", (Parameter("supply_sag.resistance", 0.0, 0.0, 8.0, 0.1, "ohm"),),
        scan=((0.3,), (1.0,), (3.0,)), law="supply - resistance x supply current",
    ),
    Effect(
        "motor_heating", "motor", (Parameter("motor_heating.per_joule", 0.0, 0.0, 1.0, 0.01, "1/J"),),
        scan=((0.02,), (0.1,), (0.4,)), law="winding resistance x (1 + per_joule x heat)",
    ),
    Effect(
        "delay", "firmware", (Parameter("delay.time", 0.0, 0.0, 0.06, 1e-3, "s"),),
        scan=((0.004,), (0.012,), (0.03,)), law="the motor acts on error of a while ago",
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Servo:
    """The model that the engine sees: one run a log."""

    logs: tuple[Log, ...]
    nuisance: tuple[Parameter, ...] = NUISANCE
    effects: tuple[Effect, ...] = EFFECTS

    @property
    def runs(self) -> tuple[LoggedRun, ...]:
        """Each log with its one channel, the angle that the encoder shows."""
        return tuple(_run(log) for log in self.logs)

    def simulate(self, run: int, sets: Sequence[Values], options: SimulationOptions) -> Mapping[str, Array]:
        """See `slider_drilling.gap.model.Model`; a simulation is so cheap that there is no cheaper one to ask for."""
        return {"position": self.logs[run].swing(sets)}

    def truncated(self, fraction: float) -> Servo:
        """The first part of every log."""
        kept = []
        for log in self.logs:
            inside = log.time <= log.time[0] + fraction * (log.time[-1] - log.time[0])
            parts = {name: getattr(log, name)[inside] for name in ("time", "goal", "position", "enabled")}
            kept.append(replace(log, **parts))
        return replace(self, logs=tuple(kept))

    @property
    def programme_duration(self) -> float:
        """See `slider_drilling.gap.model.HasProgrammes`; s, as the published logs."""
        return 6.0

    def programmes(self, duration: float) -> ServoProgrammes:
        """See `slider_drilling.gap.model.HasProgrammes`."""
        return ServoProgrammes(self, duration)


@dataclass(frozen=True)
class ServoProgrammes:
    """What the servo may be asked to do: swing in two ways, then lift the arm and let it drop (`gap.model.Programmes`).

    Attributes:
        model: The servo.
        duration: Of a test, s.
        largest_angle: rad, of the arm from where it hangs.
        largest_speed: rad/s, of the arm; published logs reach 13.
    """

    model: Servo
    duration: float
    largest_angle: float = 1.6
    largest_speed: float = 12.0
    variables: tuple[Parameter, ...] = (
        Parameter("gain", 100.0, 50.0, 800.0, 25.0),
        Parameter("amplitude_1", 0.8, 0.1, 1.6, 0.1, "rad"), Parameter("period_1", 2.0, 0.4, 6.0, 0.2, "s"),
        Parameter("amplitude_2", 0.8, 0.1, 1.6, 0.1, "rad"), Parameter("period_2", 2.0, 0.4, 6.0, 0.2, "s"),
        Parameter("lifted_to", 1.0, -1.5, 1.5, 0.1, "rad"), Parameter("lift_share", 0.0, 0.0, 0.6, 0.05),
    )  # fmt: skip
    starts: tuple[Mapping[str, float], ...] = ({}, {"gain": 200.0, "period_2": 0.8, "lift_share": 0.4})

    @property
    def fixed(self) -> Mapping[str, Manoeuvre]:
        """Routine: one sine at the lowest published gain."""
        return {"routine": self.programme({})}

    def programme(self, values: Values) -> Manoeuvre:
        """Half of the time that lifting leaves is for each swing; the motor is off while the arm drops."""
        number = {each.name: float(values.get(each.name, each.nominal)) for each in self.variables}
        time = np.arange(int(self.duration * 200.0)) / 200.0
        lift = self.duration * (1.0 - number["lift_share"])
        drop = self.duration * (1.0 - 0.4 * number["lift_share"])
        goal = np.where(
            time < 0.5 * lift, _sine(time, number["amplitude_1"], number["period_1"]),
            _sine(time - 0.5 * lift, number["amplitude_2"], number["period_2"]),
        )  # fmt: skip
        lifted = time >= lift
        goal[lifted] = number["lifted_to"] * np.minimum((time[lifted] - lift) / (0.5 * (drop - lift)), 1.0)
        log = Log("planned", number["gain"], time, goal, np.zeros_like(time), (time < drop).astype(float))
        words = "; ".join(
            f"swing {number[f'amplitude_{k}']:.2f} rad in {number[f'period_{k}']:.1f} s for {0.5 * lift:.1f} s"
            for k in (1, 2)
        )
        if number["lift_share"] > 0.0:
            words += (
                f"; lift to {number['lifted_to']:.2f} rad and switch off {self.duration - drop:.1f} s before the end"
            )
        return Manoeuvre(f"gain {number['gain']:.0f}: {words}", number, replace(self.model, logs=(log,)))

    def limit_use(self, manoeuvre: Manoeuvre, sets: Sequence[Values]) -> Array:
        """The larger of the shares of angle and speed."""
        run = manoeuvre.model.runs[0]
        angle = np.asarray(manoeuvre.model.simulate(0, sets, SimulationOptions())["position"])
        speed = np.gradient(angle, run.time, axis=1)
        return np.asarray(np.maximum(np.max(np.abs(angle), axis=1) / self.largest_angle,
                                     np.max(np.abs(speed), axis=1) / self.largest_speed))  # fmt: skip


def _sine(time: Array, amplitude: float, period: float) -> Array:
    return np.asarray(amplitude * np.sin(2.0 * math.pi * time / period))


def _run(log: Log) -> LoggedRun:
    position = Channel("position", log.time, log.position, "rad", resolution=2.0 * math.pi / COUNTS)
    return LoggedRun(log.name, log.time, log.goal, (position,), command="the goal", command_unit="rad")


def read_servo_log(path: Path, gain: float | None = None) -> Log:
    """A log from its table. Raises InputError naming file and column for one that cannot be used."""
    try:
        rows = _published_rows(path) if path.suffix == ".json" else _table_rows(path)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from None
    if len(rows) < 10:
        raise InputError(f"{path}: {len(rows)} rows; a log has at least ten below its header line")
    time, goal, position = (_column(path, rows, name) for name in ("time_s", "goal_rad", "position_rad"))
    enabled = _column(path, rows, "torque_enabled") if "torque_enabled" in rows[0] else np.ones_like(time)
    if np.any(np.diff(time) <= 0.0):
        raise InputError(f"{path}: time_s does not ascend in row {int(np.argmax(np.diff(time) <= 0.0)) + 2}")
    named = re.search(r"kp(\d+)", path.name)
    if gain is None and named is None:
        raise InputError(f"{path}: no gain in its name (kp100); give it with --gain")
    return Log(path.stem, gain if gain is not None else float(named.group(1)), time, goal, position, enabled)  # type: ignore[union-attr]


def _table_rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return [row for row in csv.DictReader(file, skipinitialspace=True) if any(row.values())]


def _published_rows(path: Path) -> list[dict[str, str]]:
    entries = json.loads(path.read_text(encoding="utf-8"))["entries"]
    columns = {"time_s": "timestamp", "goal_rad": "goal_position", "position_rad": "position"}
    return [
        {name: str(entry[key]) for name, key in columns.items()} | {"torque_enabled": str(int(entry["torque_enable"]))}
        for entry in entries
    ]


def _column(path: Path, rows: Sequence[Mapping[str, str]], name: str) -> Array:
    if name not in rows[0]:
        raise InputError(f"{path}: has no column {name}; its columns are {', '.join(map(str, rows[0]))}")
    try:
        values = np.array([float(row[name]) for row in rows])
    except (TypeError, ValueError) as error:
        raise InputError(f"{path}: {name}: {error}") from None
    if not np.isfinite(values).all():
        raise InputError(
            f"{path}: {name} = {values[~np.isfinite(values)][0]} in row {np.argmin(np.isfinite(values)) + 1}"
        )
    return values


def errors(logs: Sequence[Log], values: Values) -> list[float]:
    """RMS of measured minus simulated, rad, of each log."""
    return [float(np.sqrt(np.mean((log.swing([values])[0] - log.position) ** 2))) for log in logs]


def closed(logs: Sequence[Log], before: Values, after: Values) -> float:
    """Share of the squared error of logs that these values take away from those; below zero where they add to it."""
    left, was = (sum(error**2 for error in errors(logs, values)) for values in (after, before))
    return 1.0 - left / was


def candidate_lines(answer: GapDiagnosis, unseen: Sequence[Log]) -> list[str]:
    """What each candidate closes: of the fitted logs, and of the gap in logs that no fit has seen; which closes most of
    these among indistinguishable ones.
    """
    steps = [taken for taken in answer.state.steps if taken.accepted is not None]
    known = {(): answer.state.calibrated} | {taken.accepted.fitted.names: taken.accepted.fitted for taken in steps}
    lines, elsewhere = [], {}
    for entry in answer.candidates:
        found, before = entry.fitted.fit.values, known.get(entry.beside)
        values = ", ".join(f"{p.name} {found[p.name]:.4g}" for p in entry.effect.parameters)
        low, high = entry.interval
        said = f"  {entry.effect.name} closes {entry.closed:.2f} [{low:.2f}, {high:.2f}]"
        if entry.beside:
            said += f" of what {' and '.join(entry.beside)} {'leaves' if len(entry.beside) == 1 else 'leave'}"
        if entry.closed_in_other_runs is not None:
            said += f", of each fitted log by the rest {entry.closed_in_other_runs[0]:.2f}"
        if unseen and before is not None:
            elsewhere[entry.effect.name] = closed(unseen, before.fit.values, found)
            said += f", of logs that no fit has seen {elsewhere[entry.effect.name]:.2f}"
        lines.append(f"{said}; {values}: {'; '.join(entry.failures) or 'passed'}")
    for name, others in answer.indistinguishable.items():
        alike = [one for one in (name, *others) if one in elsewhere]
        if len(alike) > 1:
            best = max(alike, key=lambda one: elsewhere[one])
            names = " and ".join(alike)
            lines.append(
                f"Of {names}, which the fitted logs cannot distinguish, {best} closes most of the gap in the logs that "
                "no fit has seen."
            )
    return lines


def asked_lines(answer: GapDiagnosis, evaluations: int = 150) -> list[str]:
    """The swing to ask the servo for next, and the size from which each effect shows without and with it."""
    from slider_drilling.gap.experiment_design.knowledge import after_logs
    from slider_drilling.gap.experiment_design.plan import plan_run

    model = answer.state.current.problem.model
    assert isinstance(model, Servo)
    knowledge = after_logs(answer.state, model.effects)
    plan = plan_run(knowledge, model.programmes(model.programme_duration), evaluations=evaluations)
    before = {each.name: each.size.amplitude for each in plan.baseline.effects}
    lines = [f"Ask next: {plan.planned.manoeuvre.description}"]
    for each in plan.planned.prospect.effects:
        unit = each.shape.effect.parameters[0].unit
        lines.append(
            f"  {each.name} would show from {each.size.amplitude:.3g} {unit}, now from {before[each.name]:.3g}"
        )
    return lines


def main(arguments: Sequence[str] | None = None) -> int:
    """Diagnose the logs and print what was found, and what it does to logs that no fit has seen."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("logs", nargs="+", type=Path, help="tables to diagnose")
    parser.add_argument("--test", nargs="*", type=Path, default=[], help="tables that no fit sees")
    parser.add_argument("--gain", type=float, help="of the firmware, where the file's name does not have it")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--ask", action="store_true", help="plan the next swing")
    given = parser.parse_args(arguments)
    from slider_drilling.gap import explain

    try:
        logs, unseen = ([read_servo_log(path, given.gain) for path in paths] for paths in (given.logs, given.test))
    except InputError as error:
        print(f"Error: {error}", file=sys.stderr)
        return 2
    answer = explain(Servo(tuple(logs)), seed=given.seed)
    print(answer.sentence)
    print(f"  {answer.simulation_count} simulations, {answer.runtime:.1f} s")
    for line in candidate_lines(answer, unseen):
        print(line)
    for title, some in (("fitted", logs), ("not fitted", unseen)):
        for log, before, after in zip(some, errors(some, {}), errors(some, answer.parameters), strict=True):
            print(f"  {title:10s} {log.name:36s} RMS {1e3 * before:6.1f} -> {1e3 * after:6.1f} mrad")
    for line in asked_lines(answer) if given.ask else ():
        print(line)
    return 0


if __name__ == "__main__":
    sys.exit(main())
