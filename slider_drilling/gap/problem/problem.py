"""What is to be explained: every run's channels in one stack, in noise units, and how the model is run against them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from threading import Lock

import numpy as np

from slider_drilling.gap.evidence.likelihood import Discrepancy, fit_discrepancy, memory_grid, whiten
from slider_drilling.gap.model import Array, Channel, Effect, HasObserver, Model, Parameter, SimulationOptions, Values
from slider_drilling.gap.problem.noise import TRIM_FRACTION
from slider_drilling.gap.problem.step_loss import step_loss

# Noise units beyond which a missed step of a channel that accumulates costs by its logarithm.
STEP_SIZE = 4.0
# Samples that a discrepancy remembers at most: what errs for longer is for a law to explain.
_SAMPLES = 40.0
FREE_RUN = SimulationOptions()
# Stretches of a run, one being what a discrepancy remembers at most, too.
_STRETCHES = 20


@dataclass(frozen=True)
class Piece:
    """One channel of one run within the stack.

    rows: where it stands in the stack; noise: its standard deviation in the channel's unit; interval: (n,) s between
    samples; memories: s, that a discrepancy may have; pulled: whether the observer feeds it back.
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
        return self.channel.name


class SimulationCounter:
    """How many simulations were run in all, whoever asked for them: shared by every problem made from another."""

    def __init__(self) -> None:
        self.count = 0
        self._lock = Lock()

    def add(self, number: int) -> None:
        """Count some more; from any thread."""
        with self._lock:
            self.count += number


