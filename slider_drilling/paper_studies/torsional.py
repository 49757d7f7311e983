"""Study: 3-D hydraulic oscillation system, torsional part (paper section 5.2.3, Fig. 19-21)."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import ellipk

from slider_drilling.contact import PAPER, FrictionHistory
from slider_drilling.pages import Chart
from slider_drilling.paper_studies.pipe import Pipe
from slider_drilling.paper_studies.settled_cycle import (
    SettledCycle,
    coulomb_force,
    from_rest,
    harmonic_share,
    settled_cycle,
)
from slider_drilling.paper_studies.study import Claim, Study, curve, curve_chart, falling, rounded, setting_name
from slider_drilling.paper_studies.tool_motions import ToolMotion, torsional

HOUR = 3600.0
RPM = math.pi / 30.0
FREQUENCY = 15.0
"""Hz. The paper gives none for the torsional tool; this is the frequency of its other tools."""
SPEEDS_RPM = (10, 20, 30)
RATES = (3, 5, 7, 9)
SWEEP_RPM = np.linspace(2.0, 40.0, 39)
PIPE = Pipe()


def study() -> Study:
    """10, 20, 30 rpm at 10 m/h, from rest and settled; amplitude sweep for 3-9 m/h; what the frequency does."""
    settled = [_settled(10, rpm, FREQUENCY) for rpm in SPEEDS_RPM]
    sweep = {rate: [_settled(rate, rpm, FREQUENCY).friction_ratio for rpm in SWEEP_RPM] for rate in RATES}
    frequencies = np.geomspace(0.1, 20.0, 16)
    by_frequency = {rpm: [_settled(10, rpm, f).friction_ratio for f in frequencies] for rpm in SPEEDS_RPM}
    onsets = {rpm: from_rest(_motion(10, rpm, FREQUENCY), 10.0, PIPE, PAPER) for rpm in SPEEDS_RPM}
    return Study(
        name="torsional",
        title="Torsional oscillation: 3-D hydraulic oscillation system",
        settings={
            "pipe": "Table 1, 10 m",
            "speed_amplitude_rpm": "10, 20, 30",
            "frequency_hz": FREQUENCY,
            "rate_of_penetration_m_per_h": "10; 3, 5, 7, 9",
        },
        figures=_figures(settled, sweep, frequencies, by_frequency, onsets),
        claims=(
            _lower_with_amplitude(settled),
            _fast_then_slow(sweep),
            _larger_at_higher_rate(sweep),
            _angle_range(settled),
            _sine(settled),
        ),
        notes=(
            "Vibration of 10 to 30 rpm at 15 Hz moves the pipe's surface by only "
            f"{1e3 * 10 * RPM * PIPE.radius / (2 * math.pi * FREQUENCY):.1f} to "
            f"{1e3 * 30 * RPM * PIPE.radius / (2 * math.pi * FREQUENCY):.1f} mm, a small part of the asperity's "
            "sliding length; at lower frequencies the amplitude grows and the friction falls with it.",
        ),
    )


def _figures(
    settled: list[SettledCycle], sweep: dict[int, list[float]], frequencies: np.ndarray,
    by_frequency: dict[int, list[float]], onsets: dict[int, FrictionHistory],
) -> tuple[Chart, ...]:  # fmt: skip
    cycles = [(f"{rpm} rpm", cycle.history) for rpm, cycle in zip(SPEEDS_RPM, settled, strict=True)]
    return (
        curve_chart(
            "From rest at 10 m/h (Fig. 19)", "time, s", "axial friction, N",
            [curve(f"{rpm} rpm", h.time[::15], -h.axial_force[::15]) for rpm, h in onsets.items()],
            level=(coulomb_force(PIPE, PAPER), "Coulomb"),
        ),
        curve_chart(
            "Amplitude (Fig. 21)", "amplitude of rotation speed, rpm", "axial friction / Coulomb",
            [curve(setting_name(rate, "m/h"), SWEEP_RPM, row) for rate, row in sweep.items()],
        ),
        curve_chart(
            "Friction coefficient over a settled cycle (Fig. 20, left)", "time, s", "friction coefficient",
            [curve(name, h.time, h.friction_coefficient) for name, h in cycles],
        ),
        curve_chart(
            "Angle between slip and asperity axis (Fig. 20, right)", "time, s", "angle of slip, deg",
            [curve(name, h.time, np.degrees(h.beta_v)) for name, h in cycles],
        ),
        _frequency_chart(frequencies, by_frequency),
    )  # fmt: skip


def _frequency_chart(frequencies: np.ndarray, by_frequency: dict[int, list[float]]) -> Chart:
    model = [curve(f"{rpm} rpm", frequencies, row, colour=k) for k, (rpm, row) in enumerate(by_frequency.items())]
    rigid = [
        curve(f"{rpm} rpm, rigid", frequencies, np.full(frequencies.size, rigid_ratio(10, rpm)), True, k)
        for k, rpm in enumerate(SPEEDS_RPM)
    ]
    return curve_chart(
        "Frequency at 10 m/h, and the rigid limit (dashed)", "frequency, Hz", "axial friction / Coulomb",
        [*model, *rigid], log_x=True, log_y=True,
    )  # fmt: skip


def rigid_ratio(rate_m_per_h: float, speed_rpm: float) -> float:
    """Axial over Coulomb friction of a rigid isotropic contact under torsional vibration (`model.md` section 2)."""
    v, va = rate_m_per_h / HOUR, speed_rpm * RPM * PIPE.radius
    squared = v * v + va * va
    return float(2.0 / math.pi * v / math.sqrt(squared) * ellipk(va * va / squared))


def _motion(rate: float, speed_rpm: float, frequency: float) -> ToolMotion:
    return torsional(rate / HOUR, speed_rpm * RPM, frequency, PIPE.radius)


def _settled(rate: float, speed_rpm: float, frequency: float) -> SettledCycle:
    return settled_cycle(_motion(rate, speed_rpm, frequency), PIPE, PAPER)


def _lower_with_amplitude(settled: list[SettledCycle]) -> Claim:
    ratios = [s.friction_ratio for s in settled]
    holds = falling([1.0 - 0.01, *ratios])
    return Claim(
        "Torsional oscillation of 10, 20 and 30 rpm reduces axial friction, the more the larger it is.",
        "section 5.2.3, Fig. 19",
        {
            "speed_amplitude_rpm": list(SPEEDS_RPM),
            "friction_over_coulomb": rounded(ratios),
            "friction_over_coulomb_at_5_hz": rounded(_settled(10, rpm, 5.0).friction_ratio for rpm in SPEEDS_RPM),
            "friction_over_coulomb_if_rigid": rounded(rigid_ratio(10, rpm) for rpm in SPEEDS_RPM),
        },
        holds,
        "" if holds else "It does not fall throughout.",
    )


def _fast_then_slow(sweep: dict[int, list[float]]) -> Claim:
    measured = {}
    for rate, row in sweep.items():
        slope = np.diff(row) / np.diff(SWEEP_RPM)
        steepest = int(np.argmin(slope))
        measured[f"{rate} m/h"] = {
            "steepest_per_rpm": round(float(slope[steepest]), 4),
            "at_rpm": round(float(SWEEP_RPM[steepest]), 1),
            "last_per_rpm": round(float(slope[-1]), 5),
            "first_per_rpm": round(float(slope[0]), 5),
        }
    convex = all(m["at_rpm"] <= SWEEP_RPM[0] + 1e-9 for m in measured.values())
    return Claim(
        "The ratio falls with amplitude, fast at first and slowly in the end.",
        "section 5.2.3, Fig. 21",
        measured,
        convex,
        ""
        if convex
        else "It falls slowly in the end, but not fast at first: a small swing hardly turns the deformation away from "
        "the feed, so the ratio starts at 1 with almost no slope and is steepest at a middle amplitude (at_rpm).",
    )


def _larger_at_higher_rate(sweep: dict[int, list[float]]) -> Claim:
    table = np.array([sweep[rate] for rate in RATES])
    worst = float(np.diff(table, axis=0).min())
    return Claim(
        "Axial friction is larger at a higher rate of penetration.",
        "section 5.2.3, Fig. 21",
        {
            "at_20_rpm": {f"{rate} m/h": round(float(np.interp(20.0, SWEEP_RPM, sweep[rate])), 4) for rate in RATES},
            "smallest_rise_over_the_sweep": round(worst, 5),
        },
        worst > -1e-4,
    )


def _angle_range(settled: list[SettledCycle]) -> Claim:
    angle = [float(np.degrees(np.ptp(s.history.beta_v))) for s in settled]
    friction = [float(np.ptp(s.history.friction_coefficient)) for s in settled]
    return Claim(
        "The smaller the torsional vibration, the smaller the range of the friction coefficient and of beta_v.",
        "section 5.2.3, Fig. 20",
        {
            "speed_amplitude_rpm": list(SPEEDS_RPM),
            "range_of_friction_coefficient": rounded(friction),
            "range_of_beta_v_deg": rounded(angle, 2),
        },
        falling(reversed(angle)) and falling(reversed(friction)),
        'The paper\'s own sentence gives "the greater variation ranges of the angle" as the reason for the smaller '
        "range "
        "of the friction; here both ranges grow with the amplitude.",
    )


def _sine(settled: list[SettledCycle]) -> Claim:
    signed = [np.arctan2(s.history.deformation_tangential, s.history.deformation_axial) for s in settled]
    shares = [harmonic_share(row) for row in signed]
    return Claim(
        "The angle follows a pattern like a sine.",
        "section 5.2.3, Fig. 20",
        {"speed_amplitude_rpm": list(SPEEDS_RPM), "share_of_the_first_harmonic": rounded(shares)},
        min(shares) > 0.9,
        ""
        if min(shares) > 0.9
        else "It holds at the smallest amplitude. At larger ones the deformation passes the axis quickly and stays "
        "near 90 degrees, closer to a square wave.",
    )
