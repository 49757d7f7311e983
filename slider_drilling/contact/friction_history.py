"""Friction history of one contact under any motion: all of paper section 3.3 (eq. 7-26).

The asperity's deformation follows the pipe by Dahl's law (`dahl.advance`), its direction sets the friction
coefficient through the asperity's attack angle (`asperity.friction_table`), and the force on the pipe is -kt M.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slider_drilling.contact.asperity import friction_table
from slider_drilling.contact.dahl import advance_on_table, compiled, friction_of_direction, two_step_on_table
from slider_drilling.errors import InputError
from slider_drilling.rig import Contact

MAX_STEP = 0.1
"""Longest move in one step, over z_ss. Longer ones are divided; each part is then exact to 2e-8 z_ss."""

Series = NDArray[np.float64]


@dataclass(frozen=True)
class FrictionMeans:
    """Time means over a part of a history, of force and torque on the pipe.

    Attributes:
        absolute_axial_force: F_x, mean magnitude, N (eq. 25).
        axial_force: Signed mean, N: what resists the feed.
        absolute_torque: M_y, mean magnitude, N m (eq. 26).
        torque: Signed mean, N m.
        friction_coefficient: Mean.
    """

    absolute_axial_force: float
    axial_force: float
    absolute_torque: float
    torque: float
    friction_coefficient: float


@dataclass(frozen=True)
class FrictionHistory:
    """One contact over time, every array (n,).

    Attributes:
        time: s.
        axial_force, torque: f_x (N) and m_y (N m) on the pipe, so both oppose its motion (eq. 23, 24 with the sign of a
            reaction).
        deformation_axial, deformation_tangential: m, of the asperity.
        friction_coefficient: -.
        beta_v: rad in [0, pi/2], angle between slip and the asperity's axis, whatever the sense of either.
    """

    time: Series
    axial_force: Series
    torque: Series
    deformation_axial: Series
    deformation_tangential: Series
    friction_coefficient: Series
    beta_v: Series

    def means(self, since: float = -math.inf, until: float = math.inf) -> FrictionMeans:
        """Means (trapezoidal in time) over the samples with since <= time <= until (s).

        Raises InputError where fewer than two samples lie there.
        """
        inside = (self.time >= since) & (self.time <= until)
        if np.count_nonzero(inside) < 2:
            raise InputError(f"contact: means from {since:g} s to {until:g} s: fewer than two samples lie there")
        time = self.time[inside]

        def mean(series: Series) -> float:
            return float(
                0.5 * np.sum((series[inside][1:] + series[inside][:-1]) * np.diff(time)) / (time[-1] - time[0])
            )

        return FrictionMeans(
            absolute_axial_force=mean(np.abs(self.axial_force)),
            axial_force=mean(self.axial_force),
            absolute_torque=mean(np.abs(self.torque)),
            torque=mean(self.torque),
            friction_coefficient=mean(self.friction_coefficient),
        )


def friction_history(
    time: ArrayLike,
    axial: ArrayLike,
    tangential: ArrayLike,
    normal_force: ArrayLike,
    contact: Contact,
    radius: float,
    *,
    stiffness_follows_load: bool = False,
    deformation: tuple[float, float] = (0.0, 0.0),
    paper_operator: bool = False,
) -> FrictionHistory:
    """Friction of one contact under a given motion, straight between samples.

    Args:
        time: s, (n,), increasing.
        axial, tangential: Displacement of the pipe's surface down the hole and around it (angle times radius), m, (n,).
        normal_force: N, one number or (n,), positive.
        contact: The contact.
        radius: Outer radius of the pipe, m.
        stiffness_follows_load: Take kt = (kt_ref / F_ref) F_N, as the drill string does; z_ss then depends on mu
            alone. By default kt is constant, as in the paper, and z_ss = mu F_N / kt follows the load.
        deformation: Of the asperity at the first sample, m.
        paper_operator: Step with the paper's operator as printed (eq. 11-21), for comparison: the same law at first
            order in the time step instead of second (see `dahl`).

    Raises:
        InputError: For arrays that do not match or are not finite, and for a contact outside the model.
    """
    t, x, y, load = _checked(time, axial, tangential, normal_force)
    if not (math.isfinite(radius) and radius > 0.0):
        raise InputError(f"contact: radius = {radius}: must be a positive finite number of m")
    table = friction_table(contact.shear_factor, contact.asperity)
    orientation = contact.asperity.orientation
    axis_x, axis_y = math.cos(orientation), math.sin(orientation)
    compliance = load / contact.stiffness
    if stiffness_follows_load:
        compliance = np.full_like(load, contact.reference_load / contact.stiffness)
    m_x, m_y, friction, cosine = integrate_deformation(
        x, y, compliance, table, contact.dahl_exponent, axis_x, axis_y, *deformation, paper_operator
    )
    stiffness = load / compliance
    return FrictionHistory(
        time=t,
        axial_force=-stiffness * m_x,
        torque=-stiffness * m_y * radius,
        deformation_axial=m_x,
        deformation_tangential=m_y,
        friction_coefficient=friction,
        beta_v=np.arccos(np.minimum(cosine, 1.0)),
    )


@compiled
def integrate_deformation(
    axial: Series,
    tangential: Series,
    compliance: Series,
    table: Series,
    exponent: float,
    axis_x: float,
    axis_y: float,
    start_x: float,
    start_y: float,
    paper_operator: bool,
) -> tuple[Series, Series, Series, Series]:
    """Deformation along both axes (m), friction coefficient and |cos beta_v| at every sample of a motion.

    Args:
        axial, tangential: m, (n,).
        compliance: F_N / kt, m, (n,).
        table, exponent, axis_x, axis_y: As in `dahl.advance_on_table`.
        start_x, start_y: Deformation at the first sample, m.
        paper_operator: See `friction_history`.
    """
    n = axial.size
    lowest = table.min()
    m_x, m_y, friction, cosine = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    x, y, mu, along = start_x, start_y, table[-1], 1.0
    for k in range(n):
        if k > 0:
            dx, dy = axial[k] - axial[k - 1], tangential[k] - tangential[k - 1]
            c0, c1 = compliance[k - 1], compliance[k]
            parts = int(math.sqrt(dx * dx + dy * dy) / (MAX_STEP * lowest * min(c0, c1))) + 1
            for part in range(parts):
                length = c0 + (c1 - c0) * (part + 0.5) / parts
                if paper_operator:
                    x, y, mu = two_step_on_table(
                        x, y, dx / parts, dy / parts, length, exponent, axis_x, axis_y, table, mu
                    )
                else:
                    x, y, mu = advance_on_table(x, y, dx / parts, dy / parts, length, exponent, axis_x, axis_y, table)
        distance = math.sqrt(x * x + y * y)
        if not paper_operator:
            mu = friction_of_direction(x, y, axis_x, axis_y, table, mu)
        if distance > 0.0:
            along = abs(x * axis_x + y * axis_y) / distance
        m_x[k], m_y[k], friction[k], cosine[k] = x, y, mu, along
    return m_x, m_y, friction, cosine


def _checked(*given: ArrayLike) -> tuple[Series, Series, Series, Series]:
    names = ("time", "axial", "tangential", "normal_force")
    time, axial, tangential, load = (np.asarray(value, dtype=float) for value in given)
    if time.ndim != 1 or time.size < 2 or not np.all(np.diff(time) > 0.0):
        raise InputError("contact: time: must be a row of at least two increasing times in s")
    if load.ndim == 0:
        load = np.full(time.size, float(load))
    series = (time, np.atleast_1d(axial), np.atleast_1d(tangential), load)
    for name, values in zip(names, series, strict=True):
        if values.shape != time.shape:
            raise InputError(f"contact: {name} has shape {values.shape}, time {time.shape}: must be equal")
        if not np.all(np.isfinite(values)):
            k = int(np.flatnonzero(~np.isfinite(values))[0])
            raise InputError(f"contact: {name}[{k}] = {values[k]}: must be finite")
    if not np.all(load > 0.0):
        k = int(np.flatnonzero(~(load > 0.0))[0])
        raise InputError(f"contact: normal_force[{k}] = {load[k]} N: must be positive (the pipe has lifted off)")
    return series
