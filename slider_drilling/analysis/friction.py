"""The friction of each hole interval, fitted through the plant to a log's torque and hook load.

Least squares over the friction factor of every interval, together with what else a log may be off in and would
otherwise pass for friction: the twist that the string starts with, slack between drive and string, bit torque,
mud damping, torsional compliance, pipe density, a constant offset of the hook load (travelling gear, calibration),
and one stretch of hole that drags more than the rest (a cuttings bed), where the misfit asks for it.

Samples of one rocking cycle err alike, so intervals come from the spread between blocks of time, not between
samples (cluster-robust sandwich).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, stats

from slider_drilling.contact import friction_coefficient_of_direction
from slider_drilling.diagnosis.replay import measured_channels
from slider_drilling.drillstring import InitialState, Response, simulate_batch
from slider_drilling.effects import CuttingsBed, TopDriveBacklash, TorsionalCompliance
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Channel
from slider_drilling.gap.problem.noise import difference_noise
from slider_drilling.log import RigLog
from slider_drilling.log_inputs.commands_from_log import LogCommands, commands_from_log
from slider_drilling.rig import FrictionInterval, Rig

Array = NDArray[np.float64]

ELEMENTS = 100
"""Half of what the plant needs for 1 % of torque: the factors move by less than 1 %, four times as fast."""
COARSE = 50
"""Elements that the search starts with; it ends with all of them."""
BLOCKS = 30
"""That a log is cut into for the intervals, none longer than 20 s (a rocking period or two)."""
LARGEST_FACTOR = 8.0
BED_PLACES = 12
BED_GAIN = 0.3
"""Share of the misfit that a bed must promise to take away before one is fitted."""
UNKNOWN = 0.5
"""Half-width of an interval, as a share of the factor, above which the log does not tell the factor."""


@dataclass(frozen=True)
class IntervalFriction:
    """Friction of one hole interval: kind is cased or open hole, top and bottom measured depths in m.

    factor multiplies the contact model; factor_interval is its 95 % interval; in_rig_file is what the rig file says.
    axial and tangential: the friction coefficients that go with it along the hole and around it.
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
        """Whether the log says anything of it."""
        low, high = self.factor_interval
        return 0.5 * (high - low) < UNKNOWN * max(self.factor, 0.05)


@dataclass(frozen=True)
class FittedBed:
    """A stretch of hole, measured depths in m, whose friction is factor times its interval's (95 % interval)."""

    top: float
    bottom: float
    factor: float
    factor_interval: tuple[float, float]


