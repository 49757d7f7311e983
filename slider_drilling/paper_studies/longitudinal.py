"""Study: NOV's hydraulic oscillation system, shaking along the hole (paper section 5.2.1, Fig. 15 and 16)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from slider_drilling.contact import PAPER
from slider_drilling.pages import Chart, Line
from slider_drilling.paper_studies.pipe import Pipe
from slider_drilling.paper_studies.settled_cycle import SettledCycle, coulomb_force, from_rest, settled_cycle
from slider_drilling.paper_studies.study import (
    UNCHANGED,
    Claim,
    Study,
    between,
    curve,
    curve_chart,
    rounded,
    setting_name,
)
from slider_drilling.paper_studies.tool_motions import longitudinal

HOUR = 3600.0
AMPLITUDES_MM = (2, 3, 4, 5, 6, 7)
FREQUENCIES = (5.0, 10.0, 15.0, 20.0)
RATES = (3, 5, 7, 9)
PIPE = Pipe()


def study() -> Study:
    """Amplitude 2-7 mm at 15 Hz for 3-9 m/h; frequency 5-20 Hz at 10 m/h; the velocity ratio from 0.1 up."""
    by_rate = {rate: [_settled(rate, mm, 15.0) for mm in AMPLITUDES_MM] for rate in RATES}
    by_frequency = {f: [_settled(10, mm, f) for mm in AMPLITUDES_MM] for f in FREQUENCIES}
    ratios = np.geomspace(0.1, 1000.0, 61)
    swept = [_settled(7, 1000.0 * kappa * (7 / HOUR) / (2.0 * math.pi * 15.0), 15.0) for kappa in ratios]
    rigid = np.where(ratios <= 1.0, 1.0, 2.0 / math.pi * np.arcsin(np.minimum(1.0, 1.0 / ratios)))
    return Study(
        name="longitudinal",
        title="Longitudinal oscillation: NOV hydraulic oscillation system",
        settings={
            "pipe": "Table 1, 10 m",
            "amplitude_mm": "2 to 7",
            "frequency_hz": "15; 5 to 20 at 10 m/h",
            "rate_of_penetration_m_per_h": "3, 5, 7, 9",
        },
        figures=_figures(by_rate, by_frequency, ratios, swept, rigid),
        claims=(_reduces(by_rate), _little_change(by_rate), _no_frequency(by_frequency), _critical(ratios, swept)),
    )


def _figures(
    by_rate: dict[int, list[SettledCycle]], by_frequency: dict[float, list[SettledCycle]], ratios: np.ndarray,
    swept: list[SettledCycle], rigid: np.ndarray,
) -> tuple[Chart, ...]:
    return (
        curve_chart(
            "From rest at 7 m/h and 15 Hz (Fig. 15)",
            "time, s",
            "axial friction, N",
            tuple(_onset(mm) for mm in (2, 4, 7)),
            level=(coulomb_force(PIPE, PAPER), "Coulomb"),
        ),
        curve_chart(
            "Mean magnitude (eq. 25) and signed mean at 7 m/h",
            "velocity ratio va/v",
            "axial friction / Coulomb",
            (
                curve("mean magnitude", ratios, [s.friction_ratio for s in swept]),
                curve("signed mean: what feeds the bit", ratios, [s.signed_friction_ratio for s in swept]),
                curve("rigid limit of the signed mean", ratios, rigid, dashed=True),
            ),
            log_x=True,
            log_y=True,
        ),
        curve_chart(
            "Amplitude at 15 Hz: mean magnitude (full), signed mean (dashed)",
            "amplitude, mm",
            "axial friction / Coulomb",
            _pairs(by_rate, "m/h"),
            log_y=True,
        ),
        curve_chart(
            "Frequency at 10 m/h: mean magnitude (full), signed mean (dashed)",
            "amplitude, mm",
            "axial friction / Coulomb",
            _pairs(by_frequency, "Hz"),
            log_y=True,
        ),
    )


def _settled(rate: float, amplitude_mm: float, frequency: float) -> SettledCycle:
    return settled_cycle(longitudinal(rate / HOUR, 1e-3 * amplitude_mm, frequency), PIPE, PAPER)


def _onset(amplitude_mm: int) -> Line:
    history = from_rest(longitudinal(7 / HOUR, 1e-3 * amplitude_mm, 15.0), 0.6, PIPE, PAPER)
    return curve(setting_name(amplitude_mm, "mm"), history.time[::6], -history.axial_force[::6])


def _pairs(runs: dict[Any, list[SettledCycle]], unit: str) -> tuple[Line, ...]:
    full = [
        curve(setting_name(key, unit), AMPLITUDES_MM, [s.friction_ratio for s in row], colour=k)
        for k, (key, row) in enumerate(runs.items())
    ]
    signed = [
        curve(setting_name(key, unit, ", signed"), AMPLITUDES_MM, [s.signed_friction_ratio for s in row], True, k)
        for k, (key, row) in enumerate(runs.items())
    ]
    return (*full, *signed)


def _reduces(by_rate: dict[int, list[SettledCycle]]) -> Claim:
    magnitude = [s.friction_ratio for row in by_rate.values() for s in row]
    signed = [s.signed_friction_ratio for row in by_rate.values() for s in row]
    return Claim(
        "Longitudinal vibration reduces axial friction.",
        "section 5.2.1, conclusions",
        {"mean_magnitude_over_coulomb": between(magnitude), "signed_mean_over_coulomb": between(signed)},
        max(magnitude) < 1.0 and max(signed) < 1.0,
    )


def _little_change(by_rate: dict[int, list[SettledCycle]]) -> Claim:
    row = by_rate[7]
    magnitude, signed = [s.friction_ratio for s in row], [s.signed_friction_ratio for s in row]
    kappa = [round(2.0 * math.pi * 15.0 * 1e-3 * mm / (7 / HOUR)) for mm in AMPLITUDES_MM]
    length_mm = 1e3 * coulomb_force(PIPE, PAPER) / PAPER.stiffness
    holds = abs(magnitude[-1] - magnitude[0]) < UNCHANGED
    return Claim(
        "Beyond a velocity ratio of 1 the friction over Coulomb friction changes little with amplitude.",
        "section 5.2.1, Fig. 15; abstract",
        {
            "amplitude_mm": list(AMPLITUDES_MM),
            "velocity_ratio": kappa,
            "mean_magnitude_over_coulomb": rounded(magnitude),
            "signed_mean_over_coulomb": rounded(signed),
            "allowed_change": UNCHANGED,
        },
        holds,
        ""
        if holds
        else f"All amplitudes are far beyond a velocity ratio of 1, but below the {length_mm:.0f} mm over which the "
        "asperity deforms before it slides. It is bent to and fro, and the mean magnitude grows almost in proportion "
        "to the amplitude. The claim holds for the signed mean, which is what feeds the bit: it stays below "
        f"{100 * max(signed):.1f} % of Coulomb friction and changes by {100 * (max(signed) - min(signed)):.1f} %.",
    )


def _no_frequency(by_frequency: dict[float, list[SettledCycle]]) -> Claim:
    at_4_mm = [row[2] for row in by_frequency.values()]
    changes = [
        max(s.friction_ratio for s in column) - min(s.friction_ratio for s in column)
        for column in zip(*by_frequency.values(), strict=True)
    ]
    signed = [s.signed_friction_ratio for s in at_4_mm]
    return Claim(
        "The frequency of longitudinal oscillation (5 to 20 Hz) has no effect on the friction.",
        "section 5.2.1, Fig. 16",
        {
            "frequency_hz": list(FREQUENCIES),
            "at_4_mm_mean_magnitude_over_coulomb": rounded(s.friction_ratio for s in at_4_mm),
            "at_4_mm_signed_mean_over_coulomb": rounded(signed),
            "largest_change_of_the_magnitude": round(max(changes), 4),
            "allowed_change": UNCHANGED,
        },
        max(changes) < UNCHANGED,
        "The verdict is on the paper's measure, the mean magnitude. The signed mean follows the velocity ratio and so "
        f"falls as 1/frequency, from {100 * signed[0]:.1f} to {100 * signed[-1]:.1f} % of Coulomb friction at 4 mm.",
    )


def _critical(ratios: np.ndarray, swept: list[SettledCycle]) -> Claim:
    below = [s.friction_ratio for s, kappa in zip(swept, ratios, strict=True) if kappa <= 1.0]
    above = [s.friction_ratio for s, kappa in zip(swept, ratios, strict=True) if 1.0 < kappa <= 30.0]
    return Claim(
        "Friction falls only once the velocity ratio exceeds 1.",
        "section 5.2.1, conclusions",
        {"mean_magnitude_over_coulomb_below": between(below), "from_1_to_30": between(above)},
        min(below) > 0.99 and min(above) < 0.5,
    )
