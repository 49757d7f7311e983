"""Drawn rigs as the compiled steps take them: constants, instruments and initial states, a row for each rig."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slider_drilling.blind.foreign.constants import (
    ElementConstants,
    element_constants,
    friction_over_direction,
    run_constants,
)
from slider_drilling.blind.foreign.plant import ForeignPlant, ForeignState, slow_changes
from slider_drilling.blind.foreign.structure import Structure
from slider_drilling.drillstring import InitialState, Modifiers, assemble
from slider_drilling.drillstring.initial_state import initial_kernel_state
from slider_drilling.drillstring.kernel_arrays import Array, Elements, FrictionCurve, KernelState, Lanes
from slider_drilling.drillstring.lane_block import min_substeps
from slider_drilling.drillstring.sensors import lag_gain
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.slide_scenarios.scenario import Scenario
from slider_drilling.training.instruments import InstrumentSettings
from slider_drilling.training.stacking import stack_fields, stack_rows

FOREIGN_STATE = tuple(ForeignState.__dataclass_fields__)
_ABOVE = ("position", "rotation")  # with one row before that of the first element


@dataclass(frozen=True)
class DrawnRig:
    """A rig to draw episodes from.

    Attributes:
        scenario: Rig file, true rig and losses of the MWD.
        structure: Foreign structure of the plant, or None for the plant of `drillstring`.
        seed: Of the foreign plant's slow changes.
    """

    scenario: Scenario
    structure: Structure | None = None
    seed: int = 0


@dataclass(frozen=True)
class ModelPlants:
    """Plants of `drillstring`: `Elements`, `Lanes`, `FrictionCurve` and the `KernelState` of a string at rest.

    Attributes:
        twist_share: (plants, elements) part of the twist of the bit that each element has.
    """

    elements: Elements
    lanes: Lanes
    curves: tuple[Array, Array, Array]
    initial: KernelState
    twist_share: Array


@dataclass(frozen=True)
class ForeignPlants:
    """Plants of foreign structure; `foreign_step.step_foreign_rigs` has the shapes."""

    elements: ElementConstants
    runs: Array
    friction: Array
    instruments: Array
    slow_changes: Array
    initial: tuple[Array, ...]
    twist_share: Array


@dataclass(frozen=True)
class DrawnRigs:
    """Rigs and their constants.

    Attributes:
        rigs: What they were made from.
        interval: s between samples of the sensors.
        elements: Of each string.
        instruments: Of drives, sensors and MWD.
        steps: (rigs, 5) substeps, their length s, pressure pulses on their way, and whether friction depends on speed
            or on rest.
        foreign: (rigs,) whether the plant is of foreign structure.
        plants: (rigs,) row of each rig's plant among those of its kind.
        pump_speed: (rigs,) of the reference flow, rad/s.
        model, foreign_plants: The plants, or None where there are none.
    """

    rigs: tuple[DrawnRig, ...]
    interval: float
    elements: int
    instruments: InstrumentSettings
    steps: Array
    foreign: NDArray[np.bool_]
    plants: NDArray[np.int64]
    pump_speed: Array
    model: ModelPlants | None
    foreign_plants: ForeignPlants | None


class _Plant(NamedTuple):
    """Constants of one plant, and its row of `DrawnRigs.steps`."""

    parts: tuple
    steps: tuple[float, ...]


def assemble_rigs(rigs: Sequence[DrawnRig], elements: int, duration: float) -> DrawnRigs:
    """Returns the constants of at least one rig.

    Args:
        rigs: Their sensors have one rate.
        elements: Of each string.
        duration: s that an episode lasts at most.

    Raises:
        InputError: The rigs' sensors differ in rate.
    """
    true = [each.scenario.true_rig() for each in rigs]
    rates = {rig.sensors.rate for rig in true}
    if len(rates) > 1:
        raise InputError(f"vector_env: sensors.rate differs between rigs ({', '.join(f'{r:g}' for r in sorted(rates))} "
                         "Hz); use one rate")  # fmt: skip
    interval = 1.0 / rates.pop()
    foreign = np.array([each.structure is not None for each in rigs])
    built = [
        _model_plant(rig, elements, interval) if each.structure is None
        else _foreign_plant(rig, each.structure, each.seed, elements, interval, duration)
        for each, rig in zip(rigs, true, strict=True)
    ]  # fmt: skip
    models = [plant.parts for plant, other in zip(built, foreign, strict=True) if not other]
    others = [plant.parts for plant, other in zip(built, foreign, strict=True) if other]
    return DrawnRigs(
        rigs=tuple(rigs), interval=interval, elements=elements,
        instruments=_instruments([each.scenario for each in rigs], true, interval),
        steps=np.array([plant.steps for plant in built]), foreign=foreign,
        plants=np.where(foreign, np.cumsum(foreign), np.cumsum(~foreign)) - 1,
        pump_speed=np.array([rig.reference_pump_speed for rig in true]),
        model=_stack_models(models) if models else None,
        foreign_plants=_stack_foreign(others) if others else None,
    )  # fmt: skip


def _instruments(scenarios: Sequence[Scenario], true: Sequence[Rig], interval: float) -> InstrumentSettings:
    limits, sensors, mwd = [], [], []
    for scenario, rig in zip(scenarios, true, strict=True):
        drive, s = rig.top_drive, rig.sensors
        limits.append((drive.max_acceleration, drive.max_speed, drive.max_torque))
        surface = (s.surface_torque, s.hook_load, s.standpipe_pressure)
        sensors.append([(each.noise, lag_gain(each.lag, interval), each.resolution) for each in surface])
        settings = (s.mwd.period, s.mwd.latency, s.mwd.noise, s.mwd.resolution)
        mwd.append((*settings, scenario.mwd_lost, scenario.mwd_outliers))
    return InstrumentSettings(np.array(limits), np.array(sensors), np.array(mwd))


def _model_plant(rig: Rig, elements: int, interval: float) -> _Plant:
    mesh = assemble.common_mesh([rig], elements)
    substeps = min_substeps([rig], mesh, interval)
    dt = interval / substeps
    e, c = assemble.elements([rig], mesh, dt, [Modifiers()]), assemble.lanes([rig], mesh, dt)
    curve = assemble.friction_curve(rig.contact)
    row = np.zeros(9)
    row[4] = rig.reference_pump_speed
    state = initial_kernel_state([rig], mesh, e, c, curve, dt, row, [InitialState()])
    compliance = np.cumsum(1.0 / e.torsional_spring[:elements])
    by_speed = float(np.any(e.stribeck_drop) or np.any(e.drift_rate))
    steps = (float(substeps), dt, float(state.pressure_pulses.size), by_speed, float(np.any(e.aging_growth)))
    return _Plant((e, c, curve, state, compliance / compliance[-1]), steps)


def _stack_models(plants: Sequence[tuple]) -> ModelPlants:
    elements, lanes, curves, states, shares = zip(*plants, strict=True)
    return ModelPlants(
        stack_fields(Elements, elements),
        Lanes(*(np.stack(values) for values in zip(*lanes, strict=True))),
        _stack_curves(curves),
        stack_fields(KernelState, states, _ABOVE),
        np.stack(shares),
    )


def _stack_curves(curves: Sequence[FrictionCurve]) -> tuple[Array, Array, Array]:
    """Coefficients (plants, 8), tables (plants, size) and numbers (plants, 5), as `plant_rows.curve_of` reads them."""
    coefficients = np.zeros((len(curves), 8))
    for row, curve in zip(coefficients, curves, strict=True):
        row[: curve.polynomial.size] = curve.polynomial
    numbers = [(c.axial, c.tangential, c.exponent, c.stiffness_per_load, c.polynomial.size) for c in curves]
    return coefficients, np.stack([curve.table for curve in curves]), np.array(numbers, dtype=float)


def _foreign_plant(
    rig: Rig, structure: Structure, seed: int, elements: int, interval: float, duration: float
) -> _Plant:
    changes = slow_changes(structure, duration, np.random.default_rng(seed))
    plant = ForeignPlant(rig, elements, interval, InitialState(), Modifiers(), structure, changes)
    e = element_constants(rig, plant.mesh, Modifiers(), structure)
    row = np.zeros(9)
    row[5], row[6:] = rig.reference_pump_speed, changes[0, 1:]
    state = plant.initial_state(row)
    run = run_constants(rig, plant.mesh, structure, plant.step, rig.string.length - state.position[-1], 0.0)
    compliance = np.cumsum(1.0 / e.torsional_spring)
    instruments = (structure.clock_jitter, structure.encoder_step, structure.hook_load_gain,
                   structure.hook_load_offset, structure.deadline_hysteresis, structure.held_hook_load)  # fmt: skip
    parts = (e, np.array(run, dtype=float), friction_over_direction(rig, structure), instruments, changes,
             tuple(getattr(state, name) for name in FOREIGN_STATE), compliance / compliance[-1])  # fmt: skip
    return _Plant(parts, (float(plant.substeps), plant.step, float(state.pulses.size), 0.0, 0.0))


def _stack_foreign(plants: Sequence[tuple]) -> ForeignPlants:
    elements, runs, friction, instruments, changes, states, shares = zip(*plants, strict=True)
    # Only pulses differ in length; `steps` says how many count.
    initial = tuple(stack_rows(rows) if name == "pulses" else np.stack(rows)
                    for name, rows in zip(FOREIGN_STATE, zip(*states, strict=True), strict=True))  # fmt: skip
    return ForeignPlants(
        ElementConstants(*(np.stack(values) for values in zip(*elements, strict=True))),
        np.stack(runs), np.stack(friction), np.array(instruments), np.stack(changes), initial, np.stack(shares),
    )  # fmt: skip


def transit_depth(rigs: DrawnRigs) -> int:
    """How many MWD samples may be on their way at once."""
    period, latency = rigs.instruments.mwd[:, 0], rigs.instruments.mwd[:, 1]
    return math.ceil(float(np.max((latency + rigs.interval) / period))) + 2
