"""The gap engine on a real machine axis: what does the published model leave out, and how much does each effect close?

EMPS is an electro-mechanical positioning system: a motor moves a carriage along a ball screw, as in a machine tool
(A. Janot, M. Gautier and M. Brunot, "Data set and reference models of EMPS", Workshop on Nonlinear System
Identification Benchmarks, Eindhoven 2019). The model is theirs: one mass, an offset, Coulomb and viscous friction that
are the same in both directions. The measured motion drives it; the force of the motor is to be explained:

    python docs/examples/emps.py DATA_EMPS.mat --test DATA_EMPS_PULSES.mat

`python -m slider_drilling.benchmarks.machine_records DIR` fetches the two records and checks them.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import butter, filtfilt

from slider_drilling.errors import InputError
from slider_drilling.gap import Channel, Effect, GapDiagnosis, LoggedRun, Parameter, SimulationOptions
from slider_drilling.gap.model import Array, Values
from slider_drilling.process.jit_cache import JIT_OPTIONS, njit

PERIOD = 1e-3  # s, of the samples
# As published: positions are low-passed before they are differentiated, measured and modelled forces before they are
# compared, both ways in time, and one sample in ten is kept.
POSITION_CUTOFF = 100.0  # Hz
FORCE_CUTOFF = 40.0  # Hz
KEPT = 10
EDGE = 50  # samples left out at either end, where filters and differences are off
_UNIT_SPEED = 0.1  # m/s, at which the power term has its force
_CARRIAGE = 0.2  # share of the mass behind the backlash; the rest turns with the motor

# Every parameter of the model at its nominal value, as published.
NOMINAL = {
    "mass": 95.1089,  # kg, of carriage and motor, as seen at the carriage
    "viscous": 203.5034,  # N s/m
    "coulomb": 20.3935,  # N
    "offset": -3.1648,  # N
    "viscous_asymmetry.share": 0.0,  # viscous friction (1 + share) forward, (1 - share) backward
    "coulomb_asymmetry.share": 0.0,  # Coulomb friction likewise
    "stribeck.drop": 0.0,  # N more at rest
    "stribeck.speed": 0.01,  # m/s
    "velocity_power.force": 0.0,  # N at 0.1 m/s
    "velocity_power.exponent": 2.0,
    "force_lag.time": 0.0,  # s, first order
    "current_gain.share": 0.0,  # force per volt (1 + share)
    "backlash.width": 0.0,  # m, between screw and carriage
    "ripple.force": 0.0,  # N
    "ripple.pitch": 0.005,  # m
    "ripple.phase": 0.0,  # rad
    "quadratic_load.factor": 0.0,  # 1/N, of the squared force
}

NUISANCE = (
    Parameter("mass", 95.1089, 50.0, 150.0, 1.0, "kg", spread=5.0),
    Parameter("viscous", 203.5034, 20.0, 600.0, 5.0, "N s/m", spread=60.0),
    Parameter("coulomb", 20.3935, 0.0, 60.0, 0.5, "N", spread=6.0),
    Parameter("offset", -3.1648, -20.0, 20.0, 0.3, "N", spread=3.0),
)
EFFECTS = (
    Effect(
        "viscous_asymmetry", "guide", (Parameter("viscous_asymmetry.share", 0.0, -0.9, 0.9, 0.02),),
        scan=((0.1,), (-0.1,), (0.4,)), law="viscous friction (1 + share) forward, (1 - share) backward",
    ),
    Effect(
        "coulomb_asymmetry", "guide", (Parameter("coulomb_asymmetry.share", 0.0, -0.9, 0.9, 0.02),),
        scan=((0.1,), (-0.1,), (0.4,)), law="Coulomb friction (1 + share) forward, (1 - share) backward",
    ),
    Effect(
        "stribeck", "guide",
        (Parameter("stribeck.drop", 0.0, -10.0, 20.0, 0.5, "N"),
         Parameter("stribeck.speed", 0.01, 5e-4, 0.2, 0.003, "m/s")),
        scan=((4.0, 0.002), (4.0, 0.01), (4.0, 0.05)), physical=(0.0, np.inf),
        nonphysical="friction that rises with speed", law="friction + drop exp(-|v| / speed)",
    ),
    Effect(
        "velocity_power", "guide",
        (Parameter("velocity_power.force", 0.0, -40.0, 40.0, 0.5, "N"),
         Parameter("velocity_power.exponent", 2.0, 0.2, 4.0, 0.2)),
        scan=((4.0, 0.5), (4.0, 2.0), (4.0, 3.0), (-4.0, 0.5), (-4.0, 2.0)),
        law="friction + force (|v| / 0.1 m/s)^exponent",
    ),
    Effect(
        "force_lag", "motor", (Parameter("force_lag.time", 0.0, 0.0, 5e-3, 1e-4, "s"),),
        scan=((2e-4,), (5e-4,), (2e-3,)), law="the force follows what the controller asks for with a first-order lag",
    ),
    Effect(
        "current_gain", "motor", (Parameter("current_gain.share", 0.0, -0.4, 0.4, 0.01),),
        scan=((0.03,), (-0.03,), (0.1,)), law="force per volt (1 + share)",
    ),
    Effect(
        "backlash", "screw", (Parameter("backlash.width", 0.0, 0.0, 2e-3, 1e-5, "m"),),
        scan=((1e-5,), (5e-5,), (3e-4,)), law="dead zone between screw and carriage",
    ),
    Effect(
        "ripple", "screw",
        (Parameter("ripple.force", 0.0, 0.0, 20.0, 0.5, "N"),
         Parameter("ripple.pitch", 0.005, 0.002, 0.06, 1e-5, "m"),
         Parameter("ripple.phase", 0.0, -4.0, 4.0, 0.2, "rad")),
        scan=tuple((1.0, pitch, phase) for pitch in (0.0025, 0.005, 0.01) for phase in (0.1, 1.7, -1.5, 3.2)),
        law="force + force sin(2 pi q / pitch + phase)",
    ),
    Effect(
        "quadratic_load", "screw", (Parameter("quadratic_load.factor", 0.0, 0.0, 0.01, 1e-4, "1/N"),),
        scan=((3e-4,), (1e-3,), (4e-3,)), law="friction + factor force^2",
    ),
)  # fmt: skip


@njit(**JIT_OPTIONS)
def _play(position, width, carriage):
    """Fill carriage (n,) with what follows a position (n,) through a dead zone of this width."""
    here = position[0]
    for i in range(position.size):
        here = min(max(here, position[i] - 0.5 * width), position[i] + 0.5 * width)
        carriage[i] = here


@dataclass(frozen=True)
class Motion:
    """Low-passed motion: time s, position m, speed m/s and acceleration m/s2, (n,) each."""

    time: Array
    position: Array
    speed: Array
    acceleration: Array


@dataclass(frozen=True)
class Record:
    """One record of the axis: motion, and force N (n,) as the motor gives it."""

    name: str
    motion: Motion
    force: Array = field(repr=False)

    @cached_property
    def compared(self) -> Array:
        """(m,) N: the force as it is compared."""
        return _compared(self.force)

    def forces(self, sets: Sequence[Values]) -> Array:
        """Forces (K, m) N as they are compared; a parameter left out is at its nominal value."""
        return _compared(np.array([_force(self.motion, {**NOMINAL, **values}) for values in sets]))


def _force(motion: Motion, p: Values) -> Array:
    """(n,) N that the motor must give for this motion."""
    speed, side = motion.speed, np.sign(motion.speed)
    force = p["mass"] * motion.acceleration + p["offset"] + _backlash(motion, p)
    force += p["viscous"] * speed * (1.0 + side * p["viscous_asymmetry.share"])
    friction = p["coulomb"] * (1.0 + side * p["coulomb_asymmetry.share"])
    if p["stribeck.drop"]:
        friction += p["stribeck.drop"] * np.exp(-np.abs(speed) / p["stribeck.speed"])
    if p["velocity_power.force"]:
        friction += p["velocity_power.force"] * (np.abs(speed) / _UNIT_SPEED) ** p["velocity_power.exponent"]
    if p["quadratic_load.factor"]:
        friction += p["quadratic_load.factor"] * (force + side * friction) ** 2
    force += side * friction
    if p["ripple.force"]:
        force += p["ripple.force"] * np.sin(2.0 * math.pi * motion.position / p["ripple.pitch"] + p["ripple.phase"])
    force /= 1.0 + p["current_gain.share"]
    if p["force_lag.time"]:
        # What is recorded is what the controller asks for, ahead of the force.
        force = force + p["force_lag.time"] * np.gradient(force, PERIOD)
    return np.asarray(force)


def _backlash(motion: Motion, p: Values) -> Array | float:
    """(n,) N by which the carriage's share of the inertia differs where it is not with the motor."""
    if not p["backlash.width"]:
        return 0.0
    carriage = np.empty_like(motion.position)
    _play(motion.position, p["backlash.width"], carriage)
    acceleration = np.gradient(np.gradient(carriage, PERIOD), PERIOD)
    return np.asarray(_CARRIAGE * p["mass"] * (acceleration - motion.acceleration))


