"""The fitting problem: every run's channels in one stack, in noise units, and the model that simulates them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from threading import Lock
from typing import cast

import numpy as np

from slider_drilling.gap.evidence.likelihood import Discrepancy, fit_discrepancy, memory_grid, whiten
from slider_drilling.gap.model import Array, Channel, Effect, HasObserver, Model, Parameter, SimulationOptions, Values
from slider_drilling.gap.problem.noise import TRIM_FRACTION
from slider_drilling.gap.problem.step_loss import step_loss

# Noise units beyond which a missed step of a channel that accumulates costs by its logarithm.
STEP_SIZE = 4.0
# Longest memory of a discrepancy, samples: an error that lasts longer is for an effect to explain.
_SAMPLES = 40.0
# Memory of a discrepancy without memory, in shortest memories: correlations of neighbours vanish.
_NO_MEMORY = 1e-2
FREE_RUN = SimulationOptions()
# Stretches of a run. The length of one is also the longest memory of a discrepancy.
_STRETCHES = 20


@dataclass(frozen=True)
class Piece:
    """One channel of one run within the stack.

    Attributes:
        run: Index of the run.
        channel: The channel.
        rows: Its place in the stack.
        noise: Its noise floor, in the channel's unit.
        interval: (n,) s since the sample before.
        memories: (k,) s, the memories that a discrepancy may have.
        observed: Whether the observer feeds it back.
    """

    run: int
    channel: Channel
    rows: slice
    noise: float
    interval: Array = field(repr=False)
    memories: Array = field(repr=False)
    observed: bool

    @property
    def name(self) -> str:
        """The channel's name."""
        return self.channel.name


class SimulationCounter:
    """Number of simulations run, shared by every problem that is derived from another."""

    def __init__(self) -> None:
        self.count = 0
        self._lock = Lock()

    def add(self, number: int) -> None:
        """Count some more; from any thread."""
        with self._lock:
            self.count += number