@dataclass(frozen=True)
class FrictionFit:
    """The fitted rig, what it starts with, and how well it follows the log (RMS per channel, engineering units)."""

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

    progress(n) is called after every n-th simulation of the log. Raises InputError where the log holds neither
    surface torque nor hook load, or no motion.
    """
    driven = commands_from_log(log, rig)
    channels = [c for name, c in measured_channels(log, rig).items() if name in ("surface_torque", "hook_load")]
    if not driven.block_logged:
        channels = [c for c in channels if c.name == "surface_torque"]
    if not channels:
        raise InputError(f"{log.source}: holds neither surface torque nor hook load; friction shows in nothing else")
    runs = FrictionMisfit(rig, driven, tuple(channels), min(COARSE, elements), progress)
    guess = _first_guess(runs)
    point = _with_slack(runs, guess, _fitted(runs, guess))
    bed = _find_bed(runs, point) if len(channels) > 1 else None
    if bed is not None:
        runs.bed = bed
        point = _fitted(runs, np.append(point, 2.0))
    runs.elements = elements
    point = _fitted(runs, point, most=3)
    final, jacobian = runs.residual(point), runs.jacobian(point)
    errors, reach = _block_errors(jacobian, final, runs.blocks)
    count = runs.intervals
    return FrictionFit(
        rig=runs.rig_at(point),
        start=runs.start_at(point),
        intervals=_intervals(rig, point[:count], reach * errors[:count]),
        channels=tuple(channel.name for channel in channels),
        rms=runs.rms(final),
        rms_before=runs.rms(runs.residual(runs.nominal)),
        inputs=driven,
        bed=None if bed is None else FittedBed(*bed, float(point[-1]), (
            max(float(point[-1] - reach * errors[-1]), 0.0), float(point[-1] + reach * errors[-1]))),
    )  # fmt: skip


def _first_guess(runs: FrictionMisfit) -> Array:
    """The rig file's own friction, or a multiple of it where a field rig's guess is far off."""
    guesses = [runs.nominal.copy() for _ in range(5)]
    for guess, scale in zip(guesses, (1.0, 0.5, 0.7, 1.4, 2.0), strict=True):
        guess[: runs.intervals] = scale * np.maximum(guess[: runs.intervals], 0.05)
    misfits = [np.sum(np.abs(residual)) for residual in runs.residuals(guesses)]
    return guesses[int(np.argmin(misfits))]


def _with_slack(runs: FrictionMisfit, guess: Array, point: Array) -> Array:
    """The fit with slack between drive and string, where that takes a tenth of the misfit away.

    Tried at several widths, since at zero the misfit has no slope and between widths several valleys, and from the
    first guess, since a fit without slack has made damping and friction imitate it.
    """
    place = runs.intervals + SLACK
    tries = [guess + np.where(np.arange(guess.size) == place, width, 0.0) for width in SLACKS]
    before, *misfits = (float(np.sum(residual**2)) for residual in runs.residuals([point, *tries]))
    if before < runs.blocks.size:
        return point
    fitted = _fitted(runs, tries[int(np.argmin(misfits))])
    return fitted if float(np.sum(runs.residual(fitted) ** 2)) < 0.9 * before else point


def _fitted(runs: FrictionMisfit, first: Array, most: int = 12) -> Array:
    """Least squares from a first point over all that is not held: a slack of zero stays zero."""
    free = np.ones(first.size, dtype=bool)
    free[runs.intervals + SLACK] = first[runs.intervals + SLACK] > 0.0
    low, high = runs.bounds(first.size)

    def whole(some: Array) -> Array:
        point = first.copy()
        point[free] = some
        return point

    fit = optimize.least_squares(
        lambda p: np.concatenate([runs.residual(whole(p)), runs.prior(whole(p))]),
        np.clip(first, low + 1e-6, high - 1e-6)[free],
        jac=lambda p: np.concatenate([runs.jacobian(whole(p)), runs.prior_slope(whole(p))])[:, free],
        bounds=(low[free], high[free]), x_scale=runs.scale(first.size)[free], xtol=1e-4, ftol=1e-5, max_nfev=most,
    )  # fmt: skip
    return whole(fit.x)


def _find_bed(runs: FrictionMisfit, point: Array) -> tuple[float, float] | None:
    """The stretch where extra friction would take the most out of the misfit; None where it would take little.

    A twelfth of the hole at a time, by the part of its effect that the other parameters cannot imitate.
    """
    residual, jacobian = runs.residual(point), runs.jacobian(point)
    edges = np.linspace(0.0, runs.rig.string.length, BED_PLACES + 1)
    places = [(float(a), float(b)) for a, b in itertools.pairwise(edges)]
    moved = runs.residuals([np.append(point, 1.2)] * len(places), places)
    basis, _ = np.linalg.qr(jacobian)
    left = residual - basis @ (basis.T @ residual)
    gains = []
    for other in moved:
        slope = (other - residual) / 0.2
        slope = slope - basis @ (basis.T @ slope)
        step = -float(slope @ left) / max(float(slope @ slope), 1e-12)
        gains.append(float(slope @ left) ** 2 / max(float(slope @ slope), 1e-12) if step > 0.0 else 0.0)
    best = int(np.argmax(gains))
    excess = float(left @ left) - left.size
    return places[best] if excess > 0.2 * left.size and gains[best] > BED_GAIN * excess else None


@dataclass(frozen=True)
class FitParameter:
    """Something other than friction that the fit may change.

    nominal: its value in the rig file; spread: how far off it may well be (a prior); low, high: bounds; nudge: step of
    its difference quotient; scale: a typical change.
    """

    nominal: float
    spread: float
    low: float
    high: float
    nudge: float
    scale: float


TWIST, SLACK, BIT, DAMPING, COMPLIANCE, DENSITY = range(6)
NUISANCES = (
    FitParameter(0.0, 20.0, -60.0, 60.0, 0.05, 1.0),
    FitParameter(0.0, 0.5, 0.0, 3.0, 0.02, 0.1),
    FitParameter(1.0, 0.3, 0.2, 3.0, 0.02, 0.1),
    FitParameter(1.0, 0.3, 0.0, 6.0, 0.05, 0.2),
    FitParameter(0.0, 0.05, -0.3, 0.5, 0.005, 0.03),
    FitParameter(1.0, 0.03, 0.8, 1.2, 0.005, 0.02),
)
SLACKS = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6)
"""rad; widths that are tried."""
"""Start twist, rad; slack, rad, full width; bit aggressiveness and torsional damping over the rig file's; extra
torsional compliance, as a share; density of the pipe over the rig file's (tool joints, wear). A few per cent of the
last two, which set the torque of a reversal, pass for a quarter of the cased hole's friction."""


