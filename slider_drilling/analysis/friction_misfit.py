"""The misfit between a log and the plant, as a function of friction factors and nuisance parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring import InitialState, Response, simulate_batch
from slider_drilling.effects import CuttingsBed, TopDriveBacklash, TorsionalCompliance
from slider_drilling.gap.model import Channel
from slider_drilling.gap.problem.noise import difference_noise
from slider_drilling.log_inputs.commands_from_log import LogCommands
from slider_drilling.rig import FrictionInterval, Rig

Array = NDArray[np.float64]

MAX_FACTOR = 8.0
_MAX_BLOCKS, _MAX_BLOCK_S = 30, 20.0  # that a log is cut into; a block spans a rocking period or two at most
# Smallest noise that is assumed, N m and N: the accuracy of the model itself. Without it a noise-free log would weigh
# hook load by its last digit.
_MIN_NOISE = {"surface_torque": 20.0, "hook_load": 400.0}


@dataclass(frozen=True)
class FrictionNuisance:
    """A nuisance parameter of the fit: something other than friction.

    Attributes:
        nominal: Value that stands for the rig file's.
        spread: Standard deviation of its prior.
        low, high: Bounds.
        step: Of its difference quotient.
        scale: A typical change.
    """

    nominal: float
    spread: float
    low: float
    high: float
    step: float
    scale: float


# Compliance and density set the torque of a reversal. A few per cent of them (tool joints, wear) look like a quarter of
# the cased hole's friction.
NUISANCES = {
    "start_twist": FrictionNuisance(0.0, 20.0, -60.0, 60.0, 0.05, 1.0),  # rad
    "backlash": FrictionNuisance(0.0, 0.5, 0.0, 3.0, 0.02, 0.1),  # rad, full width
    "bit_aggressiveness": FrictionNuisance(1.0, 0.3, 0.2, 3.0, 0.02, 0.1),  # over the rig file's
    "torsional_damping": FrictionNuisance(1.0, 0.3, 0.0, 6.0, 0.05, 0.2),  # over the rig file's
    "torsional_compliance": FrictionNuisance(0.0, 0.05, -0.3, 0.5, 0.005, 0.03),  # extra, relative
    "pipe_density": FrictionNuisance(1.0, 0.03, 0.8, 1.2, 0.005, 0.02),  # over the rig file's
}


class FrictionMisfit:
    """Residuals of the plant against a log, as a function of a point of the search.

    A point holds the factors of the friction intervals, then `NUISANCES`, then the factor of a cuttings bed if one is
    fitted. Residuals are simulated minus measured in noise units, all channels joined.

    Args:
        rig: The rig file's.
        inputs: Commands from the log.
        channels: That are compared.
        elements: Of the string; may be changed between fits.
        progress: Called with the number of simulations so far.

    Attributes:
        bed: Measured depths (m) between which the cuttings bed of a point lies.
        blocks: Block of time of each residual, for cluster-robust errors.
        intervals: Number of friction intervals.
        nominal: The point that stands for the rig file.
    """

    def __init__(
        self, rig: Rig, inputs: LogCommands, channels: tuple[Channel, ...], elements: int,
        progress: Callable[[int], None] | None,
    ) -> None:  # fmt: skip
        self.rig, self.inputs, self.channels, self.elements, self.progress = rig, inputs, channels, elements, progress
        self.noise = [max(difference_noise(c.measured), _MIN_NOISE[c.name]) for c in channels]
        duration = float(inputs.commands.time[-1] - inputs.commands.time[0])
        block = min(_MAX_BLOCK_S, duration / _MAX_BLOCKS)
        self.blocks = np.concatenate([np.floor(c.time / block).astype(int) for c in channels])
        factors = [interval.factor for interval in friction_intervals(rig)]
        self.intervals = len(factors)
        self.nominal = np.array([*factors, *(nuisance.nominal for nuisance in NUISANCES.values())])
        self.bed: tuple[float, float] | None = None
        self.count = 0

    def rig_at(self, point: Array, bed: tuple[float, float] | None = None) -> Rig:
        """The rig of a point; bed: where its cuttings bed lies, instead of `self.bed`."""
        rig = with_friction_factors(self.rig, point[: self.intervals])
        _, backlash, bit, damping, compliance, density = point[self.intervals : self.intervals + len(NUISANCES)]
        effects = replace(
            rig.effects,
            top_drive_backlash=TopDriveBacklash(rig.effects.top_drive_backlash.angle + float(backlash)),
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
                weight_factor=rig.string.weight_factor * float(density),
            ),
            effects=effects,
        )

    def start_at(self, point: Array) -> InitialState:
        """The initial state of a point."""
        return InitialState(twist=float(point[self.index("start_twist")]))

    def index(self, nuisance: str) -> int:
        """Index of a nuisance parameter in a point."""
        return self.intervals + list(NUISANCES).index(nuisance)

    def residuals(self, points: list[Array], beds: list[tuple[float, float]] | None = None) -> list[Array]:
        """Residuals of several points in one batch of simulations; beds: one a point, instead of `self.bed`."""
        places: list[tuple[float, float] | None] = [*beds] if beds else [self.bed] * len(points)
        rigs = [self.rig_at(point, bed) for point, bed in zip(points, places, strict=True)]
        starts = [self.start_at(point) for point in points]
        acceleration = self.inputs.acceleration_for(self.rig)
        responses = simulate_batch(rigs, self.inputs.commands, self.elements, starts, acceleration=acceleration)
        self.count += len(points)
        if self.progress is not None:
            self.progress(self.count)
        return [self._difference(response) for response in responses]

    def _difference(self, response: Response) -> Array:
        parts = []
        for channel, scale in zip(self.channels, self.noise, strict=True):
            simulated = np.interp(channel.time, response.time, getattr(response, channel.name))
            difference = simulated - channel.measured
            if channel.name == "hook_load":
                difference = difference - np.median(difference)
            parts.append(difference / scale)
        return np.concatenate(parts)

    def residual(self, point: Array) -> Array:
        """Residuals of one point, (m,)."""
        return self.residuals([point])[0]

    def jacobian(self, point: Array) -> Array:
        """Derivatives of the residuals, (m, parameters), by difference quotients."""
        steps = self._column(point.size, 0.01, "step")
        moved = [point + np.where(np.arange(point.size) == k, steps, 0.0) for k in range(point.size)]
        base, *others = self.residuals([point, *moved])
        return np.stack([(other - base) / step for other, step in zip(others, steps, strict=True)], axis=1)

    def prior(self, point: Array) -> Array:
        """Nuisance parameters in units of their prior, as further residuals."""
        nuisance = slice(self.intervals, self.nominal.size)
        return (point[nuisance] - self.nominal[nuisance]) / np.array([n.spread for n in NUISANCES.values()])

    def prior_jacobian(self, point: Array) -> Array:
        """Derivatives of `prior`."""
        slope = np.zeros((len(NUISANCES), point.size))
        slope[:, self.intervals : self.nominal.size] = np.diag([1.0 / n.spread for n in NUISANCES.values()])
        return slope

    def bounds(self, size: int) -> tuple[Array, Array]:
        """Lower and upper bounds of a point of this size."""
        low = self._column(size, 0.0, "low")
        low[self.nominal.size :] = 1.0  # a bed has more friction than the hole around it
        return low, self._column(size, MAX_FACTOR, "high")

    def scale(self, size: int) -> Array:
        """Typical change of each parameter."""
        return self._column(size, 0.1, "scale")

    def _column(self, size: int, of_factors: float, name: str) -> Array:
        """One value per parameter: the same for every friction factor, and the nuisances' own."""
        row = np.full(size, of_factors)
        row[self.intervals : self.nominal.size] = [getattr(nuisance, name) for nuisance in NUISANCES.values()]
        return row

    def rms(self, residual: Array) -> dict[str, float]:
        """RMS of each channel in its own unit."""
        ends = np.cumsum([c.time.size for c in self.channels])
        parts = np.split(residual, ends[:-1])
        return {
            c.name: float(scale * np.sqrt(np.mean(part**2)))
            for c, scale, part in zip(self.channels, self.noise, parts, strict=True)
        }


def friction_intervals(rig: Rig) -> tuple[FrictionInterval, ...]:
    """The rig file's friction intervals, or one for the whole hole."""
    return rig.well.friction_intervals or (FrictionInterval(to=rig.string.length, factor=1.0),)


def with_friction_factors(rig: Rig, factors: Array) -> Rig:
    """The rig with these factors of its friction intervals, (k,)."""
    pairs = zip(friction_intervals(rig), factors, strict=True)
    fitted = tuple(FrictionInterval(to=interval.to, factor=float(factor)) for interval, factor in pairs)
    return replace(rig, well=replace(rig.well, friction_intervals=fitted))
