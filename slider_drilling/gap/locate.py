"""Where the gap lies: its shares by channel, phase of the motion, frequency band, time, and place along the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.contender import Base
from slider_drilling.gap.findings import Findings
from slider_drilling.gap.fit import Fit
from slider_drilling.gap.model import Array, Probed, Run
from slider_drilling.gap.noise import cycle_period
from slider_drilling.gap.residuals import Problem

PHASES = ("rotating clockwise", "rotating counter-clockwise", "reversal", "still")
TIME_WINDOWS = 20
# How far a probe (a friction multiplier between two depths) may plausibly be off: one standard deviation.
_PROBE_SPREAD = 0.5
_PROBE_STEP = 0.2


@dataclass(frozen=True)
class Where:
    """Shares of E_tuned^2; each mapping adds up to 1. time, depth: (from, to, share[, change]) rows."""

    channel: dict[str, float]
    phase: dict[str, float]
    band: dict[str, float]
    time: list[dict[str, float]]
    depth: list[dict[str, float]]


def locate(base: Base) -> Where:
    """Split the held-out gap of a fit."""
    problem = base.problem
    energy = problem.score * base.score.residual**2
    total = float(energy.sum())
    channel = {
        name: float(energy[problem.channel == index].sum() / total) for index, name in enumerate(problem.channel_names)
    }
    phase = dict.fromkeys(PHASES, 0.0)
    time_rows = []
    for index, run in enumerate(problem.model.runs):
        here = problem.run == index
        labels = motion_phase(run, problem.time[here])
        for code, name in enumerate(PHASES):
            phase[name] += float(energy[here][labels == code].sum() / total)
        edges = np.linspace(run.time[0], run.time[-1], TIME_WINDOWS + 1)
        which = np.clip(np.searchsorted(edges, problem.time[here], side="right") - 1, 0, TIME_WINDOWS - 1)
        for window in range(TIME_WINDOWS):
            row = {"from": float(edges[window]), "to": float(edges[window + 1])}
            row["share"] = float(energy[here][which == window].sum() / total)
            time_rows.append(row if len(problem.model.runs) == 1 else {"run": float(index)} | row)
    bands = _bands(problem, base.score.residual, total)
    return Where(channel, phase, bands, time_rows, locate_along(problem, base.fit))


def motion_phase(run: Run, times: Array) -> Array:
    """(n,) index into PHASES of the excitation at the times.

    Still: slower than 2 % of the fastest; reversal: within a twentieth of a cycle (at most 1 s) of a change of
    direction.
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


def _bands(problem: Problem, residual: Array, total: float) -> dict[str, float]:
    """Shares by frequency, from each channel's periodogram (Parseval: they add up to 1)."""
    shares: dict[str, float] = {}
    for (run_index, _), part in problem.slices.items():
        run, values, times = problem.model.runs[run_index], residual[part], problem.time[part]
        interval = (times[-1] - times[0]) / max(times.size - 1, 1)
        power = np.abs(np.fft.rfft(values)) ** 2
        # Every bin but the first (and the last of an even length) stands for two.
        power[1 : (values.size + 1) // 2] *= 2.0
        power *= float(problem.score[part] @ values**2) / power.sum() / total
        frequency = np.fft.rfftfreq(values.size, interval)
        for name, low, high in band_edges(run):
            inside = (frequency >= low) & (frequency < high)
            shares[name] = shares.get(name, 0.0) + float(power[inside].sum())
    return shares


def band_edges(run: Run) -> list[tuple[str, float, float]]:
    """Adjoining bands (name, from, to) Hz that cover everything, lowest first."""
    period = cycle_period(run.time, run.excitation)
    edges: list[tuple[str, float, float]] = []
    at = 0.0
    if period is not None:
        edges += [
            ("below the rocking frequency", 0.0, 0.5 / period),
            ("rocking and its harmonics", 0.5 / period, 3.5 / period),
        ]
        at = 3.5 / period
    for name, low, high in run.bands:
        if high <= at:
            continue
        if low > at:
            edges.append((f"between, up to {name}", at, low))
        edges.append((name, max(low, at), high))
        at = high
    return [*edges, ("above", at, np.inf)]


def locate_along(problem: Problem, fit: Fit) -> list[dict[str, float]]:
    """Which stretch must carry more or less to explain the residual: a ridge solution over the model's probes.

    share: of what all probes explain together, by each one's part; change: the multiplier's departure from 1.
    Empty when the model has no probes.
    """
    model = problem.model
    if not isinstance(model, Probed) or not model.probes:
        return []
    probes = model.probes
    sets = [fit.values, *(fit.values | {p.name: p.nominal + _PROBE_STEP} for p, _, _ in probes)]
    simulated = problem.simulate(sets)
    columns = ((simulated[0] - simulated[1:]) / _PROBE_STEP).T
    weight = problem.reweighted(fit.residual)
    rows = weight[:, None] * np.column_stack([fit.jacobian, columns])
    target = -weight * fit.residual
    nuisance = fit.jacobian.shape[1]
    # The residual is structured, so its own size, not the noise's, is what the ridge weighs the spread against.
    ridge = np.r_[np.full(nuisance, 1e-6), np.full(len(probes), 1.0 / _PROBE_SPREAD)]
    ridge = np.diag(ridge * np.sqrt(np.mean(target**2)))
    solution = np.linalg.lstsq(np.vstack([rows, ridge]), np.r_[target, np.zeros(ridge.shape[0])], rcond=None)[0]
    change = solution[nuisance:]
    basis, _ = np.linalg.qr(rows[:, :nuisance])
    beyond = rows[:, nuisance:] - basis @ (basis.T @ rows[:, nuisance:])
    part = np.abs(change) * np.linalg.norm(beyond, axis=0)
    part = part / part.sum() if part.sum() > 0.0 else part
    return [
        {"from": low, "to": high, "share": float(share), "change": float(amount)}
        for (_, low, high), share, amount in zip(probes, part, change, strict=True)
    ]


def likely_site(findings: Findings) -> tuple[str | None, dict[str, float]]:
    """The site of what was accepted, else of the effects that explain most; and the best share per site.

    Shares are of E_tuned^2 - 1, by the full fits where there are some and by the score test elsewhere.
    """
    tuned = findings.tuned
    if tuned is None or not findings.screened:
        return None, {}
    gap = max(tuned.fit.cost - 1.0, 1e-9)
    best: dict[str, float] = {}
    for candidate in findings.screened[0]:
        share = candidate.promise / gap
        best[candidate.effect.site] = max(best.get(candidate.effect.site, -np.inf), share)
    for contender in findings.rounds[0] if findings.rounds else []:
        best[contender.effect.site] = max(best.get(contender.effect.site, -np.inf), contender.closed)
    ordered = dict(sorted(best.items(), key=lambda item: -item[1]))
    if findings.accepted:
        return findings.accepted[0].effect.site, ordered
    return next(iter(ordered), None), ordered
