"""Identification of a contact's parameters from measured friction (paper section 4).

A particle swarm searches the whole range; a local least-squares fit refines its result and gives intervals. Less can
be identified than the paper's table suggests, since eq. 6 reads

    tan^2 theta_eff = (2 h / (chi b))^2 sin^2 beta_v + (2 h / (chi a))^2 cos^2 beta_v:

a, b, h and chi enter only as the two slopes h/(chi a) and h/(chi b). The search therefore fits these slopes and kt; a
and b follow for a height h and a shape factor chi that are held. Motion along the asperity's axis alone shows only
h/(chi a), and friction in plain sliding cannot separate f from the slopes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, stats

from slider_drilling.contact.asperity import PAPER, friction_table
from slider_drilling.contact.dahl import advance_on_table, compiled
from slider_drilling.contact.friction_history import integrate_deformation
from slider_drilling.contact.measured_friction import FrictionOverTime, FrictionOverVelocity
from slider_drilling.errors import InputError
from slider_drilling.rig import Contact

RANGES = {
    "stiffness": (1e3, 1e7),
    "axial_slope": (0.02, 0.6),
    "tangential_slope": (0.02, 0.6),
    "shear_factor": (1e-3, 0.5),
    "dahl_exponent": (0.3, 3.0),
}
"""Search range of each parameter, on a logarithmic scale: kt in N/m; the slopes h/(chi a) and h/(chi b), f and i are
pure numbers."""
UNDETERMINED = 1.0
"""Standard error of a parameter's logarithm above which the data does not determine it."""
NUDGE = 1e-3
"""Relative step of the difference quotients."""

Series = NDArray[np.float64]
FrictionData = FrictionOverTime | FrictionOverVelocity


@dataclass(frozen=True)
class ParameterEstimate:
    """A parameter and its 95 % interval; where the data does not determine it the interval is None."""

    value: float
    interval: tuple[float, float] | None
    determined: bool


@dataclass(frozen=True)
class Identification:
    """Result of `identify`.

    Attributes:
        contact: The fitted contact.
        estimates: By parameter name.
        measured, predicted: Friction, N, (m,).
        residual_rms: N.
        largest_error: Over the largest measured friction.
        degeneracies: Sentences on what the data cannot separate.
        evaluations: Number of predictions that the search made.
    """

    contact: Contact
    estimates: dict[str, ParameterEstimate]
    measured: Series
    predicted: Series
    residual_rms: float
    largest_error: float
    degeneracies: tuple[str, ...]
    evaluations: int


def predict(data: FrictionData, contact: Contact) -> Series:
    """Friction (m,) N that a contact would show: axial, then tangential where that was measured."""
    table = friction_table(contact.shear_factor, contact.asperity)
    axis = math.cos(contact.asperity.orientation), math.sin(contact.asperity.orientation)
    compliance = data.normal_force / contact.stiffness
    if isinstance(data, FrictionOverVelocity):
        return contact.stiffness * settled_deformation(
            data.feed, data.vibration, data.frequency, data.direction, compliance, table, contact.dahl_exponent, *axis
        )
    m_x, m_y, _, _ = integrate_deformation(
        data.axial, data.tangential, compliance, table, contact.dahl_exponent, *axis, 0.0, 0.0, False
    )
    return contact.stiffness * (np.concatenate([m_x, m_y]) if data.tangential_friction.size else m_x)


def identify(
    data: FrictionData,
    *,
    free: Sequence[str] = (),
    base: Contact = PAPER,
    particles: int = 24,
    generations: int = 40,
    seed: int = 0,
    workers: int = 2,
    progress: Callable[[int, float], None] | None = None,
) -> Identification:
    """Fit kt, the two slopes, and what is named in ``free``.

    Args:
        data: Measured friction.
        free: Further parameters to fit: any of shear_factor and dahl_exponent.
        base: Holds what is not fitted: h, chi, orientation, f and i.
        particles, generations, seed: Of the swarm.
        workers: Threads.
        progress: Called with the generation and the best misfit (N) after every generation.

    Raises:
        InputError: For a parameter that cannot be freed, and for too little data.
    """
    names = _names(data, free)
    measured = _measured(data)
    if measured.size <= len(names) + 1:
        raise InputError(f"identify: {measured.size} rows are too few for {len(names)} parameters")
    low, high = (np.log([RANGES[name][k] for name in names]) for k in (0, 1))

    def residual(point: Series) -> Series:
        contact = _contact(base, dict(zip(names, np.exp(point), strict=True)))
        if contact is None:
            return np.full(measured.size, 10.0 * np.abs(measured).max())
        return predict(data, contact) - measured

    best, evaluations = _swarm(residual, low, high, particles, generations, seed, workers, progress)
    fit = optimize.least_squares(residual, best, bounds=(low, high), x_scale=0.1, diff_step=NUDGE)
    contact = _contact(base, dict(zip(names, np.exp(fit.x), strict=True)))
    if contact is None:
        raise InputError(
            f"identify: with shear_factor = {base.shear_factor:g} and shape_factor = {base.asperity.shape_factor:g} no "
            "asperity wears steadily; hold other values"
        )
    errors, correlation = _uncertainty(fit.jac, fit.fun)
    estimates = _estimates(names, fit.x, errors, measured.size - len(names), contact)
    predicted = measured + fit.fun
    return Identification(
        contact=contact,
        estimates=estimates,
        measured=measured,
        predicted=predicted,
        residual_rms=float(np.sqrt(np.mean(fit.fun**2))),
        largest_error=float(np.abs(fit.fun).max() / np.abs(measured).max()),
        degeneracies=_degeneracies(names, free, estimates, correlation, base),
        evaluations=evaluations + int(fit.nfev),
    )


