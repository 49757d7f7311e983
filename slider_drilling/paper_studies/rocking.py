"""Study: slider drilling, the pipe rocked from the surface (paper section 5.3, Fig. 22-25)."""

from __future__ import annotations

import math

import numpy as np

from slider_drilling.contact import PAPER, FrictionHistory
from slider_drilling.control.rocking import Rocking
from slider_drilling.pages import Chart
from slider_drilling.paper_studies.pipe import Pipe
from slider_drilling.paper_studies.settled_cycle import SettledCycle, from_rest, settled_cycle
from slider_drilling.paper_studies.study import Claim, Study, curve, curve_chart, falling, rounded, setting_name
from slider_drilling.paper_studies.tool_motions import ToolMotion, rocking

HOUR = 3600.0
RATES = (1, 3, 5, 7)
PERIOD = 10.0
ROUNDING = 0.2
AMPLITUDE = 10.0
AMPLITUDES = np.array([0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 7.5, 10.0, 15.0, 20.0, 30.0])
PIPE = Pipe()


def study() -> Study:
    """D_y = 10 rad, T = 10 s, delta = 0.2 s at 1-7 m/h; amplitude 0.25-30 rad."""
    settled = {rate: settled_cycle(_motion(rate, AMPLITUDE), PIPE, PAPER) for rate in RATES}
    sweep = {
        rate: [settled_cycle(_motion(rate, float(d)), PIPE, PAPER).friction_ratio for d in AMPLITUDES] for rate in RATES
    }
    onsets = {rate: from_rest(_motion(rate, AMPLITUDE), 30.0, PIPE, PAPER) for rate in RATES}
    wave = _motion(5, AMPLITUDE)
    return Study(
        name="rocking",
        title="Rocking from the surface: slider drilling",
        settings={
            "pipe": "Table 1, 10 m",
            "amplitude_rad": f"{AMPLITUDE:g}; 0.25 to 30",
            "period_s": PERIOD,
            "rounding_s": ROUNDING,
            "rate_of_penetration_m_per_h": "1, 3, 5, 7",
        },
        figures=_figures(settled, sweep, onsets, wave),
        claims=(_low_then_peaks(settled), _lower_at_lower_rate(settled), _falls(sweep), _steady_angle(settled)),
    )


def _figures(
    settled: dict[int, SettledCycle], sweep: dict[int, list[float]], onsets: dict[int, FrictionHistory],
    wave: ToolMotion,
) -> tuple[Chart, ...]:  # fmt: skip
    return (
        curve_chart(
            "Trajectory (Fig. 22)", "time, s", "angle, rad", [curve("angle", wave.time, wave.tangential / PIPE.radius)]
        ),
        curve_chart(
            "From rest (Fig. 23)", "time, s", "axial friction, N",
            [curve(setting_name(rate, "m/h"), h.time, -h.axial_force) for rate, h in onsets.items()],
        ),
        *_cycle_charts(settled),
        _amplitude_chart(sweep),
    )  # fmt: skip


def _cycle_charts(settled: dict[int, SettledCycle]) -> tuple[Chart, ...]:
    """One settled cycle: axial friction, friction coefficient and direction of slip."""
    cycles = [(setting_name(rate, "m/h"), cycle.history, cycle.coulomb_force) for rate, cycle in settled.items()]
    return (
        curve_chart(
            "One settled cycle (Fig. 23)", "time, s", "axial friction / Coulomb",
            [curve(name, h.time, -h.axial_force / coulomb) for name, h, coulomb in cycles], log_y=True,
        ),
        curve_chart(
            "Friction coefficient (Fig. 24, left)", "time, s", "friction coefficient",
            [curve(name, h.time, h.friction_coefficient) for name, h, _ in cycles],
        ),
        curve_chart(
            "Angle between slip and asperity axis (Fig. 24, right)", "time, s", "angle of slip, deg",
            [curve(name, h.time, np.degrees(h.beta_v)) for name, h, _ in cycles],
        ),
    )  # fmt: skip


def _amplitude_chart(sweep: dict[int, list[float]]) -> Chart:
    model = [curve(setting_name(rate, "m/h"), AMPLITUDES, row, colour=k) for k, (rate, row) in enumerate(sweep.items())]
    rigid_ratios = [[rigid_ratio(rate, float(d)) for d in AMPLITUDES] for rate in RATES]
    rigid = [
        curve(setting_name(rate, "m/h", ", rigid"), AMPLITUDES, ratios, True, k)
        for k, (rate, ratios) in enumerate(zip(RATES, rigid_ratios, strict=True))
    ]
    return curve_chart(
        "Amplitude (Fig. 25) and the rigid limit (dashed)", "amplitude, rad", "axial friction / Coulomb",
        [*model, *rigid], log_x=True, log_y=True,
    )  # fmt: skip


