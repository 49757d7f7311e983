"""The gap engine on a joint of a real robot arm: what does Coulomb and viscous friction leave out?

The seventh joint of a Franka arm on a circle, at three speeds: angle, speed, and the joint's torque without gravity and
inertia, as measured for "NNFM: A novel neural network modeling approach for robot flexible joints friction"
(github.com/longshike). The model as given is the authors' Coulomb and viscous friction. Measured motion drives it:

    python docs/examples/robot_joint.py case4_slow.csv case4_high.csv --test case4_middle.csv

`python -m slider_drilling.benchmarks.machine_records DIR` fetches the tables and checks them.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.signal import butter, filtfilt

from slider_drilling.errors import InputError
from slider_drilling.gap import Channel, Effect, GapDiagnosis, LoggedRun, Parameter, SimulationOptions
from slider_drilling.gap.model import Array, Values
from slider_drilling.process.jit_cache import JIT_OPTIONS, njit

CUTOFF = 5.0  # Hz: the arm's own vibration starts above
_INTERVAL = 0.004  # s, to which the tables are brought: their time stamps jitter by some milliseconds
_KEPT = 10
NOISE = 0.02  # N m, of the torque sensor
_EDGE = 100  # samples left out at either end, where filters are off
_UNIT_SPEED = 0.1  # rad/s, at which the power term has its torque

# Every parameter of the model at its nominal value, as the authors fitted them.
NOMINAL = {
    "coulomb": 0.1512,  # N m
    "viscous": 2.0394,  # N m s/rad
    "inertia": 0.0,  # kg m2, that the compensation misses
    "offset": 0.0,  # N m, of the torque sensor
    "viscous_asymmetry.share": 0.0,  # viscous friction (1 + share) forward, (1 - share) backward
    "coulomb_asymmetry.share": 0.0,  # Coulomb friction likewise
    "stribeck.drop": 0.0,  # N m more at rest
    "stribeck.speed": 0.01,  # rad/s
    "velocity_power.torque": 0.0,  # N m at 0.1 rad/s
    "velocity_power.exponent": 0.5,
    "presliding.angle": 0.0,  # rad, over which friction turns around
    "position_torque.slope": 0.0,  # N m/rad
    "ripple.torque": 0.0,  # N m
    "ripple.pitch": 0.0628,  # rad, 100 a turn
    "ripple.phase": 0.0,  # rad
    "torque_lag.time": 0.0,  # s, first order
}
NUISANCE = (
    Parameter("coulomb", 0.1512, 0.0, 2.0, 0.01, "N m", spread=0.1),
    Parameter("viscous", 2.0394, 0.0, 20.0, 0.1, "N m s/rad", spread=1.5),
    Parameter("inertia", 0.0, -0.5, 0.5, 0.01, "kg m2", spread=0.1),
    Parameter("offset", 0.0, -2.0, 2.0, 0.01, "N m", spread=0.3),
)
EFFECTS = (
    Effect(
        "viscous_asymmetry", "joint", (Parameter("viscous_asymmetry.share", 0.0, -1.0, 1.0, 0.02),),
        scan=((0.1,), (-0.1,), (0.4,)), law="viscous friction (1 + share) forward, (1 - share) backward",
    ),
    Effect(
        "coulomb_asymmetry", "joint", (Parameter("coulomb_asymmetry.share", 0.0, -1.0, 1.0, 0.02),),
        scan=((0.1,), (-0.1,), (0.4,)), law="Coulomb friction (1 + share) forward, (1 - share) backward",
    ),
    Effect(
        "stribeck", "joint",
        (Parameter("stribeck.drop", 0.0, -0.5, 2.0, 0.01, "N m"),
         Parameter("stribeck.speed", 0.01, 1e-3, 0.5, 0.003, "rad/s")),
        scan=((0.05, 0.003), (0.05, 0.01), (0.05, 0.05)), physical=(0.0, np.inf),
        nonphysical="friction that rises with speed", law="friction + drop exp(-|v| / speed)",
    ),
    Effect(
        "velocity_power", "joint",
        (Parameter("velocity_power.torque", 0.0, -1.0, 2.0, 0.01, "N m"),
         Parameter("velocity_power.exponent", 0.5, 0.2, 3.0, 0.1)),
        scan=((0.05, 0.4), (0.05, 0.7), (0.05, 2.0), (-0.05, 0.5), (-0.05, 2.0)),
        law="friction + torque (|v| / 0.1 rad/s)^exponent",
    ),
    Effect(
        "presliding", "joint", (Parameter("presliding.angle", 0.0, 0.0, 0.1, 5e-4, "rad"),),
        scan=((1e-3,), (4e-3,), (0.02,)), law="friction turns around over an angle (Dahl)",
    ),
    Effect(
        "position_torque", "arm", (Parameter("position_torque.slope", 0.0, -5.0, 5.0, 0.02, "N m/rad"),),
        scan=((0.1,), (-0.1,), (0.5,)), law="torque + slope (angle - mean)",
    ),
    Effect(
        "ripple", "gear",
        (Parameter("ripple.torque", 0.0, 0.0, 1.0, 0.01, "N m"),
         Parameter("ripple.pitch", 0.0628, 0.01, 0.4, 5e-4, "rad"),
         Parameter("ripple.phase", 0.0, -4.0, 4.0, 0.2, "rad")),
        scan=tuple((0.03, pitch, phase) for pitch in (0.0314, 0.0628, 0.2) for phase in (0.1, 1.7, -1.5, 3.2)),
        law="torque + torque sin(2 pi q / pitch + phase)",
    ),
    Effect(
        "torque_lag", "sensor", (Parameter("torque_lag.time", 0.0, 0.0, 0.5, 5e-3, "s"),),
        scan=((0.01,), (0.04,), (0.15,)), law="the torque read follows the torque with a first-order lag",
    ),
)  # fmt: skip


@njit(**JIT_OPTIONS)
def _dahl(angle, steepness, state):
    """Fill state (n,), between -1 and 1, with friction that turns around over an angle 1 / steepness, exactly."""
    here = 0.0
    for i in range(1, angle.size):
        step = steepness * (angle[i] - angle[i - 1])
        way = 1.0 if step > 0.0 else -1.0
        here = way + (here - way) * math.exp(-abs(step))
        state[i] = here


@njit(**JIT_OPTIONS)
def _lagged(torque, kept):
    """Low-pass torque (n,) in place."""
    for i in range(1, torque.size):
        torque[i] = (1.0 - kept) * torque[i] + kept * torque[i - 1]


@dataclass(frozen=True)
class Record:
    """One record of the joint: time s, angle rad, speed rad/s, acceleration rad/s2 and torque N m, (n,) each."""

    name: str
    time: Array
    angle: Array
    speed: Array
    acceleration: Array
    torque: Array = field(repr=False)

    @property
    def compared(self) -> Array:
        """(m,) N m: the torque as it is compared."""
        return _compared(self.torque)

    def torques(self, sets: Sequence[Values]) -> Array:
        """Torques (K, m) N m as they are compared; a parameter left out is at its nominal value."""
        return _compared(np.array([self._torque({**NOMINAL, **values}) for values in sets]))

    def _torque(self, p: Values) -> Array:
        """(n,) N m."""
        side = np.sign(self.speed)
        friction = p["coulomb"] * (1.0 + side * p["coulomb_asymmetry.share"])
        if p["stribeck.drop"]:
            friction += p["stribeck.drop"] * np.exp(-np.abs(self.speed) / p["stribeck.speed"])
        if p["velocity_power.torque"]:
            friction += p["velocity_power.torque"] * (np.abs(self.speed) / _UNIT_SPEED) ** p["velocity_power.exponent"]
        sliding = side
        if p["presliding.angle"]:
            sliding = np.zeros_like(side)
            _dahl(self.angle, 1.0 / p["presliding.angle"], sliding)
        torque = p["offset"] + p["inertia"] * self.acceleration + sliding * friction
        torque += p["viscous"] * self.speed * (1.0 + side * p["viscous_asymmetry.share"])
        torque += p["position_torque.slope"] * (self.angle - np.mean(self.angle))
        if p["ripple.torque"]:
            torque += p["ripple.torque"] * np.sin(2.0 * math.pi * self.angle / p["ripple.pitch"] + p["ripple.phase"])
        if p["torque_lag.time"]:
            _lagged(torque, math.exp(-_INTERVAL / p["torque_lag.time"]))
        return np.asarray(torque)


def _low_passed(values: Array) -> Array:
    return np.asarray(filtfilt(*butter(4, CUTOFF * 2.0 * _INTERVAL), values))


def _compared(torque: Array) -> Array:
    """Torques (..., n) low-passed, one sample in ten, without the ends."""
    return _low_passed(torque)[..., _EDGE:-_EDGE:_KEPT]


@dataclass(frozen=True)
class Joint:
    """The model that the engine sees: one run a record."""

    records: tuple[Record, ...]
    nuisance: tuple[Parameter, ...] = NUISANCE
    effects: tuple[Effect, ...] = EFFECTS

    @property
    def runs(self) -> tuple[LoggedRun, ...]:
        """Each record with its one channel, the torque."""
        return tuple(_run(record) for record in self.records)

    def simulate(self, run: int, sets: Sequence[Values], options: SimulationOptions) -> Mapping[str, Array]:
        """See `slider_drilling.gap.model.Model`; a simulation is so cheap that there is no cheaper one to ask for."""
        return {"torque": self.records[run].torques(sets)}


def _run(record: Record) -> LoggedRun:
    torque = Channel("torque", record.time[_EDGE:-_EDGE:_KEPT], record.compared, "N m", declared_noise=NOISE)
    return LoggedRun(
        record.name, record.time, record.angle, (torque,), command="the measured angle", command_unit="rad"
    )


def read_record(path: Path, joint: int = 7) -> Record:
    """A record of one joint from its table. Raises InputError naming file and column for one that cannot be used."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [row for row in csv.DictReader(file) if row.get("time")]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from None
    names = ("time", f"q{joint}", f"dq{joint}", f"q{joint}_tau_J_compensate")
    stamps, *columns = (_column(path, rows, name) for name in names)
    if stamps.size < 1000 or np.any(np.diff(stamps) <= 0.0):
        raise InputError(f"{path}: time does not ascend over at least 1000 rows")
    time = np.arange(stamps[0], stamps[-1], _INTERVAL)
    angle, speed, torque = (np.interp(time, stamps, column) for column in columns)
    speed = _low_passed(speed)
    return Record(path.stem, time, _low_passed(angle), speed, np.gradient(speed, _INTERVAL), torque)