def _names(data: FrictionData, free: Sequence[str]) -> list[str]:
    unknown = [name for name in free if name not in ("shear_factor", "dahl_exponent", "shape_factor")]
    if unknown:
        raise InputError(
            f"identify: --free {unknown[0]}: only shear_factor, shape_factor and dahl_exponent can be fitted"
        )
    across = np.any(data.tangential) if isinstance(data, FrictionOverTime) else np.any(np.sin(data.direction))
    names = ["stiffness", "axial_slope", *(["tangential_slope"] if across else [])]
    return [*names, *(name for name in free if name != "shape_factor")]


def _measured(data: FrictionData) -> Series:
    if isinstance(data, FrictionOverTime) and data.tangential_friction.size:
        return np.concatenate([data.friction, data.tangential_friction])
    return data.friction


def _contact(base: Contact, values: dict[str, float]) -> Contact | None:
    """The contact with these parameter values; None where friction has no steady solution."""
    asperity = base.asperity
    ratio = asperity.height / asperity.shape_factor
    minor = ratio / values["axial_slope"]
    slope = values.get("tangential_slope", values["axial_slope"] * asperity.minor_axis / asperity.major_axis)
    contact = replace(
        base,
        stiffness=values["stiffness"],
        shear_factor=values.get("shear_factor", base.shear_factor),
        dahl_exponent=values.get("dahl_exponent", base.dahl_exponent),
        asperity=replace(asperity, minor_axis=minor, major_axis=ratio / slope),
    )
    try:
        friction_table(contact.shear_factor, contact.asperity, 9)
    except InputError:
        return None
    return contact


def _swarm(
    residual: Callable[[Series], Series],
    low: Series,
    high: Series,
    particles: int,
    generations: int,
    seed: int,
    workers: int,
    progress: Callable[[int, float], None] | None,
) -> tuple[Series, int]:
    """The best point of a particle swarm, and the number of its evaluations."""
    from pymoo.algorithms.soo.nonconvex.pso import PSO
    from pymoo.core.callback import Callback
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    with ThreadPoolExecutor(workers) as pool:

        class Misfit(Problem):
            def __init__(self) -> None:
                super().__init__(n_var=low.size, n_obj=1, xl=low, xu=high)

            def _evaluate(self, x: Series, out: dict, *_: object, **__: object) -> None:
                out["F"] = np.array([np.sqrt(np.mean(r**2)) for r in pool.map(residual, x)])[:, None]

        class Report(Callback):
            def notify(self, algorithm: PSO) -> None:
                if progress is not None:
                    progress(algorithm.n_gen, float(algorithm.opt[0].F[0]))

        result = minimize(
            Misfit(), PSO(pop_size=particles), ("n_gen", generations), seed=seed, callback=Report(), verbose=False
        )
    return np.clip(np.asarray(result.X, dtype=float), low, high), int(result.algorithm.evaluator.n_eval)


def _uncertainty(jacobian: Series, residual: Series) -> tuple[Series, Series]:
    """Standard errors and correlations of the fit.

    Correlation between residuals of neighbouring samples reduces the effective number of samples.
    """
    count, parameters = jacobian.shape
    lag_one = float(np.clip(np.corrcoef(residual[:-1], residual[1:])[0, 1], 0.0, 0.99)) if count > 10 else 0.0
    variance = float(residual @ residual) / max(count - parameters, 1) * (1.0 + lag_one) / (1.0 - lag_one)
    _, singular, v = np.linalg.svd(jacobian, full_matrices=False)
    inverse = 1.0 / np.maximum(singular, 1e-9 * singular[0])
    covariance = (v.T * inverse**2) @ v * max(variance, 1e-30)
    errors = np.sqrt(np.diag(covariance))
    return errors, covariance / np.outer(errors, errors)


