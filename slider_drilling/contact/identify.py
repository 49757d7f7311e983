"""The contact's parameters from measured friction: paper section 4.

A particle swarm looks over the whole range, a local least-squares fit ends it and gives intervals. What can be
found at all is less than the paper's table suggests: eq. 6 reads

    tan^2 theta_eff = (2 h / (chi b))^2 sin^2 beta_v + (2 h / (chi a))^2 cos^2 beta_v,

so a, b, h and chi enter only as the two slopes h/(chi a) and h/(chi b). The search runs over those (and kt); a and
b are then given for a height h and a shape factor chi that are held. Motion along the asperity's axis alone shows
h/(chi a) only, and no friction in plain sliding tells f from the slopes.
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
from slider_drilling.contact.measured_friction import AgainstTime, AgainstVelocity
from slider_drilling.errors import InputError
from slider_drilling.rig import Contact

RANGES = {
    "stiffness": (1e3, 1e7),
    "axial_slope": (0.02, 0.6),
    "tangential_slope": (0.02, 0.6),
    "shear_factor": (1e-3, 0.5),
    "dahl_exponent": (0.3, 3.0),
}
"""What the search looks over, on a logarithmic scale: kt in N/m; the slopes h/(chi a), h/(chi b), f and i are pure
numbers."""
UNDETERMINED = 1.0
"""Standard error of a parameter's logarithm above which the data says nothing of it."""
NUDGE = 1e-3
"""Relative change of a parameter whose effect is weighed against the noise."""

Series = NDArray[np.float64]
Data = AgainstTime | AgainstVelocity


@dataclass(frozen=True)
class ParameterEstimate:
    """A parameter and its 95 % interval; determined is False where the data says nothing of it (interval None)."""

    value: float
    interval: tuple[float, float] | None
    determined: bool


@dataclass(frozen=True)
class Identification:
    """What was found. predicted and measured are (m,) N; residual_rms: N; largest_error is of the largest measured
    friction; degeneracies are sentences on what the data cannot tell apart."""

    contact: Contact
    estimates: dict[str, ParameterEstimate]
    measured: Series
    predicted: Series
    residual_rms: float
    largest_error: float
    degeneracies: tuple[str, ...]
    evaluations: int


def predict(data: Data, contact: Contact) -> Series:
    """Friction (m,) in N that a contact would have shown: axial, then tangential where that was measured."""
    table = friction_table(contact.shear_factor, contact.asperity)
    axis = math.cos(contact.asperity.orientation), math.sin(contact.asperity.orientation)
    compliance = data.normal_force / contact.stiffness
    if isinstance(data, AgainstVelocity):
        return contact.stiffness * settled_deformation(
            data.feed, data.vibration, data.frequency, data.direction, compliance, table, contact.dahl_exponent, *axis
        )
    m_x, m_y, _, _ = integrate_deformation(
        data.axial, data.tangential, compliance, table, contact.dahl_exponent, *axis, 0.0, 0.0, False
    )
    return contact.stiffness * (np.concatenate([m_x, m_y]) if data.tangential_friction.size else m_x)