@dataclass(frozen=True)
class Problem:
    """A model and its logs. Stacked arrays have length N: runs, then channels, then samples.

    Methods that change something return a new problem; only the counter is shared and grows.

    Attributes:
        model: The model.
        pieces: The channels of all runs.
        options: How the model is simulated.
        correction: (N,) noise units, added to every simulation: what a finer simulation adds to this one at the values
            that `corrected_at` was given.
        counter: Number of simulations run.
        added: By name of a parameter that the model does not have: (N,) noise units that one unit of it adds to every
            simulation.
        white_discrepancy: Whether a discrepancy has no memory: then slow errors count like fast ones.
    """

    model: Model
    pieces: tuple[Piece, ...]
    options: SimulationOptions
    correction: Array = field(repr=False)
    counter: SimulationCounter = field(repr=False, compare=False)
    added: Mapping[str, Array] = field(default_factory=dict, repr=False)
    white_discrepancy: bool = False

    @property
    def size(self) -> int:
        """N."""
        return self.correction.size

    def run_parameters(self, values: Values, run: int) -> dict[str, float]:
        """The parameter set of one run: outside the model, per-run parameters are named ``name@run``."""
        suffix = f"@{run}"
        chosen = {name: value for name, value in values.items() if "@" not in name and name not in self.added}
        return chosen | {name[: -len(suffix)]: value for name, value in values.items() if name.endswith(suffix)}

    def simulate(self, sets: Sequence[Values], options: SimulationOptions | None = None) -> Array:
        """Simulate K parameter sets.

        Args:
            sets: K sets of values.
            options: Other options than the problem's own; then there is no correction.

        Returns:
            (K, N) channels in noise units.
        """
        stacked = np.zeros((len(sets), self.size))
        for run in sorted({piece.run for piece in self.pieces}):
            own_sets = [self.run_parameters(values, run) for values in sets]
            channels = self.model.simulate(run, own_sets, options or self.options)
            self.counter.add(len(sets))
            for piece in self.pieces:
                if piece.run == run:
                    stacked[:, piece.rows] = channels[piece.name] / piece.noise
        for name, row in self.added.items():
            stacked += np.multiply.outer([values.get(name, 0.0) for values in sets], row)
        return stacked if options else stacked + self.correction

    def residual_of(self, simulated: Array) -> Array:
        """(..., N) measured - simulated, in noise units, angles wrapped."""
        residual = np.zeros_like(simulated)
        for piece in self.pieces:
            raw = piece.channel.residual(simulated[..., piece.rows] * piece.noise) / piece.noise
            residual[..., piece.rows] = raw
        return residual

    def residuals(self, sets: Sequence[Values]) -> Array:
        """(K, N) residuals of K parameter sets, in noise units."""
        return self.residual_of(self.simulate(sets))

    def corrected_at(self, values: Values, fidelity: int, fine: Array | None = None) -> Problem:
        """The same problem, corrected to equal a finer simulation at these values.

        Args:
            values: Where the two are equal.
            fidelity: Fidelity of the finer simulation.
            fine: (N,) its result without correction, where it is known already.
        """
        higher = self.simulate([values], replace(self.options, fidelity=fidelity))[0] if fine is None else fine
        return replace(self, correction=self.wrapped(higher - self.simulate([values], self.options)[0]))

    def wrapped(self, difference: Array) -> Array:
        """The difference (N,) of two simulations or samples, without whole periods."""
        shortest = difference.copy()
        for piece in self.pieces:
            if piece.channel.period is not None:
                turn = piece.channel.period / piece.noise
                part = difference[piece.rows]
                shortest[piece.rows] = part - turn * np.round(part / turn)
        return shortest

    def with_options(self, options: SimulationOptions) -> Problem:
        """The same problem with other simulation options, without correction."""
        return replace(self, options=options, correction=np.zeros(self.size))

    def with_noise(self, noise: Sequence[Mapping[str, float]]) -> Problem:
        """The problem of the same model and logs with other noise floors, without correction and added rows."""
        rebuilt = build_problem(self.model, noise, self.options, self.counter)
        return replace(rebuilt, white_discrepancy=self.white_discrepancy)

    def with_added_rows(self, rows: Mapping[str, Array]) -> Problem:
        """The same problem with parameters that the model does not have: by name, (N,) what one unit of each adds."""
        return replace(self, added={**self.added, **rows})

    def restricted_to(self, runs: Collection[int]) -> Problem:
        """The same stack with only these runs simulated and counted; what belongs to other runs is 0."""
        return replace(self, pieces=tuple(piece for piece in self.pieces if piece.run in runs))

    def at_fidelity_of(self, effects: Sequence[Effect]) -> Problem:
        """The same problem in simulations fine enough to show the effects."""
        needed = max((effect.fidelity for effect in effects), default=0)
        return self.with_options(replace(self.options, fidelity=needed)) if needed > self.options.fidelity else self

    def expand_per_run(self, parameters: Sequence[Parameter]) -> list[Parameter]:
        """The parameters as a fit sees them: those that belong to a run once for each run."""
        runs = range(len(self.model.runs))
        expanded = []
        for parameter in parameters:
            copies = [replace(parameter, name=f"{parameter.name}@{run}") for run in runs]
            expanded += copies if parameter.per_run else [parameter]
        return expanded

    def observer_factor(self, piece: Piece) -> float:
        """Factor by which the observer has shrunk the noise in a piece's residual."""
        if not piece.observed or self.options.observer_gain == 0.0:
            return 1.0
        return cast(HasObserver, self.model).noise_shrinkage(piece.run, self.options.observer_gain)

    def cost(self, residual: Array) -> tuple[float, dict[int, Discrepancy]]:
        """``-2 log p`` of a residual (N,), and the likeliest discrepancy of each piece that does not accumulate."""
        total, discrepancies = 0.0, {}
        for index, piece in enumerate(self.pieces):
            part = self.observer_factor(piece) * residual[piece.rows]
            if piece.channel.accumulates:
                total += float(step_loss(self.unwrapped(piece, part), STEP_SIZE)[0].sum())
            else:
                cost, discrepancies[index] = fit_discrepancy(part, piece.interval, self._memories(piece))
                total += cost
        return total, discrepancies

    def _memories(self, piece: Piece) -> Array:
        """(k,) s, the memories that a discrepancy may have in this problem."""
        return _NO_MEMORY * piece.memories[:1] if self.white_discrepancy else piece.memories

    def unwrapped(self, piece: Piece, residual: Array) -> Array:
        """A piece's residual (n,) without jumps of whole periods."""
        if piece.channel.period is None:
            return residual
        return np.unwrap(residual * piece.noise, period=piece.channel.period) / piece.noise

    def log_density(self, residual: Array, discrepancies: Mapping[int, Discrepancy]) -> Array:
        """(N,) each sample's share of ``-2 log p``, given the samples before it."""
        shares = np.zeros(self.size)
        for index, piece in enumerate(self.pieces):
            part = self.observer_factor(piece) * residual[piece.rows]
            if piece.channel.accumulates:
                shares[piece.rows] = step_loss(self.unwrapped(piece, part), STEP_SIZE)[0]
            else:
                white, log_variance = whiten(part[None], piece.interval, discrepancies[index])
                shares[piece.rows] = white[0] ** 2 + log_variance
        return shares

    def whitened(
        self, residual: Array, rows: Array, discrepancies: Mapping[int, Discrepancy], robust: bool = True
    ) -> tuple[Array, Array]:
        """Residual and rows, transformed so that ``-2 log p`` is the residual's square but for a constant.

        Args:
            residual: (N,) in noise units.
            rows: (M, N) changes of the simulation.
            discrepancies: Discrepancy of each piece.
            robust: False to treat each residual as white noise of its own size, without discrepancy or missed steps.
                Far from the optimum, where the likelihood is flat, that shows the way.

        Returns:
            The residual (N,) and the rows (M, N).
        """
        white, out = np.zeros(self.size), np.zeros_like(rows)
        for index, piece in enumerate(self.pieces):
            factor = self.observer_factor(piece)
            part, own = factor * residual[piece.rows], factor * rows[:, piece.rows]
            if not robust:
                whole = self.unwrapped(piece, part)
                size = max(float(np.sqrt(np.mean(whole**2))), 1.0)
                white[piece.rows], out[:, piece.rows] = whole / size, own / size
            elif piece.channel.accumulates:
                # The residual whose square is the loss, and the rows by the chain rule.
                loss, rest = step_loss(self.unwrapped(piece, part), STEP_SIZE)
                mapped = np.sign(rest) * np.sqrt(np.maximum(loss, 0.0))
                tiny = np.abs(mapped) < 1e-3
                slope = np.where(tiny, 1.0, rest / np.where(tiny, 1.0, mapped))
                white[piece.rows], out[:, piece.rows] = np.where(tiny, rest, mapped), slope * own
            else:
                through, _ = whiten(np.vstack([part[None], own]), piece.interval, discrepancies[index])
                white[piece.rows], out[:, piece.rows] = through[0], through[1:]
        return white, out

    def structure(self, residual: Array) -> dict[int, float]:
        """By piece, how much ``-2 log p`` falls if a discrepancy is allowed: little where the residual is noise.

        The worst stretches are left out: a single event that no simulation can time is no missing law.
        """
        gains = {}
        for index, piece in enumerate(self.pieces):
            if not piece.channel.accumulates:
                part, interval = _without_worst(self.observer_factor(piece) * residual[piece.rows], piece.interval)
                gains[index] = float(part @ part) - fit_discrepancy(part, interval, piece.memories)[0]
        return gains


