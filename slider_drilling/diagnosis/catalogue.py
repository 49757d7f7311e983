"""The catalogue: which parameters of the plant each effect frees, in what range, and where a search begins.

The laws are physics of the plant (`slider_drilling.effects`); here they are only named. Parameters are called
``effect.parameter`` as in the rig file's ``effects:`` block.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.gap.model import Effect, Parameter, Values

# Periods of waves at sea, where the log itself shows no line.
ANY_WAVE_S = (6.0, 9.0, 13.0)
_GROWTH = Parameter("static_aging.growth", 0.0, -0.6, 6.0, 0.05)  # of friction, over any rest


def catalogue(
    length: float,
    duration: float,
    wave_periods: Sequence[float] = ANY_WAVE_S,
    tool_frequencies: Sequence[float] = (),
    interval: float = 0.0,
) -> tuple[Effect, ...]:
    """Every effect of `slider_drilling.effects`, contact first.

    length: m, of the string; duration: s, of the log.
    wave_periods: s, where a search for heave begins (peaks of the log's own spectrum: over 400 s a wave's phase is
    lost if its period is off by a per cent).
    tool_frequencies: Hz, that a tool in the string must have by the log's own spectrum, empty where that tells nothing.
    interval: s between samples of torque; a lag of less than half of it is how samples are stamped.
    """
    return (
        *_contact_laws(),
        _cuttings_bed(length),
        *_along_the_string(length, tool_frequencies),
        _heave(wave_periods),
        *_motor_and_bit(duration),
        *_torque_reading(interval),
    )


def _contact_laws() -> tuple[Effect, ...]:
    return (
        Effect(
            "stribeck", "contact",
            (
                Parameter("stribeck.drop", 0.0, -0.6, 4.0, 0.05),
                Parameter("stribeck.speed", 0.05, 0.004, 1.0, 0.01, "m/s"),
            ),
            # What sticks and slips is out of phase a factor of two away from what it does: a fit stays where it begins.
            scan=tuple((drop, speed) for drop in (0.25, 0.5, 1.0, 2.0) for speed in (0.015, 0.03, 0.06, 0.12, 0.3)),
            physical=(0.0, np.inf), nonphysical="friction that rises with slip speed",
            law="mu (1 + drop exp(-v / speed))",
        ),
        Effect(
            "viscous_drag", "contact",
            (Parameter("viscous_drag.coefficient", 0.0, 0.0, 300.0, 2.0, "N s/m2"),),
            scan=((5.0,), (20.0,), (60.0,)), law="c v per metre, axial and tangential",
        ),
        Effect(
            "static_aging", "contact",
            (
                _GROWTH,
                Parameter("static_aging.time", 5.0, 0.3, 150.0, 2.0, "s"),
            ),
            scan=tuple((growth, time) for growth in (0.3, 1.2) for time in (1.0, 5.0, 20.0, 60.0)),
            physical=(0.0, np.inf), nonphysical="friction that falls while the contact rests",
            law="mu (1 + growth (1 - exp(-t_rest / time)))",
        ),
        Effect(
            "buckling_contact", "contact",
            (Parameter("buckling_contact.factor", 0.0, 0.0, 20.0, 0.2),),
            scan=((0.5,), (1.0,), (4.0,)), law="w_n += k r T^2 / (4 E I) for T < 0",
        ),
        Effect(
            "friction_drift", "contact",
            (Parameter("friction_drift.rate", 0.0, -2e-3, 1e-2, 5e-5, "1/s"),),
            scan=((3e-4,), (-3e-4,), (1.5e-3,)), law="mu (1 + rate t)",
        ),
        Effect(
            "tortuosity", "contact",
            (Parameter("tortuosity.curvature", 0.0, 0.0, 0.02, 1e-4, "rad/m"),),
            scan=((2e-4,), (8e-4,), (3e-3,)), law="open hole: side force + |T| curvature",
        ),
    )  # fmt: skip


def static_aging_with_slip_distance() -> Effect:
    """`static_aging` that also frees the slip over which a rest is forgotten.

    In rocking a few millimetres cannot be told from none; in stick-slip, where every cycle ends in a short rest, that
    distance decides whether the string keeps sticking. Its phase hangs on the mesh, too: on the coarsest it is
    off by a cycle now and then.
    """
    return Effect(
        "static_aging", "contact",
        (
            _GROWTH,
            Parameter("static_aging.time", 5.0, 0.3, 150.0, 1.0, "s"),
            Parameter("static_aging.slip_distance", 0.005, 0.002, 4.0, 0.05, "m"),
        ),
        scan=((0.5, 2.0, 0.01), (0.5, 10.0, 0.01), (0.5, 5.0, 0.3), (1.0, 10.0, 1.0)),
        physical=(0.0, np.inf), nonphysical="friction that falls while the contact rests",
        law="mu (1 + growth (1 - exp(-t_rest / time))), t_rest forgotten over slip_distance", fidelity=1,
    )  # fmt: skip


def _cuttings_bed(length: float) -> Effect:
    """Searched for by how much it holds in all, by its middle and by its length (see `spoken`): what a log tells best,
    nearly not at all, and little.
    """
    narrow = [(0.6 * 0.12 * length, (0.21 + 0.1 * k) * length, 0.12 * length) for k in range(8)]
    wide = [(0.4 * 0.25 * length, (share + 0.125) * length, 0.25 * length) for share in (0.25, 0.45, 0.7)]
    return Effect(
        "cuttings_bed", "contact",
        (
            Parameter("cuttings_bed.excess", 0.0, -0.15 * length, length, 0.02 * length, "m"),
            Parameter("cuttings_bed.middle", 0.6 * length, 0.0, length, 0.01 * length, "m"),
            Parameter("cuttings_bed.length", 0.2 * length, 0.03 * length, 0.6 * length, 0.03 * length, "m"),
        ),
        scan=(*narrow, *wide), physical=(0.0, np.inf), nonphysical="less friction over one depth interval",
        law="friction times factor from top to bottom",
    )  # fmt: skip


def user_parameters(length: float) -> dict[str, Parameter]:
    """The rig file's parameters of what is fitted under other names; length: m, of the string."""
    return {
        parameter.name: parameter
        for parameter in (
            Parameter("cuttings_bed.factor", 1.0, 0.2, 20.0, 0.1),
            Parameter("cuttings_bed.top", 0.5 * length, 0.0, length, 0.01 * length, "m"),
            Parameter("cuttings_bed.bottom", 0.7 * length, 0.0, length, 0.01 * length, "m"),
        )
    }


