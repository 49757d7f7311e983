"""Friction of cased and open hole from the driller's weights, by static torque and drag.

Least squares over the friction factor of every hole interval, together with what would otherwise look like friction:
the weight of the string (adjusted weights, wear, buoyancy), the tare of the weight indicator, and the lever of the
friction torque (tool joints, direction of slip). Their priors, and how well a driller reads his instruments, are the
constants below.

What the readings do not determine stays as the rig file has it: the prior of the factors is wide for all of them
together and narrower for their ratios.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize

from slider_drilling.analysis.driller_weights import DrillerWeights, check_weights
from slider_drilling.analysis.fit_friction import IntervalFriction, interval_frictions
from slider_drilling.analysis.friction_misfit import friction_intervals, with_friction_factors
from slider_drilling.errors import InputError
from slider_drilling.gap.results.intervals import TWO_SIDED_95
from slider_drilling.log.series import Array
from slider_drilling.rig import FrictionInterval, Rig
from slider_drilling.units import SI, Units
from slider_drilling.wellbore.broomstick import Broomstick, broomstick, with_bit_at
from slider_drilling.wellbore.mesh import Mesh, build_mesh
from slider_drilling.wellbore.static_loads import static_loads

_ELEMENTS = 200
_HOOK_LOAD_SIGMA, _HOOK_LOAD_SHARE = 4.4e3, 0.005  # N (1 klbf) and share of the load, one standard deviation
_TORQUE_SIGMA, _TORQUE_SHARE = 150.0, 0.03  # N m and share of the torque
_COMMON_SIGMA, _RATIO_SIGMA = 3.0, 0.3  # of ln(factor): all intervals together, and one against the others
_WEIGHT_SIGMA = 0.03  # of ln(weight of the string)
_TARE_SIGMA = 4.4e3  # N
_LEVER_SIGMA = 0.15  # of ln(lever of the friction torque)
# Rotating weight against the string's own, up to which the weights are taken as those of the string alone.
_TARED_SHARE, _TARED_LOAD = 0.06, 15e3
_SPEEDS = {"pick_up": (-1.0, 0.0), "slack_off": (1.0, 0.0), "rotating": (0.0, 1.0)}  # m/s, rad/s


@dataclass(frozen=True)
class FrictionCalibration:
    """Result of `calibrate_friction`.

    Attributes:
        rig: With the calibrated friction factors and weight of the string.
        intervals: Friction from the surface down.
        weights: The readings, without the block.
        predicted: The same from the calibrated model.
        block_weight: That was taken off, N.
        weight_factor: Buoyed weight of the string over that of the rig file.
        tare_error: What the hook load reads too much, N.
        torque_factor: Friction torque over that of the rig file's contact at these factors; None without a torque.
        notes: What was assumed, one sentence each.
    """

    rig: Rig
    intervals: tuple[IntervalFriction, ...]
    weights: tuple[DrillerWeights, ...]
    predicted: tuple[DrillerWeights, ...]
    block_weight: float
    weight_factor: float
    tare_error: float
    torque_factor: float | None
    notes: tuple[str, ...]


def calibrate_friction(
    rig: Rig, weights: Sequence[DrillerWeights], block_weight: float | None = None, units: Units = SI
) -> FrictionCalibration:
    """Calibrate the friction factors of the rig file's intervals.

    Args:
        rig: The rig; without friction intervals one factor holds for the whole hole.
        weights: Readings, one or more at any depths within the string.
        block_weight: Of block, top drive and hoses in the hook loads, N; 0 if the indicator is tared; None takes 0 if
            the string's weight agrees with that.
        units: Of the messages.

    Raises:
        InputError: A reading cannot be, or it is not clear whether the weights include the block.
    """
    if not weights:
        raise InputError("weights: none given; give pick-up, slack-off and rotating weights or free torque")
    for row in weights:
        check_weights(row, f"weights at {units.format(row.depth, 'm', 5)}", units)
    places = [_Place.at(rig, row.depth) for row in weights]
    notes = []
    if block_weight is None:
        _check_tared(places, weights, units)
        block_weight = 0.0
        notes.append("the weights are taken as those of the string alone, since they agree with its weight in mud")
    alone = tuple(row.without(block_weight) for row in weights)
    for row in alone:
        check_weights(row, f"weights at {units.format(row.depth, 'm', 5)}, without the block", units)
    problem = _Problem(rig, places, alone)
    fit = optimize.least_squares(problem.residual, np.zeros(problem.size), x_scale="jac", xtol=1e-8)
    return _result(problem, fit.x, fit.jac, block_weight, notes)


def calibrated_broomstick(calibration: FrictionCalibration, elements: int = _ELEMENTS) -> Broomstick:
    """Loads over bit depth with the calibrated friction and weight of the string."""
    stick = broomstick(calibration.rig, None, elements=elements)
    return replace(stick, torque=(calibration.torque_factor or 1.0) * stick.torque, calibrated=True)


def _check_tared(places: Sequence[_Place], weights: Sequence[DrillerWeights], units: Units) -> None:
    """Raises InputError where hook loads differ from the string's weight by what may be the block's."""
    for place, row in zip(places, weights, strict=True):
        loads = row.hook_loads()
        if not loads:
            continue
        hanging = static_loads(place.rig, mesh=place.mesh).hook_load
        measured = loads.get("rotating", 0.5 * (loads.get("pick_up", hanging) + loads.get("slack_off", hanging)))
        allowed = max(_TARED_SHARE * hanging, _TARED_LOAD) * (1.0 if "rotating" in loads else 3.0)
        if abs(measured - hanging) > allowed:
            depth, read, model, rest = (units.format(value, unit, 4) for value, unit in (
                (row.depth, "m"), (measured / 1e3, "kN"), (hanging / 1e3, "kN"), ((measured - hanging) / 1e3, "kN")))
            raise InputError(
                f"weights at {depth}: {read} off bottom, but the string weighs {model} in this mud; if the weights "
                f"include the block, give its weight (about {rest}) with --block-weight, else check string and mud"
            )


@dataclass(frozen=True)
class _Place:
    """The rig with its bit at the depth of a reading."""

    rig: Rig
    mesh: Mesh

    @classmethod
    def at(cls, rig: Rig, depth: float) -> _Place:
        here = with_bit_at(rig, depth)
        return cls(here, build_mesh(here, _ELEMENTS))

    def loads(self, intervals: tuple[FrictionInterval, ...]) -> dict[str, float]:
        """Hook load (N) of each motion and the torque (N m) of rotation, with these friction intervals."""
        rig = replace(self.rig, well=replace(self.rig.well, friction_intervals=intervals))
        found = {name: static_loads(rig, *speeds, mesh=self.mesh) for name, speeds in _SPEEDS.items()}
        return {**{name: loads.hook_load for name, loads in found.items()},
                "torque": found["rotating"].surface_torque}  # fmt: skip


class _Problem:
    """Residuals over ln(factor) of each interval, ln(weight), tare error over its sigma, ln(lever of torque)."""

    def __init__(self, rig: Rig, places: Sequence[_Place], weights: Sequence[DrillerWeights]):
        self.rig, self.places, self.weights = rig, places, weights
        self.nominal = np.array([max(interval.factor, 0.01) for interval in friction_intervals(rig)])
        self.count = self.nominal.size
        self.size = self.count + 3
        covariance = _COMMON_SIGMA**2 + _RATIO_SIGMA**2 * np.eye(self.count)
        self._whiten = np.linalg.inv(np.linalg.cholesky(covariance))

    def factors(self, point: Array) -> Array:
        return np.asarray(self.nominal * np.exp(point[: self.count]), dtype=np.float64)

    def predict(self, point: Array) -> list[dict[str, float]]:
        """What the instruments should read at each depth."""
        intervals = with_friction_factors(self.rig, self.factors(point)).well.friction_intervals
        weight, tare, lever = point[self.count :]
        rows = []
        for place in self.places:
            # Off bottom all loads of the soft string are in proportion to its weight.
            row = {name: float(load * math.exp(weight)) for name, load in place.loads(intervals).items()}
            rows.append({name: load * math.exp(lever) if name == "torque" else load + tare * _TARE_SIGMA
                         for name, load in row.items()})  # fmt: skip
        return rows

    def residual(self, point: Array) -> Array:
        """Misfit of every reading over its standard deviation, then the priors."""
        parts = []
        for row, predicted in zip(self.weights, self.predict(point), strict=True):
            for motion, load in row.hook_loads().items():
                parts.append((predicted[motion] - load) / math.hypot(_HOOK_LOAD_SIGMA, _HOOK_LOAD_SHARE * load))
            if row.torque is not None:
                sigma = math.hypot(_TORQUE_SIGMA, _TORQUE_SHARE * row.torque)
                parts.append((predicted["torque"] - row.torque) / sigma)
        weight, tare, lever = point[self.count :]
        prior = [weight / _WEIGHT_SIGMA, tare, lever / _LEVER_SIGMA]
        return np.concatenate([parts, self._whiten @ point[: self.count], prior])


def _result(
    problem: _Problem, point: Array, jacobian: Array, block_weight: float, notes: list[str]
) -> FrictionCalibration:
    factors = problem.factors(point)
    spread = TWO_SIDED_95 * np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian))) * _excess(problem, point)
    limits = [(float(factor * math.exp(-width)), float(factor * math.exp(width)))
              for factor, width in zip(factors, spread, strict=False)]  # fmt: skip
    rig = with_friction_factors(problem.rig, factors)
    heavier = rig.string.weight_factor * math.exp(point[problem.count])
    rig = replace(rig, string=replace(rig.string, weight_factor=float(heavier)))
    has_torque = any(row.torque is not None for row in problem.weights)
    weight, tare, lever = point[problem.count :]
    predicted = tuple(
        DrillerWeights(row.depth, **{name: loads[name] for name in ("pick_up", "slack_off", "rotating", "torque")
                                     if getattr(row, name) is not None})
        for row, loads in zip(problem.weights, problem.predict(point), strict=True)
    )  # fmt: skip
    return FrictionCalibration(
        rig=rig,
        intervals=interval_frictions(problem.rig, factors, limits, math.exp(lever) if has_torque else 1.0),
        weights=tuple(problem.weights),
        predicted=predicted,
        block_weight=block_weight,
        weight_factor=math.exp(weight),
        tare_error=float(tare) * _TARE_SIGMA,
        torque_factor=math.exp(lever) if has_torque else None,
        notes=tuple(notes),
    )


def _excess(problem: _Problem, point: Array) -> float:
    """Factor on all intervals where the readings scatter more than they should."""
    residual = problem.residual(point)[: -problem.size]
    spare = residual.size - problem.size
    return math.sqrt(max(1.0, float(residual @ residual) / spare)) if spare > 0 else 1.0