def _without_worst(part: Array, interval: Array) -> tuple[Array, Array]:
    """A residual (n,) and its intervals without the stretches of highest power."""
    stretches = np.array_split(np.arange(part.size), _STRETCHES)
    ordered = sorted(stretches, key=lambda rows: float(np.sum(part[rows] ** 2)))
    kept = np.sort(np.concatenate(ordered[: round(TRIM_FRACTION * _STRETCHES)]))
    return part[kept], interval[kept]


def build_problem(
    model: Model,
    noise: Sequence[Mapping[str, float]],
    options: SimulationOptions = FREE_RUN,
    counter: SimulationCounter | None = None,
) -> Problem:
    """Stack the runs of a model.

    Args:
        model: The model.
        noise: Per run, the noise floor of each channel, in its unit.
        options: How the model is simulated.
        counter: Counter of an earlier problem, to go on counting.

    Raises:
        ValueError: No run holds a channel.
    """
    observed = model.observed_channel if isinstance(model, HasObserver) else None
    pieces, start = [], 0
    for index, run in enumerate(model.runs):
        for channel in run.channels:
            rows = slice(start, start + channel.time.size)
            interval = np.diff(channel.time, prepend=channel.time[:1])
            longest = _longest_memory(run.duration, float(np.median(interval[1:])) if interval.size > 1 else 0.5)
            memories = memory_grid(interval, longest)
            sigma = noise[index][channel.name]
            pieces.append(Piece(index, channel, rows, sigma, interval, memories, channel.name == observed))
            start = rows.stop
    if not pieces:
        raise ValueError("no run holds a channel that can be used")
    return Problem(model, tuple(pieces), options, np.zeros(start), counter or SimulationCounter())


def _longest_memory(duration: float, interval: float) -> float:
    """Longest memory of a discrepancy, s, for a run of this duration with this interval between samples, s.

    A discrepancy with a long memory absorbs every slow error, such as a tool that turns at the wrong time. Calibration
    would then leave a larger gap than it found.
    """
    return max(min(duration / _STRETCHES, _SAMPLES * interval), 2.0 * interval)