def to_user(values: Values, length: float) -> dict[str, float]:
    """Fitted values as the rig file's ``effects:`` block wants them; length: m, of the string."""
    told = dict(values)
    if "cuttings_bed.excess" in told:
        excess = told.pop("cuttings_bed.excess")
        middle, long = told.pop("cuttings_bed.middle", 0.6 * length), told.pop("cuttings_bed.length", 0.2 * length)
        told["cuttings_bed.factor"] = float(np.clip(1.0 + excess / long, 0.2, 20.0))
        told["cuttings_bed.top"] = max(middle - 0.5 * long, 0.0)
        told["cuttings_bed.bottom"] = min(middle + 0.5 * long, length)
    if told.get("heave.amplitude", 0.0) < 0.0:
        # A wave of negative amplitude is the same wave half a period on.
        told["heave.amplitude"] *= -1.0
        told["heave.phase"] = (told.get("heave.phase", 0.0) + 2.0 * np.pi) % (2.0 * np.pi) - np.pi
    return told


def _along_the_string(length: float, tool_frequencies: Sequence[float]) -> tuple[Effect, ...]:
    shares = np.linspace(0.3, 0.96, 12) if tool_frequencies else (0.45, 0.65, 0.85)
    return (
        Effect(
            "top_drive_backlash", "top_drive",
            (Parameter("top_drive_backlash.angle", 0.0, 0.0, 6.3, 0.05, "rad"),),
            # Kinks hide what a little more of it would do: a fit stays near where it begins.
            scan=tuple((0.1 * 2.0 ** (0.5 * k),) for k in range(12)), law="dead zone between drive and string",
        ),
        Effect(
            "torsional_compliance", "string",
            (Parameter("torsional_compliance.extra", 0.0, -0.5, 3.0, 0.02),),
            scan=((0.05,), (0.15,), (0.5,)), physical=(0.0, np.inf), nonphysical="a stiffer string",
            law="G J / (1 + extra)",
        ),
        Effect(
            "axial_oscillation_tool", "string",
            (
                Parameter("axial_oscillation_tool.force", 0.0, 0.0, 2e5, 2000.0, "N"),
                # A frequency read off a line is known to a turn of the phase over the log.
                Parameter("axial_oscillation_tool.frequency", 15.0, 3.0, 40.0, 1e-3 if tool_frequencies else 1.0, "Hz"),
                Parameter("axial_oscillation_tool.depth", 0.7 * length, 0.0, length, 0.02 * length, "m"),
            ),
            # Waves of 300 m: what reaches the surface changes over a fraction of that.
            scan=tuple((4e3, hertz, share * length) for share in shares for hertz in tool_frequencies or (8.0, 16.0)),
            law="force sin(2 pi frequency t) at one depth", fidelity=1,
        ),
    )  # fmt: skip


