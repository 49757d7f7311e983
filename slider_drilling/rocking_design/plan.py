"""The rocking plan: for each bit depth the largest rocking that leaves the toolface alone and spares the connections.

The closed form of the rocked zone (`TorqueAndDrag`) gives the range of amplitudes; a search over steady rocking of the
plant finds the largest one within the limits. Everything in the plan but the weight without rocking and the offset is
read from that steady rocking.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
from slider_drilling.control.rocking import Rocking
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.rocking_design.closed_forms import (
    BitLoad,
    bit_load_of_pressure,
    bit_load_of_rate,
    friction_around,
    weight_without_rocking,
)
from slider_drilling.rocking_design.steady_rocking import SteadyRocking, steady_rocking
from slider_drilling.schema.option_types import check_option_types
from slider_drilling.wellbore.broomstick import with_bit_at
from slider_drilling.wellbore.mesh import build_mesh
from slider_drilling.wellbore.static_loads import static_loads

PERIOD_PER_TRAVEL = 16.0
"""Rocking period over the travel time of torsion from top to bit: faster strokes excite the string's own vibration."""
MIN_PERIOD = 10.0  # s
MAKE_UP_SHARE = 0.8
"""Of the make-up torque: largest torque to the right. Beyond, connections may be made up further downhole."""
BACK_OFF_SHARE = 0.6
"""Back-off torque over make-up torque, where it is not given."""
_SPEED_SHARE, _ACCELERATION_SHARE = 0.9, 0.9  # of the top drive's limits; the rest is for tracking
_MIN_ROUNDING = 0.25  # s, half the width of a rounded peak
# Search for the amplitude: from this multiple of the closed form's down in such steps, then by bisection.
_START, _DESCENT, _BISECTIONS = 1.05, 0.85, 3
_FINAL_ELEMENTS = 2  # of the row's numbers, over those of the search
_TORQUE_MARGIN = 1.1  # of a torque limit, by which the closed form's torque may be too large
_SMALLEST = 0.01  # of the amplitude that frees the whole string: less is no rocking
_MIN_DEPTH = 100.0  # m


@dataclass(frozen=True)
class PlanOptions:
    """What a plan is made for.

    Attributes:
        rate_of_penetration: m/s; gives the bit's load unless a differential pressure does.
        differential_pressure: Pa.
        tool_face_swing: Largest swing of the toolface to either side, rad.
        make_up_torque: Of the weakest connection, N m; None for the rig file's.
        back_off_torque: That loosens a connection, N m; None for `BACK_OFF_SHARE` of the make-up torque.
        period: s; None for `PERIOD_PER_TRAVEL`.
        elements: Of the string, during the search.
    """

    rate_of_penetration: float = 0.0025
    differential_pressure: float | None = None
    tool_face_swing: float = math.radians(5.0)
    make_up_torque: float | None = None
    back_off_torque: float | None = None
    period: float | None = None
    elements: int = 70

    def __post_init__(self) -> None:
        check_option_types(self, "rocking_plan")


@dataclass(frozen=True)
class Limits:
    """Torques (N m) that a plan respects: of the weakest connection in the hole, its back-off, and the top drive's."""

    make_up: float | None
    back_off: float | None
    top_drive: float

    @property
    def right(self) -> float:
        """Largest torque to the right."""
        return self.top_drive if self.make_up is None else min(MAKE_UP_SHARE * self.make_up, self.top_drive)

    @property
    def left(self) -> float:
        """Largest torque to the left."""
        return self.top_drive if self.back_off is None else min(MAKE_UP_SHARE * self.back_off, self.top_drive)


