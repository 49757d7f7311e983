"""Study: 3-D hydraulic oscillation system, axial and torsional vibration at once (paper section 2.1.2)."""

from __future__ import annotations

import math

import numpy as np

from slider_drilling.contact import PAPER
from slider_drilling.pages import Chart, HeatMap, Line
from slider_drilling.paper_studies.pipe import Pipe
from slider_drilling.paper_studies.settled_cycle import SettledCycle, settled_cycle
from slider_drilling.paper_studies.study import Claim, Study, curve, curve_chart, rounded, setting_name
from slider_drilling.paper_studies.tool_motions import three_d
from slider_drilling.units import sentence

HOUR = 3600.0
RPM = math.pi / 30.0
FREQUENCY = 15.0
PIPE = Pipe()
AXIAL_MM = np.linspace(0.0, 7.0, 15, dtype=np.float64)
SPEED_RPM = np.linspace(0.0, 30.0, 16, dtype=np.float64)


def study() -> Study:
    """Axial amplitude 0-7 mm by torsional speed amplitude 0-30 rpm, both at 15 Hz, at 5 and 10 m/h."""
    runs = {rate: [[_settled(rate, mm, rpm) for mm in AXIAL_MM] for rpm in SPEED_RPM] for rate in (5, 10)}
    maps = tuple(
        HeatMap(
            sentence(f"{title}, ", setting_name(rate, "m/h")),
            "axial amplitude, mm",
            "torsional speed amplitude, rpm",
            "axial friction / Coulomb",
            AXIAL_MM,
            SPEED_RPM,
            np.array([[getattr(s, attribute) for s in row] for row in rows]),
            log_colours=True,
        )
        for title, attribute in (("Mean magnitude", "friction_ratio"), ("Signed mean", "signed_friction_ratio"))
        for rate, rows in runs.items()
    )
    pick = [0, 4, 8, 14]
    lines = tuple(
        curve(setting_name(AXIAL_MM[k], "mm"), SPEED_RPM, [row[k].signed_friction_ratio for row in runs[10]])
        for k in pick
    )
    return Study(
        name="three_d",
        title="Axial and torsional oscillation at once: 3-D hydraulic oscillation system",
        settings={
            "pipe": "Table 1, 10 m",
            "axial_amplitude_mm": "0 to 7",
            "speed_amplitude_rpm": "0 to 30",
            "frequency_hz": FREQUENCY,
            "phase": "a quarter period apart",
            "rate_of_penetration_m_per_h": "5, 10",
        },
        figures=_figures(maps, lines),
        claims=(_both(runs[10]),),
        notes=(
            "The paper shows no figure for this tool. The magnitude counts the axial force that shakes the pipe to "
            "and fro; the signed mean is what holds the feed back.",
        ),
    )


def _figures(maps: tuple[HeatMap, ...], lines: tuple[Line, ...]) -> tuple[Chart | HeatMap, ...]:
    return (
        *maps,
        curve_chart("Signed mean at 10 m/h", "torsional speed amplitude, rpm", "axial friction / Coulomb", lines),
    )


def _settled(rate: int, amplitude_mm: float, speed_rpm: float) -> SettledCycle:
    return settled_cycle(
        three_d(rate / HOUR, 1e-3 * amplitude_mm, speed_rpm * RPM, FREQUENCY, PIPE.radius), PIPE, PAPER
    )


def _both(rows: list[list[SettledCycle]]) -> Claim:
    axial, torsional, both = rows[0][8], rows[10][0], rows[10][8]
    lower = both.signed_friction_ratio < min(axial.signed_friction_ratio, torsional.signed_friction_ratio)
    holds = max(axial.friction_ratio, torsional.friction_ratio, both.friction_ratio) < 1.0
    return Claim(
        "The tool vibrates axially and torsionally at once, and reduces friction.",
        "section 2.1.2 (no figure)",
        {
            "axial_4_mm, torsional_20_rpm, both: mean magnitude": rounded(
                s.friction_ratio for s in (axial, torsional, both)
            ),
            "signed mean": rounded(s.signed_friction_ratio for s in (axial, torsional, both)),
            "both_together_have_the_lowest_signed_mean": lower,
        },
        holds,
    )