def _estimates(
    names: list[str], point: Series, errors: Series, freedom: int, contact: Contact
) -> dict[str, ParameterEstimate]:
    quantile = float(stats.t.ppf(0.975, freedom))
    estimates: dict[str, ParameterEstimate] = {}
    for name, x, error in zip(names, point, errors, strict=True):
        known = error < UNDETERMINED
        interval = (math.exp(x - quantile * error), math.exp(x + quantile * error)) if known else None
        estimates[name] = ParameterEstimate(math.exp(x), interval, bool(known))
    ratio = contact.asperity.height / contact.asperity.shape_factor
    for axis, slope in (("minor_axis", "axial_slope"), ("major_axis", "tangential_slope")):
        bounds = estimates[slope].interval if slope in estimates else None
        if bounds is not None:
            estimates[axis] = ParameterEstimate(
                ratio / estimates[slope].value, (ratio / bounds[1], ratio / bounds[0]), True
            )
        else:
            estimates[axis] = ParameterEstimate(getattr(contact.asperity, axis), None, False)
    return estimates


def _degeneracies(
    names: list[str], free: Sequence[str], estimates: dict[str, ParameterEstimate], correlation: Series, base: Contact
) -> tuple[str, ...]:
    sentences = [
        "a, b, h and chi enter only as the slopes h/(chi a) and h/(chi b); friction cannot separate them further. "
        f"a and b are given for h = {base.asperity.height * 1e6:g} um and chi = {base.asperity.shape_factor:g}, held."
    ]
    if "shape_factor" in free:
        sentences.append("shape_factor cannot be fitted beside a and b, see above; it stays held.")
    if "tangential_slope" not in names:
        sentences.append(
            "All motion is along the axis, so this data does not determine h/(chi b) or b; b keeps its ratio to a. "
            "Add motion across the axis (tangential_m, or direction_deg)."
        )
    if "shear_factor" not in names:
        sentences.append(
            f"f is held at {base.shear_factor:g}: in plain sliding a larger f and smaller slopes give the same "
            "friction, so the slopes are those for this f."
        )
    sentences += [f"{name} is not determined by this data." for name in names if not estimates[name].determined]
    for j, name in enumerate(names):
        for k in range(j):
            if abs(correlation[j, k]) > 0.95:
                sentences.append(
                    f"{names[k]} and {name} are hardly separable (correlation {correlation[j, k]:+.3f})."
                )
    return tuple(sentences)


@compiled
def settled_deformation(
    feed: Series,
    vibration: Series,
    frequency: Series,
    direction: Series,
    compliance: Series,
    table: Series,
    exponent: float,
    axis_x: float,
    axis_y: float,
) -> Series:
    """Mean axial deformation (m) in the settled cycle of each experiment: a feed plus a harmonic vibration.

    A cycle has 60 steps. It has settled when its mean changes by less than 1e-5 of z_ss.

    Args:
        feed, vibration, frequency, direction: As in `FrictionOverVelocity`, (n,).
        compliance: F_N / kt, m, (n,).
        table, exponent, axis_x, axis_y: As in `dahl.advance_on_table`.

    Returns:
        (n,).
    """
    out = np.empty(feed.size)
    sine = np.sin(2.0 * math.pi * np.arange(61) / 60.0)
    for row in range(feed.size):
        period = 1.0 / frequency[row]
        amplitude = vibration[row] * period / (2.0 * math.pi)
        along, across = math.cos(direction[row]), math.sin(direction[row])
        scale = compliance[row] * table[-1]
        x = scale * min(1.0, feed[row] / max(vibration[row], 1e-12))
        y, before = 0.0, math.inf
        for _ in range(20_000):
            total = 0.0
            for k in range(60):
                swing = amplitude * (sine[k + 1] - sine[k])
                dx, dy = feed[row] * period / 60.0 + swing * along, swing * across
                parts = int(math.sqrt(dx * dx + dy * dy) / (0.2 * scale)) + 1
                half = x
                for _ in range(parts):
                    x, y, _ = advance_on_table(
                        x, y, dx / parts, dy / parts, compliance[row], exponent, axis_x, axis_y, table
                    )
                total += 0.5 * (half + x)
            mean = total / 60.0
            if abs(mean - before) < 1e-5 * scale:
                break
            before = mean
        out[row] = mean
    return out