def rigid_ratio(rate_m_per_h: float, amplitude: float, period: float = PERIOD, rounding: float = ROUNDING) -> float:
    """Axial over Coulomb friction of a rigid isotropic contact that is rocked (`model.md` section 2).

    This is the mean of v / sqrt(v^2 + vt^2). The tangential speed vt is constant except for 4 delta of every period,
    where it changes linearly between its two values; that part integrates to asinh.

    Args:
        rate_m_per_h: Rate of penetration.
        amplitude: rad.
        period, rounding: T and delta of the rocking, s.
    """
    v = rate_m_per_h / HOUR
    top = 4.0 * amplitude / period * PIPE.radius
    rounded_share = 4.0 * rounding / period
    return (1.0 - rounded_share) * v / math.hypot(v, top) + rounded_share * v / top * math.asinh(top / v)


def _motion(rate: float, amplitude: float) -> ToolMotion:
    return rocking(rate / HOUR, Rocking(amplitude, PERIOD, ROUNDING), PIPE.radius)


def _phases(settled: SettledCycle) -> tuple[float, float]:
    """Axial over Coulomb friction: mean over the second half of the constant-speed parts, and peak near reversals."""
    time, force = settled.history.time, -settled.history.axial_force / settled.coulomb_force
    to_reversal = np.abs((time + 0.5 * PERIOD) % (0.5 * PERIOD) - 0.25 * PERIOD)
    return float(np.mean(force[_constant_speed(time)])), float(force[to_reversal < 2.0 * ROUNDING].max())


def _constant_speed(time: np.ndarray) -> np.ndarray:
    """Which samples lie in the second half of a part with constant rotation speed."""
    since_reversal = (time - 0.25 * PERIOD) % (0.5 * PERIOD)
    return (since_reversal > 0.25 * PERIOD) & (since_reversal < 0.5 * PERIOD - ROUNDING)


def _low_then_peaks(settled: dict[int, SettledCycle]) -> Claim:
    low, peak = zip(*(_phases(s) for s in settled.values()), strict=True)
    return Claim(
        "Axial friction is low and steady at constant rotation speed, and peaks at the reversals.",
        "section 5.3, Fig. 23",
        {"rate_m_per_h": list(RATES), "plateau_over_coulomb": rounded(low, 5), "peak_over_coulomb": rounded(peak, 5)},
        max(low) < 0.02 and all(p > 2.0 * q for p, q in zip(peak, low, strict=True)),
    )


def _lower_at_lower_rate(settled: dict[int, SettledCycle]) -> Claim:
    low, peak = zip(*(_phases(s) for s in settled.values()), strict=True)
    means = [s.friction_ratio for s in settled.values()]
    return Claim(
        "A lower rate of penetration gives less axial friction, both at constant speed and at the reversals.",
        "section 5.3, Fig. 23",
        {
            "rate_m_per_h": list(RATES),
            "mean_over_coulomb": rounded(means, 5),
            "plateau_over_coulomb": rounded(low, 5),
            "peak_over_coulomb": rounded(peak, 5),
            "rigid_limit": rounded((rigid_ratio(r, AMPLITUDE) for r in RATES), 5),
        },
        all(falling(reversed(row)) for row in (means, low, peak)),
    )


def _falls(sweep: dict[int, list[float]]) -> Claim:
    rates = np.array([sweep[rate] for rate in RATES])
    return Claim(
        "Axial friction over Coulomb friction falls as the amplitude grows, and is greater at a greater rate.",
        "section 5.3, Fig. 25",
        {"amplitude_rad": AMPLITUDES.tolist(), **{f"{rate} m/h": rounded(row, 5) for rate, row in sweep.items()}},
        all(falling(row) for row in sweep.values()) and bool(np.all(np.diff(rates, axis=0) > 0.0)),
    )


def _steady_angle(settled: dict[int, SettledCycle]) -> Claim:
    swings, means = {}, []
    for rate, s in settled.items():
        angle = np.degrees(s.history.beta_v)[_constant_speed(s.history.time)]
        swings[f"{rate} m/h"] = round(float(np.ptp(angle)), 4)
        means.append(float(np.mean(angle)))
    return Claim(
        "The direction of the deformation is stable while the tangential speed is constant, and hardly differs "
        "between rates of penetration.",
        "section 5.3, Fig. 24",
        {"change_of_beta_v_deg": swings, "mean_beta_v_deg": rounded(means, 3)},
        max(swings.values()) < 0.1 and max(means) - min(means) < 1.0,
    )