def _compared(force: Array) -> Array:
    """Forces (..., n) low-passed, one sample in ten, without the ends."""
    smooth = filtfilt(*butter(4, FORCE_CUTOFF * 2.0 * PERIOD), force)
    return np.asarray(smooth[..., EDGE:-EDGE:KEPT])


@dataclass(frozen=True)
class Axis:
    """The model that the engine sees: one run a record."""

    records: tuple[Record, ...]
    nuisance: tuple[Parameter, ...] = NUISANCE
    effects: tuple[Effect, ...] = EFFECTS

    @property
    def runs(self) -> tuple[LoggedRun, ...]:
        """Each record with its one channel, the force."""
        return tuple(_run(record) for record in self.records)

    def simulate(self, run: int, sets: Sequence[Values], options: SimulationOptions) -> Mapping[str, Array]:
        """See `slider_drilling.gap.model.Model`; a simulation is so cheap that there is no cheaper one to ask for."""
        return {"force": self.records[run].forces(sets)}


def _run(record: Record) -> LoggedRun:
    motion = record.motion
    force = Channel("force", motion.time[EDGE:-EDGE:KEPT], record.compared, "N")
    return LoggedRun(
        record.name, motion.time, motion.position, (force,), command="the measured position", command_unit="m"
    )


def read_record(path: Path) -> Record:
    """A record from its MATLAB file. Raises InputError naming file and variable for one that cannot be used."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        held = loadmat(path)
    except (OSError, ValueError, NotImplementedError, MatReadError) as error:
        raise InputError(f"{path}: cannot be read as a MATLAB file: {error}") from None
    time, position, volts = (_variable(path, held, name) for name in ("t", "qm", "vir"))
    if not time.size == position.size == volts.size > 1000 or np.any(np.abs(np.diff(time) - PERIOD) > 0.1 * PERIOD):
        raise InputError(f"{path}: t, qm and vir do not hold the same samples, more than 1000, every {PERIOD} s")
    smooth = filtfilt(*butter(4, POSITION_CUTOFF * 2.0 * PERIOD), position)
    speed = np.gradient(smooth, PERIOD)
    motion = Motion(time, smooth, speed, np.gradient(speed, PERIOD))
    return Record(path.stem, motion, float(_variable(path, held, "gtau")[0]) * volts)


def _variable(path: Path, held: Mapping[str, Any], name: str) -> Array:
    if name not in held:
        raise InputError(f"{path}: has no variable {name}")
    values = np.ravel(held[name]).astype(float)
    if not np.isfinite(values).all():
        raise InputError(f"{path}: {name} holds values that are not finite")
    return np.asarray(values)


def errors(records: Sequence[Record], values: Values) -> list[float]:
    """RMS of measured minus simulated force, N, of each record."""
    return [float(np.sqrt(np.mean((record.forces([values])[0] - record.compared) ** 2))) for record in records]


def closed(records: Sequence[Record], before: Values, after: Values) -> float:
    """Share of the squared error of records that these values take away from those; below zero where they add to it."""
    left, was = (sum(error**2 for error in errors(records, values)) for values in (after, before))
    return 1.0 - left / was


def candidate_lines(answer: GapDiagnosis, unseen: Sequence[Record]) -> list[str]:
    """What each candidate closes, of the record that was fitted and of one that no fit has seen."""
    steps = [taken for taken in answer.state.steps if taken.accepted is not None]
    known = {(): answer.state.calibrated} | {taken.accepted.fitted.names: taken.accepted.fitted for taken in steps}
    lines = []
    for entry in answer.candidates:
        found, before = entry.fitted.fit.values, known.get(entry.beside)
        values = ", ".join(f"{p.name} {found[p.name]:.4g} {p.unit}" for p in entry.effect.parameters)
        said = f"  {entry.effect.name} closes {entry.closed:.2f} [{entry.interval[0]:.2f}, {entry.interval[1]:.2f}]"
        if entry.beside:
            said += f" of what {' and '.join(entry.beside)} {'leaves' if len(entry.beside) == 1 else 'leave'}"
        if unseen and before is not None:
            said += f", of the unseen record {closed(unseen, before.fit.values, found):.2f}"
        lines.append(f"{said}; {values}: {'; '.join(entry.failures) or 'passed'}")
    return lines


def main(arguments: Sequence[str] | None = None) -> int:
    """Diagnose the record and print what was found, and what it does to one that no fit has seen."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("records", nargs="+", type=Path, help="MATLAB files to diagnose")
    parser.add_argument("--test", nargs="*", type=Path, default=[], help="MATLAB files that no fit sees")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(arguments)
    from slider_drilling.gap import explain

    try:
        records, unseen = ([read_record(path) for path in paths] for paths in (given.records, given.test))
    except InputError as error:
        print(f"Error: {error}", file=sys.stderr)
        return 2
    answer = explain(Axis(tuple(records)), seed=given.seed)
    print(answer.sentence)
    print(f"  {answer.simulation_count} simulations, {answer.runtime:.1f} s")
    for line in candidate_lines(answer, unseen):
        print(line)
    calibrated = answer.state.calibrated.fit.values
    if unseen and answer.effects:
        print(f"  together they close {closed(unseen, calibrated, answer.parameters):.2f} of the unseen record's gap")
    for title, some in (("fitted", records), ("not fitted", unseen)):
        rows = zip(some, *(errors(some, values) for values in ({}, calibrated, answer.parameters)), strict=True)
        for record, before, between, after in rows:
            print(f"  {title:10s} {record.name:20s} RMS {before:.2f} -> {between:.2f} -> {after:.2f} N")
    return 0


if __name__ == "__main__":
    sys.exit(main())
