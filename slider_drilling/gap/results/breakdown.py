"""Where the gap lies: its shares by channel, phase of the motion, frequency band, time, and position in the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.model import Array, HasProbes, LoggedRun
from slider_drilling.gap.problem.cycles import cycle_period
from slider_drilling.gap.search.least_squares import bounded_step, prior_weights
from slider_drilling.gap.selection.state import FittedModel

PHASES = ("rotating clockwise", "rotating counter-clockwise", "reversal", "still")
TIME_WINDOWS = 20
# Standard deviation of a probe's prior (a multiplier between two positions), and its finite-difference step.
_PROBE_SPREAD, _PROBE_STEP = 0.5, 0.2


@dataclass(frozen=True)
class GapBreakdown:
    """Shares of the calibrated E^2. Each adds up to 1.

    Attributes:
        channel: By channel.
        phase: By one of `PHASES`.
        band: By frequency band.
        time: Rows with ``from`` and ``to``, s, and ``share``; with several runs also ``run``.
        depth: Rows with ``from`` and ``to``, ``share`` and ``change``, see `break_down_along`.
    """

    channel: dict[str, float]
    phase: dict[str, float]
    band: dict[str, float]
    time: list[dict[str, float]]
    depth: list[dict[str, float]]


def break_down_gap(fitted: FittedModel) -> GapBreakdown:
    """Split the held-out gap of a model."""
    problem, score = fitted.problem, fitted.score
    energy = score.squares / score.squares.sum()
    channel: dict[str, float] = {}
    phase = dict.fromkeys(PHASES, 0.0)
    windows = np.zeros((len(problem.model.runs), TIME_WINDOWS))
    band: dict[str, float] = {}
    for piece in problem.pieces:
        run, own = problem.model.runs[piece.run], energy[piece.rows]
        channel[piece.name] = channel.get(piece.name, 0.0) + float(own.sum())
        labels = motion_phase(run, piece.channel.time)
        for code, name in enumerate(PHASES):
            phase[name] += float(own[labels == code].sum())
        window = ((piece.channel.time - run.time[0]) / run.duration * TIME_WINDOWS).astype(int)
        np.add.at(windows[piece.run], np.clip(window, 0, TIME_WINDOWS - 1), own)
        for name, share in _band_shares(run, piece.channel.time, score.residual[piece.rows]).items():
            band[name] = band.get(name, 0.0) + share * float(own.sum())
    return GapBreakdown(channel, phase, band, _time_rows(fitted, windows), break_down_along(fitted))


def _time_rows(fitted: FittedModel, windows: Array) -> list[dict[str, float]]:
    """Shares by time window, from (runs, windows)."""
    rows = []
    runs = fitted.problem.model.runs
    for index, run in enumerate(runs):
        edges = np.linspace(run.time[0], run.time[-1], TIME_WINDOWS + 1)
        for k in range(TIME_WINDOWS):
            row = {"from": float(edges[k]), "to": float(edges[k + 1]), "share": float(windows[index, k])}
            rows.append(row if len(runs) == 1 else {"run": float(index)} | row)
    return rows


def motion_phase(run: LoggedRun, times: Array) -> Array:
    """Phase of the excitation at given times.

    Still: slower than 2 % of the fastest. Reversal: within a twentieth of a cycle (at most 1 s) of a change of
    direction.

    Args:
        run: The run.
        times: (n,) s.

    Returns:
        (n,) index into `PHASES`.
    """
    speed = np.gradient(run.excitation, run.time)
    fastest = float(np.max(np.abs(speed)))
    labels = np.where(speed >= 0.0, 0, 1)
    if fastest > 0.0:
        moving = np.abs(speed) > 0.02 * fastest
        direction = np.sign(speed[moving])
        turns = run.time[moving][1:][np.diff(direction) != 0.0]
        period = cycle_period(run.time, run.excitation)
        reach = 1.0 if period is None else min(0.05 * period, 1.0)
        for turn in turns:
            labels[np.abs(run.time - turn) <= reach] = 2
        labels[~moving & (labels != 2)] = 3
    else:
        labels[:] = 3
    nearest = np.clip(np.searchsorted(run.time, times), 0, run.time.size - 1)
    return np.asarray(labels[nearest])


def _band_shares(run: LoggedRun, times: Array, values: Array) -> dict[str, float]:
    """Shares by frequency of one channel's residual, from its periodogram (they add up to 1 by Parseval)."""
    interval = (times[-1] - times[0]) / max(times.size - 1, 1)
    power = np.abs(np.fft.rfft(values)) ** 2
    # Every bin but the first (and the last of an even length) stands for two.
    power[1 : (values.size + 1) // 2] *= 2.0
    power /= max(float(power.sum()), 1e-300)
    frequency = np.fft.rfftfreq(values.size, max(interval, 1e-9))
    return {
        name: float(power[(frequency >= low) & (frequency < high)].sum()) for name, low, high in band_edges(run)
    }


def band_edges(run: LoggedRun) -> list[tuple[str, float, float]]:
    """Adjoining bands (name, from Hz, to Hz) that cover all frequencies, lowest first."""
    period = cycle_period(run.time, run.excitation)
    edges: list[tuple[str, float, float]] = []
    upper = 0.0
    if period is not None:
        edges += [
            (f"below the {run.cycle} frequency", 0.0, 0.5 / period),
            (f"{run.cycle} and its harmonics", 0.5 / period, 3.5 / period),
        ]
        upper = 3.5 / period
    for name, low, high in run.bands:
        if high <= upper:
            continue
        if low > upper:
            edges.append((f"between, up to {name}", upper, low))
        edges.append((name, max(low, upper), high))
        upper = high
    return [*edges, ("above", upper, np.inf)]


def break_down_along(fitted: FittedModel) -> list[dict[str, float]]:
    """Which stretch of the model must carry more or less to explain the residual.

    A ridge regression of the residual on the model's probes, each within its bounds, beside the freed parameters.

    Returns:
        Rows with ``from`` and ``to``; ``share`` of what all probes explain together; and ``change``, the multiplier's
        difference from nominal. Empty if the model has no probes.
    """
    problem, fit = fitted.problem, fitted.fit
    model = problem.model
    if not isinstance(model, HasProbes) or not model.probes:
        return []
    probes = model.probes
    moved = problem.simulate([fit.values | {p.name: p.nominal + _PROBE_STEP} for p, _, _ in probes])
    rows = np.vstack([fit.jacobian, (moved - fit.simulated) / _PROBE_STEP])
    white, through = problem.whitened(fit.residual, rows, fit.discrepancy)
    own = len(fit.parameters)
    prior = np.concatenate([prior_weights(fit.parameters) ** 2 + 1e-9, np.full(len(probes), _PROBE_SPREAD**-2)])
    free = np.full(own, np.inf)
    low = np.append(-free, [p.lower - p.nominal for p, _, _ in probes])
    high = np.append(free, [p.upper - p.nominal for p, _, _ in probes])
    change = bounded_step(through @ through.T + np.diag(prior), through @ white, 0.0, low, high)[own:]
    # Of each probe only the part counts that the freed parameters cannot make.
    basis, _ = np.linalg.qr(through[:own].T)
    beyond = through[own:] - (through[own:] @ basis) @ basis.T
    part = np.abs(change) * np.linalg.norm(beyond, axis=1)
    part = part / part.sum() if part.sum() > 0.0 else part
    return [
        {"from": start, "to": end, "share": float(share), "change": float(amount)}
        for (_, start, end), share, amount in zip(probes, part, change, strict=True)
    ]