@dataclass(frozen=True)
class PlanRow:
    """How to rock with the bit at one depth.

    Attributes:
        depth: Measured depth of the bit, m.
        amplitude: Turning points to either side of the centre, rad.
        offset: Of the centre from neutral, to hold the toolface against the reactive torque, rad.
        drive: The trajectory of the top drive about its centre.
        load: Of the bit.
        steady: What the rocking settles to.
        rotating_weight: Hook load off bottom, of the string alone, N.
        weight_without_rocking: Weight on bit at the same hook load with the top drive held, N.
        limits: Of torque.
        limited_by: What keeps the amplitude from being larger.
        closed_form_reach: Depth that rocking frees, from the friction torque of a string that does not slide, m.
    """

    depth: float
    amplitude: float
    offset: float
    drive: Rocking
    load: BitLoad
    steady: SteadyRocking
    rotating_weight: float
    weight_without_rocking: float
    limits: Limits
    limited_by: str
    closed_form_reach: float

    @property
    def right(self) -> float:
        """Turning point to the right of neutral, rad."""
        return self.offset + self.amplitude

    @property
    def left(self) -> float:
        """Turning point to the left of neutral, rad; negative if rocking stays to the right of neutral."""
        return self.amplitude - self.offset

    @property
    def weight_let_down(self) -> float:
        """Hook load off bottom less that of the slide, N."""
        return self.rotating_weight - self.steady.hook_load

    @property
    def make_up_share(self) -> float | None:
        """Torque to the right over the make-up torque; None if it is not known."""
        return None if self.limits.make_up is None else max(self.steady.torque_right, 0.0) / self.limits.make_up

    @property
    def back_off_share(self) -> float | None:
        """Torque to the left over the back-off torque; None if it is not known."""
        return None if self.limits.back_off is None else max(-self.steady.torque_left, 0.0) / self.limits.back_off


@dataclass(frozen=True)
class Plan:
    """A rocking plan: the rig, what it was made for, and a row for each depth."""

    rig: Rig
    options: PlanOptions
    rows: tuple[PlanRow, ...]


def make_plan(
    rig: Rig, depths: Sequence[float], options: PlanOptions, progress: Callable[[float], None] | None = None
) -> Plan:
    """Plan the rocking.

    Args:
        rig: The rig.
        depths: Of the bit, m.
        options: What the plan is made for.
        progress: Called with the share of depths that are done.

    Raises:
        InputError: A depth is outside the string, or a number of the options cannot be used.
    """
    _check(rig, depths, options)
    rows = []
    for place, depth in enumerate(depths):
        rows.append(plan_depth(rig, depth, options))
        if progress is not None:
            progress((place + 1) / len(depths))
    return Plan(rig, options, tuple(rows))


def plan_depth(rig: Rig, depth: float, options: PlanOptions) -> PlanRow:
    """The plan with the bit at one depth, m."""
    here = with_bit_at(rig, depth)
    load = bit_load(rig, options)
    limits = torque_limits(here, options)
    model = TorqueAndDrag(here, friction_around(here), load.weight_on_bit)
    amplitude, limited_by = _largest(here, model, load, limits, options)
    drive = drive_for(here, amplitude, model.travel_time, options.period)
    steady = steady_rocking(here, drive, load, _FINAL_ELEMENTS * options.elements, thorough=True)
    mesh = build_mesh(here, 200)
    return PlanRow(
        depth=depth,
        amplitude=amplitude,
        offset=model.compliance * load.torque,
        drive=drive,
        load=load,
        steady=steady,
        rotating_weight=static_loads(here, rotation_speed=1.0, mesh=mesh).hook_load,
        weight_without_rocking=weight_without_rocking(here, steady.hook_load, mesh),
        limits=limits,
        limited_by=limited_by,
        closed_form_reach=model.reach(amplitude, 1.0),
    )


def bit_load(rig: Rig, options: PlanOptions) -> BitLoad:
    """The load of the bit that the options ask for."""
    if options.differential_pressure is not None:
        return bit_load_of_pressure(rig, options.differential_pressure)
    return bit_load_of_rate(rig, options.rate_of_penetration)


def torque_limits(rig: Rig, options: PlanOptions) -> Limits:
    """Limits of torque: of the options, else of the weakest connection of the rig's string."""
    make_up = rig.string.weakest_make_up_torque if options.make_up_torque is None else options.make_up_torque
    back_off = options.back_off_torque
    if back_off is None and make_up is not None:
        back_off = BACK_OFF_SHARE * make_up
    return Limits(make_up, back_off, rig.top_drive.max_torque)


