"""Friction of each hole interval, fitted through the plant to a log's torque and hook load.

Least squares over the friction factor of every interval, together with what would otherwise look like friction:
initial twist, backlash between drive and string, bit torque, mud damping, torsional compliance, pipe density, a
constant offset of the hook load (travelling gear, calibration), and one stretch with more friction than the rest (a
cuttings bed), where the misfit asks for it.

Errors within a rocking cycle are correlated. Confidence intervals therefore come from the variation between blocks of
time, not between samples (cluster-robust sandwich estimator).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, stats

from slider_drilling.analysis.friction_misfit import Array, FrictionMisfit, friction_intervals
from slider_drilling.contact import friction_coefficient_of_direction
from slider_drilling.diagnosis.replay import measured_channels
from slider_drilling.drillstring import InitialState
from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.log_inputs.commands_from_log import LogCommands, commands_from_log
from slider_drilling.rig import Rig

ELEMENTS = 100
"""Default number of elements: half of what 1 % of torque needs. Factors change by less than 1 %."""
_COARSE_ELEMENTS = 50  # with which the search starts; it ends with all of them
_BED_PLACES = 12  # stretches of hole that are tried for a cuttings bed
_MIN_BED_GAIN = 0.3  # of the excess misfit that a bed must promise to explain before it is fitted
_BACKLASHES = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6)  # rad, that are tried
_MAX_BACKLASH_MISFIT = 0.9  # of the misfit without backlash, for backlash to be kept
_UNDETERMINED = 0.5  # half-width of an interval over the factor, above which the log does not determine the factor


@dataclass(frozen=True)
class IntervalFriction:
    """Friction of one hole interval.

    Attributes:
        kind: "cased" or "open hole".
        top, bottom: Measured depth, m.
        factor: Multiplies the contact's friction.
        factor_interval: 95 % confidence interval of the factor.
        in_rig_file: Factor in the rig file.
        axial, tangential: Friction coefficients that go with the factor, along the hole and around it.
    """

    kind: str
    top: float
    bottom: float
    factor: float
    factor_interval: tuple[float, float]
    in_rig_file: float
    axial: float
    tangential: float

    @property
    def is_determined(self) -> bool:
        """Whether the log determines the factor."""
        low, high = self.factor_interval
        return 0.5 * (high - low) < _UNDETERMINED * max(self.factor, 0.05)


@dataclass(frozen=True)
class FittedBed:
    """A stretch of hole (measured depths, m) whose friction is factor (95 % interval) times that of its interval."""

    top: float
    bottom: float
    factor: float
    factor_interval: tuple[float, float]


@dataclass(frozen=True)
class FrictionFit:
    """Result of `fit_friction`.

    Attributes:
        rig: The fitted rig.
        start: The fitted initial state.
        intervals: Friction from the surface down.
        channels: Names of the channels that were fitted.
        rms, rms_before: RMS misfit per channel in its unit, fitted and as the rig file has it.
        inputs: Commands from the log.
        bed: A stretch with more friction, if one was found.
    """

    rig: Rig
    start: InitialState
    intervals: tuple[IntervalFriction, ...]
    channels: tuple[str, ...]
    rms: dict[str, float]
    rms_before: dict[str, float]
    inputs: LogCommands
    bed: FittedBed | None = None


def fit_friction(
    log: RigLog, rig: Rig, elements: int = ELEMENTS, progress: Callable[[int], None] | None = None
) -> FrictionFit:
    """Fit the friction factors of the rig file's intervals to a log.

    Args:
        log: The log.
        rig: The rig.
        elements: Of the string.
        progress: Called with the number of simulations so far.

    Raises:
        InputError: Where the log holds neither surface torque nor hook load, or no motion.
    """
    inputs = commands_from_log(log, rig)
    channels = [c for name, c in measured_channels(log, rig).items() if name in ("surface_torque", "hook_load")]
    if not inputs.block_logged:
        channels = [c for c in channels if c.name == "surface_torque"]
    if not channels:
        raise InputError(f"{log.source}: holds neither surface torque nor hook load; friction shows in nothing else")
    misfit = FrictionMisfit(rig, inputs, tuple(channels), min(_COARSE_ELEMENTS, elements), progress)
    guess = _first_guess(misfit)
    point = _fit_backlash(misfit, guess, _least_squares(misfit, guess))
    bed = _find_bed(misfit, point) if len(channels) > 1 else None
    if bed is not None:
        misfit.bed = bed
        point = _least_squares(misfit, np.append(point, 2.0))
    misfit.elements = elements
    point = _least_squares(misfit, point, max_evaluations=3)
    residual, jacobian = misfit.residual(point), misfit.jacobian(point)
    errors, quantile = _block_errors(jacobian, residual, misfit.blocks)
    half_widths = quantile * errors
    count = misfit.intervals
    limits = [_interval(*pair) for pair in zip(point[:count], half_widths[:count], strict=True)]
    return FrictionFit(
        rig=misfit.rig_at(point),
        start=misfit.start_at(point),
        intervals=interval_frictions(rig, point[:count], limits),
        channels=tuple(channel.name for channel in channels),
        rms=misfit.rms(residual),
        rms_before=misfit.rms(misfit.residual(misfit.nominal)),
        inputs=inputs,
        bed=None if bed is None else FittedBed(*bed, float(point[-1]), _interval(point[-1], half_widths[-1])),
    )


def _first_guess(misfit: FrictionMisfit) -> Array:
    """The rig file's friction, or the multiple of it that fits best: a field rig's guess may be far from the log."""
    guesses = [misfit.nominal.copy() for _ in range(5)]
    for guess, scale in zip(guesses, (1.0, 0.5, 0.7, 1.4, 2.0), strict=True):
        guess[: misfit.intervals] = scale * np.maximum(guess[: misfit.intervals], 0.05)
    sums = [np.sum(np.abs(residual)) for residual in misfit.residuals(guesses)]
    return guesses[int(np.argmin(sums))]


def _fit_backlash(misfit: FrictionMisfit, guess: Array, point: Array) -> Array:
    """The fit with backlash between drive and string, where it takes a tenth of the misfit away; else ``point``.

    Several widths are tried: at zero the misfit has no slope, and between widths it has several minima. They start
    from the first guess, since in a fit without backlash damping and friction imitate it.
    """
    place = misfit.index("backlash")
    tries = [guess + np.where(np.arange(guess.size) == place, width, 0.0) for width in _BACKLASHES]
    before, *sums = (float(np.sum(residual**2)) for residual in misfit.residuals([point, *tries]))
    if before < misfit.blocks.size:
        return point
    fitted = _least_squares(misfit, tries[int(np.argmin(sums))])
    return fitted if float(np.sum(misfit.residual(fitted) ** 2)) < _MAX_BACKLASH_MISFIT * before else point


def _least_squares(misfit: FrictionMisfit, first: Array, max_evaluations: int = 12) -> Array:
    """Least squares from a first point over all parameters; a backlash of zero stays zero."""
    free = np.ones(first.size, dtype=bool)
    free[misfit.index("backlash")] = first[misfit.index("backlash")] > 0.0
    low, high = misfit.bounds(first.size)

    def whole(some: Array) -> Array:
        point = first.copy()
        point[free] = some
        return point

    fit = optimize.least_squares(
        lambda p: np.concatenate([misfit.residual(whole(p)), misfit.prior(whole(p))]),
        np.clip(first, low + 1e-6, high - 1e-6)[free],
        jac=lambda p: np.concatenate([misfit.jacobian(whole(p)), misfit.prior_jacobian(whole(p))])[:, free],
        bounds=(low[free], high[free]), x_scale=misfit.scale(first.size)[free], xtol=1e-4, ftol=1e-5,
        max_nfev=max_evaluations,
    )  # fmt: skip
    return whole(fit.x)


def _find_bed(misfit: FrictionMisfit, point: Array) -> tuple[float, float] | None:
    """The stretch (m, m) where extra friction would explain most of the misfit; None where it would explain little.

    Each twelfth of the hole is tried, with the part of its effect that the other parameters cannot imitate.
    """
    residual, jacobian = misfit.residual(point), misfit.jacobian(point)
    edges = np.linspace(0.0, misfit.rig.string.length, _BED_PLACES + 1)
    places = [(float(a), float(b)) for a, b in itertools.pairwise(edges)]
    changed = misfit.residuals([np.append(point, 1.2)] * len(places), places)
    basis, _ = np.linalg.qr(jacobian)
    unexplained = residual - basis @ (basis.T @ residual)
    gains = []
    for other in changed:
        slope = (other - residual) / 0.2
        slope = slope - basis @ (basis.T @ slope)
        step = -float(slope @ unexplained) / max(float(slope @ slope), 1e-12)
        gain = float(slope @ unexplained) ** 2 / max(float(slope @ slope), 1e-12)
        gains.append(gain if step > 0.0 else 0.0)
    best = int(np.argmax(gains))
    excess = float(unexplained @ unexplained) - unexplained.size
    relevant = excess > 0.2 * unexplained.size and gains[best] > _MIN_BED_GAIN * excess
    return places[best] if relevant else None


def _block_errors(jacobian: Array, residual: Array, blocks: NDArray[np.int_]) -> tuple[Array, float]:
    """Cluster-robust standard errors, one cluster a block, and the 97.5 % quantile of Student's t.

    They hold whatever correlation the residuals within a block have.
    """
    bread = np.linalg.pinv(jacobian.T @ jacobian)
    names = np.unique(blocks)
    scores = np.stack([jacobian[blocks == name].T @ residual[blocks == name] for name in names])
    freedom = max(names.size - jacobian.shape[1], 1)
    covariance = bread @ (scores.T @ scores) @ bread * names.size / freedom
    return np.sqrt(np.maximum(np.diag(covariance), 0.0)), float(stats.t.ppf(0.975, freedom))


def _interval(value: float, half: float) -> tuple[float, float]:
    return max(float(value - half), 0.0), float(value + half)


def interval_frictions(
    rig: Rig, factors: Array, limits: Sequence[tuple[float, float]], torque_factor: float = 1.0
) -> tuple[IntervalFriction, ...]:
    """Friction of each of the rig file's intervals.

    Args:
        rig: The rig file's rig.
        factors: Found, (k,).
        limits: 95 % confidence interval of each.
        torque_factor: Friction torque over that of the rig file's contact.
    """
    nominal = friction_intervals(rig)
    orientation = rig.contact.asperity.orientation
    axial, tangential = friction_coefficient_of_direction(rig.contact, np.array([0.0, 0.5 * np.pi]) - orientation)
    rows, top = [], 0.0
    for k, (interval, factor, ends) in enumerate(zip(nominal, factors, limits, strict=True)):
        bottom = min(interval.to, rig.string.length)
        rows.append(IntervalFriction(
            kind="open hole" if k == len(nominal) - 1 else "cased",
            top=top,
            bottom=bottom,
            factor=float(factor),
            factor_interval=ends,
            in_rig_file=interval.factor,
            axial=float(factor * axial),
            tangential=float(factor * tangential * torque_factor),
        ))  # fmt: skip
        top = bottom
    return tuple(rows)