class FrictionMisfit:
    """The log simulated at points of the search: factors of the intervals, NUISANCES, then a bed's factor if any.

    Residuals are of the chosen channels, in noise units, joined.
    """

    def __init__(
        self, rig: Rig, driven: LogCommands, channels: tuple[Channel, ...], elements: int,
        progress: Callable[[int], None] | None,
    ) -> None:  # fmt: skip
        self.rig, self.driven, self.channels, self.elements, self.progress = rig, driven, channels, elements, progress
        # Never below what the model itself is good for, or a noise-free log would weigh hook load by its last digit.
        floors = {"surface_torque": 20.0, "hook_load": 400.0}
        self.scales = [max(difference_noise(c.measured), floors[c.name]) for c in channels]
        duration = float(driven.commands.time[-1] - driven.commands.time[0])
        block = min(20.0, duration / BLOCKS)
        self.blocks = np.concatenate([np.floor(c.time / block).astype(int) for c in channels])
        factors = [interval.factor for interval in rig.well.friction_intervals] or [1.0]
        self.intervals = len(factors)
        self.nominal = np.array([*factors, *(nuisance.nominal for nuisance in NUISANCES)])
        self.bed: tuple[float, float] | None = None
        self.count = 0

    def rig_at(self, point: Array, bed: tuple[float, float] | None = None) -> Rig:
        rig = _with_factors(self.rig, point[: self.intervals])
        _, slack, bit, damping, compliance, density = point[self.intervals : self.intervals + len(NUISANCES)]
        effects = replace(
            rig.effects,
            top_drive_backlash=TopDriveBacklash(rig.effects.top_drive_backlash.angle + float(slack)),
            torsional_compliance=TorsionalCompliance(
                (1.0 + rig.effects.torsional_compliance.extra) * (1.0 + float(compliance)) - 1.0
            ),
        )
        bed = bed or self.bed
        if bed is not None and point.size > self.nominal.size:
            effects = replace(effects, cuttings_bed=CuttingsBed(float(point[-1]), *map(float, bed)))
        return replace(
            rig,
            bit=replace(rig.bit, aggressiveness=rig.bit.aggressiveness * float(bit)),
            string=replace(
                rig.string,
                torsional_damping=rig.string.torsional_damping * float(damping),
                density=rig.string.density * float(density),
            ),
            effects=effects,
        )

    def start_at(self, point: Array) -> InitialState:
        return InitialState(twist=float(point[self.intervals + TWIST]))

    def residuals(self, points: list[Array], beds: list[tuple[float, float]] | None = None) -> list[Array]:
        places: list[tuple[float, float] | None] = [*beds] if beds else [self.bed] * len(points)
        rigs = [self.rig_at(point, bed) for point, bed in zip(points, places, strict=True)]
        starts = [self.start_at(point) for point in points]
        faster = self.driven.acceleration_for(self.rig)
        responses = simulate_batch(rigs, self.driven.commands, self.elements, starts, acceleration=faster)
        self.count += len(points)
        if self.progress is not None:
            self.progress(self.count)
        return [self._difference(response) for response in responses]

    def _difference(self, response: Response) -> Array:
        parts = []
        for channel, scale in zip(self.channels, self.scales, strict=True):
            simulated = np.interp(channel.time, response.time, getattr(response, channel.name))
            difference = simulated - channel.measured
            if channel.name == "hook_load":
                difference = difference - np.median(difference)
            parts.append(difference / scale)
        return np.concatenate(parts)

    def residual(self, point: Array) -> Array:
        return self.residuals([point])[0]

    def jacobian(self, point: Array) -> Array:
        nudges = self._column(point.size, 0.01, "nudge")
        moved = [point + np.where(np.arange(point.size) == k, nudges, 0.0) for k in range(point.size)]
        base, *others = self.residuals([point, *moved])
        return np.stack([(other - base) / nudge for other, nudge in zip(others, nudges, strict=True)], axis=1)

    def prior(self, point: Array) -> Array:
        nuisance = slice(self.intervals, self.nominal.size)
        return (point[nuisance] - self.nominal[nuisance]) / np.array([n.spread for n in NUISANCES])

    def prior_slope(self, point: Array) -> Array:
        slope = np.zeros((len(NUISANCES), point.size))
        slope[:, self.intervals : self.nominal.size] = np.diag([1.0 / n.spread for n in NUISANCES])
        return slope

    def bounds(self, size: int) -> tuple[Array, Array]:
        low = self._column(size, 0.0, "low")
        low[self.nominal.size :] = 1.0  # a bed drags more than the hole around it
        return low, self._column(size, LARGEST_FACTOR, "high")

    def scale(self, size: int) -> Array:
        return self._column(size, 0.1, "scale")

    def _column(self, size: int, of_factors: float, name: str) -> Array:
        """One number a parameter: the same for every factor, a nuisance's own otherwise."""
        row = np.full(size, of_factors)
        row[self.intervals : self.nominal.size] = [getattr(nuisance, name) for nuisance in NUISANCES]
        return row

    def rms(self, residual: Array) -> dict[str, float]:
        ends = np.cumsum([c.time.size for c in self.channels])
        parts = np.split(residual, ends[:-1])
        return {
            c.name: float(scale * np.sqrt(np.mean(part**2)))
            for c, scale, part in zip(self.channels, self.scales, parts, strict=True)
        }