def drive_for(rig: Rig, amplitude: float, travel_time: float, period: float | None = None) -> Rocking:
    """The trajectory that turns at this amplitude (rad): slow enough for the string, and for the top drive.

    Raises:
        InputError: The top drive cannot make the amplitude in the given period.
    """
    speed, acceleration = _SPEED_SHARE * rig.top_drive.max_speed, _ACCELERATION_SHARE * rig.top_drive.max_acceleration
    # Rounded peaks turn inside the triangle's; twice is close enough for a first guess of its speed.
    shortest = 4.0 * amplitude / speed + 2.0 * speed / acceleration
    chosen = max(PERIOD_PER_TRAVEL * travel_time, MIN_PERIOD, shortest) if period is None else period
    if chosen < shortest:
        raise InputError(f"period = {chosen:g} s: the top drive needs {shortest:.3g} s for {amplitude:.3g} rad; "
                         "give a longer one")  # fmt: skip
    rounding = _MIN_ROUNDING
    for _ in range(3):
        peak = amplitude / (1.0 - 2.0 * rounding / chosen)
        rounding = max(_MIN_ROUNDING, 4.0 * peak / chosen / acceleration)
    return Rocking(amplitude / (1.0 - 2.0 * rounding / chosen), chosen, rounding)


def _largest(
    rig: Rig, model: TorqueAndDrag, load: BitLoad, limits: Limits, options: PlanOptions
) -> tuple[float, str]:
    """The largest amplitude (rad) within the limits, and the limit that is met.

    From above, since a string that is freed only in part can swing its bit too, when it sticks and slips along the
    hole.

    Raises:
        InputError: No amplitude is within the limits.
    """

    def run(amplitude: float) -> str | None:
        drive = drive_for(rig, amplitude, model.travel_time, options.period)
        return _exceeded(steady_rocking(rig, drive, load, options.elements), limits, options)

    smallest = _SMALLEST * model.full_amplitude(1.0)
    outer, inner, limited_by = math.inf, _first_amplitude(model, load, limits), "range of amplitudes"
    while (exceeded := run(inner)) is not None:
        outer, inner, limited_by = inner, _DESCENT * inner, exceeded
        if inner < smallest:
            raise InputError(f"bit depth = {model.bit_depth:g} m: even the smallest rocking exceeds the limit of the "
                             f"{exceeded}; ask for less load on the bit, or raise the limit")  # fmt: skip
    for _ in range(_BISECTIONS if math.isfinite(outer) else 0):
        middle = 0.5 * (inner + outer)
        exceeded = run(middle)
        if exceeded is None:
            inner = middle
        else:
            outer, limited_by = middle, exceeded
    return inner, limited_by


def _first_amplitude(model: TorqueAndDrag, load: BitLoad, limits: Limits) -> float:
    """An amplitude (rad) that is too large, from the closed form: it turns the bit, or exceeds a torque."""
    whole = model.full_amplitude(1.0)
    allowed = _TORQUE_MARGIN * max(min(limits.right - load.torque, limits.left + load.torque), 0.0)
    shares = [share for share in np.linspace(_SMALLEST, 1.0, 91)
              if model.breakover_torque(share * whole, 1.0) < allowed]  # fmt: skip
    return float(_START * max(shares, default=_SMALLEST) * whole)


def _exceeded(steady: SteadyRocking, limits: Limits, options: PlanOptions) -> str | None:
    """The limit that this rocking exceeds, or None."""
    if steady.bit_swing > 2.0 * options.tool_face_swing:
        return "toolface"
    if steady.torque_right > limits.right:
        return "top drive torque" if limits.right == limits.top_drive else "make-up torque"
    if -steady.torque_left > limits.left:
        return "top drive torque" if limits.left == limits.top_drive else "back-off torque"
    return None


def _check(rig: Rig, depths: Sequence[float], options: PlanOptions) -> None:
    if not depths:
        raise InputError("depths: none given; give at least one")
    for depth in depths:
        if not _MIN_DEPTH <= depth <= rig.string.length + 1e-6:
            raise InputError(
                f"depth = {depth:g} m: must be at least {_MIN_DEPTH:g} m and at most the string's "
                f"{rig.string.length:g} m"
            )
    positive = {"tool_face_swing": options.tool_face_swing, "make_up_torque": options.make_up_torque,
                "back_off_torque": options.back_off_torque, "period": options.period}  # fmt: skip
    for name, value in positive.items():
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value}: must be a finite number above 0")
    bit_load(rig, options)