def identify(
    data: Data,
    *,
    free: Sequence[str] = (),
    base: Contact = PAPER,
    particles: int = 24,
    generations: int = 40,
    seed: int = 0,
    workers: int = 2,
    progress: Callable[[int, float], None] | None = None,
) -> Identification:
    """Fit kt and the two slopes, and any of shear_factor and dahl_exponent named in free.

    base: holds what is not fitted: h, chi, orientation, f and i. progress(generation, best misfit in N) is called
    after every generation. Raises InputError for a parameter that cannot be freed, or too little data.
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


def _names(data: Data, free: Sequence[str]) -> list[str]:
    unknown = [name for name in free if name not in ("shear_factor", "dahl_exponent", "shape_factor")]
    if unknown:
        raise InputError(f"identify: --free {unknown[0]}: only shear_factor, shape_factor and dahl_exponent can be")
    across = np.any(data.tangential) if isinstance(data, AgainstTime) else np.any(np.sin(data.direction))
    names = ["stiffness", "axial_slope", *(["tangential_slope"] if across else [])]
    return [*names, *(name for name in free if name != "shape_factor")]


def _measured(data: Data) -> Series:
    if isinstance(data, AgainstTime) and data.tangential_friction.size:
        return np.concatenate([data.friction, data.tangential_friction])
    return data.friction


def _contact(base: Contact, values: dict[str, float]) -> Contact | None:
    """The contact of a point of the search; None where there is no steady friction."""
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
    """The best point that a particle swarm finds, and how often it looked."""
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
    """Standard errors and correlations of the fit; neighbouring samples that err alike count as fewer samples."""
    count, parameters = jacobian.shape
    alike = float(np.clip(np.corrcoef(residual[:-1], residual[1:])[0, 1], 0.0, 0.99)) if count > 10 else 0.0
    variance = float(residual @ residual) / max(count - parameters, 1) * (1.0 + alike) / (1.0 - alike)
    _, singular, v = np.linalg.svd(jacobian, full_matrices=False)
    inverse = 1.0 / np.maximum(singular, 1e-9 * singular[0])
    covariance = (v.T * inverse**2) @ v * max(variance, 1e-30)
    errors = np.sqrt(np.diag(covariance))
    return errors, covariance / np.outer(errors, errors)


def _estimates(
    names: list[str], point: Series, errors: Series, freedom: int, contact: Contact
) -> dict[str, ParameterEstimate]:
    reach = float(stats.t.ppf(0.975, freedom))
    found: dict[str, ParameterEstimate] = {}
    for name, x, error in zip(names, point, errors, strict=True):
        known = error < UNDETERMINED
        wide = (math.exp(x - reach * error), math.exp(x + reach * error)) if known else None
        found[name] = ParameterEstimate(math.exp(x), wide, bool(known))
    ratio = contact.asperity.height / contact.asperity.shape_factor
    for axis, slope in (("minor_axis", "axial_slope"), ("major_axis", "tangential_slope")):
        bounds = found[slope].interval if slope in found else None
        if bounds is not None:
            found[axis] = ParameterEstimate(ratio / found[slope].value, (ratio / bounds[1], ratio / bounds[0]), True)
        else:
            found[axis] = ParameterEstimate(getattr(contact.asperity, axis), None, False)
    return found


def _degeneracies(
    names: list[str], free: Sequence[str], estimates: dict[str, ParameterEstimate], correlation: Series, base: Contact
) -> tuple[str, ...]:
    said = [
        "a, b, h and chi enter only as the slopes h/(chi a) and h/(chi b): no friction tells them apart further. "
        f"a and b are given for h = {base.asperity.height * 1e6:g} um and chi = {base.asperity.shape_factor:g}, held."
    ]
    if "shape_factor" in free:
        said.append("shape_factor was asked for: it cannot be found beside a and b, see above; it stays held.")
    if "tangential_slope" not in names:
        said.append(
            "All motion is along the axis: this data says nothing of h/(chi b), so nothing of b; it is kept in its "
            "ratio to a. Add motion across the axis (tangential_m, or direction_deg)."
        )
    if "shear_factor" not in names:
        said.append(
            f"f is held at {base.shear_factor:g}: in plain sliding a larger f and smaller slopes give the same "
            "friction, so the slopes are those for this f."
        )
    said += [f"{name} is not determined by this data." for name in names if not estimates[name].determined]
    for j, one in enumerate(names):
        for k in range(j):
            if abs(correlation[j, k]) > 0.95:
                said.append(f"{names[k]} and {one} are hardly told apart (correlation {correlation[j, k]:+.3f}).")
    return tuple(said)


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
    """Mean axial deformation (m) in the settled cycle of each experiment: feed plus a harmonic vibration.

    Arrays (n,) as in `AgainstVelocity`, compliance F_N/kt in m. A cycle has 60 steps; it has settled when its mean
    changes by less than 1e-5 of z_ss.
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