def _block_errors(jacobian: Array, residual: Array, blocks: NDArray[np.int_]) -> tuple[Array, float]:
    """Standard errors that hold whatever the residuals of one block have in common, and the 95 % quantile."""
    bread = np.linalg.pinv(jacobian.T @ jacobian)
    names = np.unique(blocks)
    scores = np.stack([jacobian[blocks == name].T @ residual[blocks == name] for name in names])
    freedom = max(names.size - jacobian.shape[1], 1)
    covariance = bread @ (scores.T @ scores) @ bread * names.size / freedom
    return np.sqrt(np.maximum(np.diag(covariance), 0.0)), float(stats.t.ppf(0.975, freedom))


def _with_factors(rig: Rig, factors: Array) -> Rig:
    own = rig.well.friction_intervals or (FrictionInterval(to=rig.string.length, factor=1.0),)
    fitted = tuple(FrictionInterval(to=i.to, factor=float(f)) for i, f in zip(own, factors, strict=True))
    return replace(rig, well=replace(rig.well, friction_intervals=fitted))


def _intervals(rig: Rig, factors: Array, reach: Array) -> tuple[IntervalFriction, ...]:
    own = rig.well.friction_intervals or (FrictionInterval(to=rig.string.length, factor=1.0),)
    orientation = rig.contact.asperity.orientation
    axial, tangential = friction_coefficient_of_direction(rig.contact, np.array([0.0, 0.5 * np.pi]) - orientation)
    rows, top = [], 0.0
    for k, (interval, factor, half) in enumerate(zip(own, factors, reach, strict=True)):
        bottom = min(interval.to, rig.string.length)
        kind = "open hole" if k == len(own) - 1 else "cased"
        rows.append(
            IntervalFriction(
                kind,
                top,
                bottom,
                float(factor),
                (max(float(factor - half), 0.0), float(factor + half)),
                interval.factor,
                float(factor * axial),
                float(factor * tangential),
            )
        )
        top = bottom
    return tuple(rows)