def _heave(wave_periods: Sequence[float]) -> Effect:
    return Effect(
        "heave", "draw_works",
        (
            Parameter("heave.amplitude", 0.0, -3.0, 3.0, 0.02, "m"),
            Parameter("heave.period", 10.0, 2.5, 45.0, 0.02, "s"),
            Parameter("heave.phase", 0.0, -7.0, 7.0, 0.2, "rad"),
        ),
        # A period read off a spectrum that the rocking is in too is off by a per cent, which loses the phase in a log.
        scan=tuple(
            (0.05, period * (1.0 + off), phase)
            for period in wave_periods[:4]
            for off in (-0.012, -0.006, 0.0, 0.006, 0.012)
            for phase in (0.3, 1.9)
        ),
        law="block + amplitude sin(2 pi t / period + phase)",
    )  # fmt: skip


def _motor_and_bit(duration: float) -> tuple[Effect, ...]:
    return (
        Effect(
            "motor_wear", "motor",
            (
                Parameter("motor_wear.torque_loss", 0.0, -0.5, 0.8, 0.02),
                Parameter("motor_wear.extra_leak", 0.0, 0.0, 0.8, 0.05),
            ),
            scan=((0.1, 0.05), (0.2, 0.2), (0.1, 0.5)), physical=(0.0, np.inf),
            nonphysical="a motor that gives more torque per pressure",
            law="k_m (1 - torque_loss), leak + extra_leak",
        ),
        Effect(
            "formation_change", "bit",
            (
                Parameter("formation_change.factor", 1.0, 0.15, 6.0, 0.05),
                Parameter("formation_change.time", 0.5 * duration, 0.0, duration, 0.02 * duration, "s"),
            ),
            scan=tuple((1.4, share * duration) for share in (0.15, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85)),
            law="rock stiffness times factor from a time on",
        ),
    )  # fmt: skip


def _torque_reading(interval: float) -> tuple[Effect, ...]:
    return (
        Effect(
            "torque_sensor_gain", "sensor",
            (Parameter("torque_sensor_gain.gain", 0.0, -0.6, 1.5, 0.01),),
            scan=((0.05,), (-0.05,), (0.2,), (-0.2,)), law="torque (1 + gain)",
        ),
        Effect(
            "torque_sensor_lag", "sensor",
            (Parameter("torque_sensor_lag.lag", 0.0, 0.0, 8.0, 0.05, "s"),),
            scan=((0.1,), (0.4,), (1.2,)), physical=(0.5 * interval, np.inf),
            nonphysical="how samples are stamped, less than half the interval between them", law="first-order lag",
        ),
        Effect(
            "torque_sensor_bias", "sensor",
            (Parameter("torque_sensor_bias.bias", 0.0, -8000.0, 8000.0, 100.0, "N m"),),
            scan=((400.0,), (-400.0,), (1500.0,)), law="offset",
        ),
        Effect(
            "torque_at_motor", "top_drive",
            (
                Parameter("torque_at_motor.inertia", 0.0, 0.0, 8000.0, 100.0, "kg m2"),
                Parameter("torque_at_motor.friction", 0.0, 0.0, 6000.0, 100.0, "N m"),
            ),
            scan=((500.0, 100.0), (2000.0, 100.0), (1500.0, 1500.0)),
            law="torque + inertia d(speed)/dt + friction sign(speed)",
        ),
    )  # fmt: skip
