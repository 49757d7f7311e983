"""Study: the radial hydraulic oscillator, a normal force that comes and goes (paper section 5.2.2, Fig. 17, 18)."""

from __future__ import annotations

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
    falling,
    rounded,
    setting_name,
)
from slider_drilling.paper_studies.tool_motions import radial

HOUR = 3600.0
RATIOS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
RATES = (3, 5, 7, 9)
FREQUENCIES = (5.0, 10.0, 15.0, 20.0)
PIPE = Pipe()


def study() -> Study:
    """Load ratio 0.1-0.6 for 3-9 m/h at 15 Hz, and 5-20 Hz at 5 m/h."""
    by_rate = {
        rate: [settled_cycle(radial(rate / HOUR, ratio, 15.0), PIPE, PAPER) for ratio in RATIOS] for rate in RATES
    }
    by_frequency = {
        f: [settled_cycle(radial(5 / HOUR, ratio, f), PIPE, PAPER) for ratio in RATIOS] for f in FREQUENCIES
    }
    harmonic = np.sqrt(1.0 - np.array(RATIOS) ** 2)
    return Study(
        name="radial",
        title="Radial oscillation: radial hydraulic oscillator",
        settings={
            "pipe": "Table 1, 10 m",
            "load_ratio": "0.1 to 0.6",
            "frequency_hz": "15; 5 to 20 at 5 m/h",
            "rate_of_penetration_m_per_h": "3, 5, 7, 9",
        },
        figures=_figures(by_rate, by_frequency, harmonic),
        claims=(
            _independent("the rate of penetration (3 to 9 m/h)", "Fig. 17, 18", by_rate),
            _independent("the frequency (5 to 20 Hz)", "section 5.2.2", by_frequency),
            _falls(by_rate),
            _bounded(by_rate),
            _slight(by_rate),
        ),
        notes=(
            "This is one contact of constant kt, as in the paper: its sliding length z_ss = mu F_N/kt follows the "
            "load. Over a cycle much shorter than z_ss the deformation settles where sliding at the harmonic mean of "
            "the load would. With kt proportional to the load, as in the drill string, the mean would not fall at all.",
        ),
    )


def _figures(
    by_rate: dict[int, list[SettledCycle]], by_frequency: dict[float, list[SettledCycle]], harmonic: np.ndarray
) -> tuple[Chart, ...]:
    return (
        curve_chart(
            "From rest, ratio 0.3, 15 Hz (Fig. 17)",
            "time, s",
            "axial friction, N",
            tuple(_onset(rate) for rate in RATES),
            level=(coulomb_force(PIPE, PAPER), "Coulomb"),
        ),
        curve_chart(
            "One settled cycle, ratio 0.6, 15 Hz",
            "time, s",
            "axial friction, N",
            tuple(
                curve(setting_name(rate, "m/h"), row[-1].history.time, -row[-1].history.axial_force)
                for rate, row in by_rate.items()
            ),
        ),
        curve_chart(
            "Ratio of radial vibration (Fig. 18)",
            "load amplitude / mean load",
            "axial friction / Coulomb",
            (
                *(
                    curve(setting_name(rate, "m/h"), RATIOS, [s.friction_ratio for s in row])
                    for rate, row in by_rate.items()
                ),
                curve("harmonic mean of the load, sqrt(1 - ratio^2)", RATIOS, harmonic, True),
            ),
        ),
        curve_chart(
            "Frequency, at 5 m/h",
            "load amplitude / mean load",
            "axial friction / Coulomb",
            tuple(curve(f"{f:g} Hz", RATIOS, [s.friction_ratio for s in row]) for f, row in by_frequency.items()),
        ),
    )


def _onset(rate: int) -> Line:
    history = from_rest(radial(rate / HOUR, 0.3, 15.0), 60.0, PIPE, PAPER)
    return curve(setting_name(rate, "m/h"), history.time[::90], -history.axial_force[::90])


def _independent(what: str, where: str, runs: dict[Any, list[SettledCycle]]) -> Claim:
    changes = [
        max(s.friction_ratio for s in column) - min(s.friction_ratio for s in column)
        for column in zip(*runs.values(), strict=True)
    ]
    at_03 = {str(key): round(row[2].friction_ratio, 5) for key, row in runs.items()}
    return Claim(
        f"The mean friction under radial vibration does not depend on {what}.",
        where,
        {"at_ratio_0.3": at_03, "largest_change_over_coulomb": round(max(changes), 6), "allowed_change": UNCHANGED},
        max(changes) < UNCHANGED,
    )


def _falls(by_rate: dict[int, list[SettledCycle]]) -> Claim:
    row = [s.friction_ratio for s in by_rate[7]]
    return Claim(
        "Axial friction falls as the ratio of radial vibration grows.",
        "section 5.2.2, Fig. 18",
        {"ratio": list(RATIOS), "friction_over_coulomb_at_7_m_per_h": rounded(row)},
        falling(row),
    )


def _bounded(by_rate: dict[int, list[SettledCycle]]) -> Claim:
    most = 1.0 - min(s.friction_ratio for row in by_rate.values() for s in row)
    return Claim(
        "Axial friction falls by less than about 20 %.",
        "section 5.2.2",
        {"largest_fall": round(most, 5)},
        most < 0.205,
        "The limit is the harmonic mean of the load, 1 - sqrt(1 - 0.6^2) = 20 % at the largest ratio.",
    )


def _slight(by_rate: dict[int, list[SettledCycle]]) -> Claim:
    swings = [float(np.ptp(row[2].history.axial_force)) / row[2].coulomb_force for row in by_rate.values()]
    return Claim(
        "Once settled the friction only fluctuates slightly within a cycle.",
        "section 5.2.2, Fig. 17",
        {"peak_to_peak_over_coulomb_at_ratio_0.3": between(swings)},
        max(swings) < UNCHANGED,
    )