@dataclass(frozen=True)
class Problem:
    """A model against its logs. Everything stacked has length N: runs, then channels, then samples.

    correction: (N,) noise units, what finer simulations add to cheap ones at the values that `at` was given; it is
    part of every simulation. added: (N,) noise units by name, what a parameter adds to every simulation that the model
    knows nothing of. Nothing here ever changes but what was spent: `at`, `run_as` and `adding` give new problems.
    """

    model: Model
    pieces: tuple[Piece, ...]
    options: SimulationOptions
    correction: Array = field(repr=False)
    counter: SimulationCounter = field(repr=False, compare=False)
    added: Mapping[str, Array] = field(default_factory=dict, repr=False)

    @property
    def size(self) -> int:
        return self.correction.size

    @property
    def time(self) -> Array:
        """(N,) s."""
        return np.concatenate([piece.channel.time for piece in self.pieces])

    def run_parameters(self, values: Values, run: int) -> dict[str, float]:
        """The parameter set of one run: per-run parameters are named ``name@run`` outside the model."""
        suffix = f"@{run}"
        chosen = {name: value for name, value in values.items() if "@" not in name and name not in self.added}
        return chosen | {name[: -len(suffix)]: value for name, value in values.items() if name.endswith(suffix)}

    def simulate(self, sets: Sequence[Values], options: SimulationOptions | None = None) -> Array:
        """(K, N) simulated channels in noise units; how: another way than the problem's own, then uncorrected."""
        stacked = np.zeros((len(sets), self.size))
        for run in sorted({piece.run for piece in self.pieces}):
            found = self.model.simulate(
                run, [self.run_parameters(values, run) for values in sets], options or self.options
            )
            self.counter.add(len(sets))
            for piece in self.pieces:
                if piece.run == run:
                    stacked[:, piece.rows] = found[piece.name] / piece.noise
        for name, row in self.added.items():
            stacked += np.multiply.outer([values.get(name, 0.0) for values in sets], row)
        return stacked if options else stacked + self.correction

    def residual_of(self, simulated: Array) -> Array:
        """(..., N) residuals, measured - simulated in noise units; angles wrapped."""
        residual = np.zeros_like(simulated)
        for piece in self.pieces:
            raw = piece.channel.residual(simulated[..., piece.rows] * piece.noise) / piece.noise
            residual[..., piece.rows] = raw
        return residual

    def residuals(self, sets: Sequence[Values]) -> Array:
        """(K, N) residuals in noise units."""
        return self.residual_of(self.simulate(sets))

    def corrected_at(self, values: Values, fidelity: int, fine: Array | None = None) -> Problem:
        """The same problem whose simulations at these values equal those of a higher fidelity; fine: (N,) the latter,
        uncorrected, where they are known already.
        """
        higher = self.simulate([values], replace(self.options, fidelity=fidelity))[0] if fine is None else fine
        return replace(self, correction=self.wrapped(higher - self.simulate([values], self.options)[0]))

    def wrapped(self, difference: Array) -> Array:
        """The difference (N,) of two simulations or samples without whole periods."""
        shortest = difference.copy()
        for piece in self.pieces:
            if piece.channel.period is not None:
                turn = piece.channel.period / piece.noise
                part = difference[piece.rows]
                shortest[piece.rows] = part - turn * np.round(part / turn)
        return shortest

    def with_options(self, options: SimulationOptions) -> Problem:
        """The same problem simulated in another way, without correction."""
        return replace(self, options=options, correction=np.zeros(self.size))

    def with_added_rows(self, rows: Mapping[str, Array]) -> Problem:
        """The same problem to every simulation of which parameters of these names add such rows (N,), noise units."""
        return replace(self, added={**self.added, **rows})

    def restricted_to(self, runs: Collection[int]) -> Problem:
        """The same stack of which only these runs are simulated and count; what belongs to others is 0."""
        return replace(self, pieces=tuple(piece for piece in self.pieces if piece.run in runs))

    def at_fidelity_of(self, effects: Sequence[Effect]) -> Problem:
        """The same problem in simulations that show the effects: finer ones where one of them asks for it."""
        asked = max((effect.fidelity for effect in effects), default=0)
        return self.with_options(replace(self.options, fidelity=asked)) if asked > self.options.fidelity else self

    def expand_per_run(self, parameters: Sequence[Parameter]) -> list[Parameter]:
        """The parameters as a fit sees them: one copy per run of those that belong to the run."""
        runs = range(len(self.model.runs))
        found = []
        for parameter in parameters:
            copies = [replace(parameter, name=f"{parameter.name}@{run}") for run in runs]
            found += copies if parameter.per_run else [parameter]
        return found

    def observer_factor(self, piece: Piece) -> float:
        """By how much a piece's residual was shrunk by the observer's pull."""
        return 1.0 + self.options.observer_gain if piece.observed else 1.0

    def cost(self, residual: Array) -> tuple[float, dict[int, Discrepancy]]:
        """``-2 log p`` of a residual (N,), and the discrepancy of each piece that does not accumulate."""
        total, found = 0.0, {}
        for index, piece in enumerate(self.pieces):
            part = self.observer_factor(piece) * residual[piece.rows]
            if piece.channel.accumulates:
                total += float(step_loss(self.unwrapped(piece, part), STEP_SIZE)[0].sum())
            else:
                cost, found[index] = fit_discrepancy(part, piece.interval, piece.memories)
                total += cost
        return total, found

    def unwrapped(self, piece: Piece, residual: Array) -> Array:
        """A piece's residual (n,) without jumps of whole periods."""
        if piece.channel.period is None:
            return residual
        return np.unwrap(residual * piece.noise, period=piece.channel.period) / piece.noise

    def log_density(self, residual: Array, found: Mapping[int, Discrepancy]) -> Array:
        """(N,) each sample's share of ``-2 log p`` given the samples before it."""
        shares = np.zeros(self.size)
        for index, piece in enumerate(self.pieces):
            part = self.observer_factor(piece) * residual[piece.rows]
            if piece.channel.accumulates:
                shares[piece.rows] = step_loss(self.unwrapped(piece, part), STEP_SIZE)[0]
            else:
                white, price = whiten(part[None], piece.interval, found[index])
                shares[piece.rows] = white[0] ** 2 + price
        return shares

    def whitened(
        self, residual: Array, rows: Array, found: Mapping[int, Discrepancy], forgiving: bool = True
    ) -> tuple[Array, Array]:
        """Residual (N,) and rows (M, N) so that ``-2 log p`` is the residual's square but for a constant.

        forgiving: false takes what is left for one error of its own size throughout, neither a discrepancy that
        forgets nor missed steps: from afar, where the likelihood is flat, that shows the way.
        """
        white, out = np.zeros(self.size), np.zeros_like(rows)
        for index, piece in enumerate(self.pieces):
            gain = self.observer_factor(piece)
            part, own = gain * residual[piece.rows], gain * rows[:, piece.rows]
            if not forgiving:
                whole = self.unwrapped(piece, part)
                size = max(float(np.sqrt(np.mean(whole**2))), 1.0)
                white[piece.rows], out[:, piece.rows] = whole / size, own / size
            elif piece.channel.accumulates:
                loss, rest = step_loss(self.unwrapped(piece, part), STEP_SIZE)
                mapped = np.sign(rest) * np.sqrt(np.maximum(loss, 0.0))
                tiny = np.abs(mapped) < 1e-3
                slope = np.where(tiny, 1.0, rest / np.where(tiny, 1.0, mapped))
                white[piece.rows], out[:, piece.rows] = np.where(tiny, rest, mapped), slope * own
            else:
                through, _ = whiten(np.vstack([part[None], own]), piece.interval, found[index])
                white[piece.rows], out[:, piece.rows] = through[0], through[1:]
        return white, out

    def structure(self, residual: Array) -> dict[int, float]:
        """By how much ``-2 log p`` of each piece falls for allowing it a discrepancy: little where it is noise.

        Its worst stretches are left out: a single event that no simulation can time is no law that is missing.
        """
        found = {}
        for index, piece in enumerate(self.pieces):
            if not piece.channel.accumulates:
                part, interval = _without_worst(self.observer_factor(piece) * residual[piece.rows], piece.interval)
                found[index] = float(part @ part) - fit_discrepancy(part, interval, piece.memories)[0]
        return found


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
    """Stack a model's runs; noise: standard deviation by channel, one mapping a run; spent: what was run before, to go
    on counting. ValueError without a channel.
    """
    fed = model.observed_channel if isinstance(model, HasObserver) else None
    pieces, start = [], 0
    for index, run in enumerate(model.runs):
        for channel in run.channels:
            rows = slice(start, start + channel.time.size)
            interval = np.diff(channel.time, prepend=channel.time[:1])
            longest = _longest_memory(run.duration, float(np.median(interval[1:])) if interval.size > 1 else 0.5)
            memories = memory_grid(interval, longest)
            sigma = noise[index][channel.name]
            pieces.append(Piece(index, channel, rows, sigma, interval, memories, channel.name == fed))
            start = rows.stop
    if not pieces:
        raise ValueError("no run holds a channel that can be used")
    return Problem(model, tuple(pieces), options, np.zeros(start), counter or SimulationCounter())


def _longest_memory(duration: float, interval: float) -> float:
    """Memory s that a discrepancy has at most; interval: s between samples.

    A likelihood that forgives whatever is slow takes a tool that turns at the wrong time for a discrepancy, and
    re-tuning then leaves a larger gap than it found.
    """
    return max(min(duration / _STRETCHES, _SAMPLES * interval), 2.0 * interval)