def _column(path: Path, rows: Sequence[Mapping[str, str]], name: str) -> Array:
    if not rows or name not in rows[0]:
        raise InputError(f"{path}: has no column {name}")
    try:
        values = np.array([float(row[name]) for row in rows])
    except (TypeError, ValueError) as error:
        raise InputError(f"{path}: {name}: {error}") from None
    if not np.isfinite(values).all():
        raise InputError(f"{path}: {name} is not finite in row {int(np.argmin(np.isfinite(values))) + 2}")
    return values


def errors(records: Sequence[Record], values: Values) -> list[float]:
    """RMS of measured minus simulated torque, N m, of each record."""
    return [float(np.sqrt(np.mean((record.torques([values])[0] - record.compared) ** 2))) for record in records]


def closed(records: Sequence[Record], before: Values, after: Values) -> float:
    """Share of the squared error of records that these values take away from those; below zero where they add to it."""
    left, was = (sum(error**2 for error in errors(records, values)) for values in (after, before))
    return 1.0 - left / was


def report(answer: GapDiagnosis, fitted: Sequence[Record], unseen: Sequence[Record]) -> list[str]:
    """What was found, and what it does to records that no fit has seen, a line each."""
    calibrated, found = answer.state.calibrated.fit.values, answer.parameters
    lines = [answer.sentence, f"  {answer.simulation_count} simulations, {answer.runtime:.1f} s"]
    for entry in answer.candidates:
        values = ", ".join(f"{p.name} {entry.fitted.fit.values[p.name]:.4g} {p.unit}" for p in entry.effect.parameters)
        lines.append(
            f"  {entry.effect.name} closes {entry.closed:.2f}; {values}: {'; '.join(entry.failures) or 'passed'}"
        )
    if unseen and answer.effects:
        lines.append(f"  together they close {closed(unseen, calibrated, found):.2f} of the unseen records' gap")
    for title, some in (("fitted", fitted), ("not fitted", unseen)):
        rows = zip(some, *(errors(some, values) for values in ({}, calibrated, found)), strict=True)
        for record, before, between, after in rows:
            lines.append(f"  {title:10s} {record.name:14s} RMS {before:.3f} -> {between:.3f} -> {after:.3f} N m")
    return lines


def main(arguments: Sequence[str] | None = None) -> int:
    """Diagnose the records and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("records", nargs="+", type=Path, help="tables to diagnose")
    parser.add_argument("--test", nargs="*", type=Path, default=[], help="tables that no fit sees")
    parser.add_argument("--joint", type=int, default=7)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(arguments)
    from slider_drilling.gap import explain

    try:
        records, unseen = ([read_record(path, given.joint) for path in paths] for paths in (given.records, given.test))
    except InputError as error:
        print(f"Error: {error}", file=sys.stderr)
        return 2
    answer = explain(Joint(tuple(records)), seed=given.seed)
    print("\n".join(report(answer, records, unseen)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
