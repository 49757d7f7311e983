"""Study: every tool of the paper over the field's ranges, side by side (paper section 5.3 and conclusions)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.contact import PAPER
from slider_drilling.control.rocking import Rocking
from slider_drilling.pages import Chart
from slider_drilling.paper_studies.pipe import Pipe
from slider_drilling.paper_studies.settled_cycle import SettledCycle, settled_cycle
from slider_drilling.paper_studies.study import Claim, Study, between, curve, curve_chart, display_name, setting_name
from slider_drilling.paper_studies.tool_motions import ToolMotion, longitudinal, radial, rocking, three_d, torsional
from slider_drilling.units import sentence

HOUR = 3600.0
RPM = math.pi / 30.0
RATES = (3, 5, 7, 9)
PIPE = Pipe()
FREQUENCY = 15.0


@dataclass(frozen=True)
class Tool:
    """A tool's motions at one rate of penetration, from the weakest to the strongest the field uses."""

    name: str
    motions: dict[int, tuple[ToolMotion, ...]]


def study() -> Study:
    """Friction of every tool, weakest to strongest setting, at 3-9 m/h."""
    runs = {
        tool.name: {rate: [settled_cycle(m, PIPE, PAPER) for m in row] for rate, row in tool.motions.items()}
        for tool in _tools()
    }
    return Study(
        name="comparison",
        title="All vibration tools over the field's ranges",
        settings={
            "pipe": "Table 1, 10 m",
            "longitudinal": "2, 4.5, 7 mm at 15 Hz",
            "radial": "ratio 0.1, 0.35, 0.6 at 15 Hz",
            "torsional": "10, 20, 30 rpm at 15 Hz",
            "three_d": "2 mm and 10 rpm to 7 mm and 30 rpm at 15 Hz",
            "rocking": "5, 10, 15 rad, T = 10 s, delta = 0.2 s",
            "rate_of_penetration_m_per_h": "3, 5, 7, 9",
        },
        figures=_figures(runs),
        claims=(
            _most(runs, "friction_ratio", "mean magnitude"),
            _most(runs, "signed_friction_ratio", "signed mean"),
            _all_reduce(runs),
        ),
    )


def _figures(runs: dict[str, dict[int, list[SettledCycle]]]) -> tuple[Chart, ...]:
    place = [0.0, 0.5, 1.0]

    def chart(title: str, attribute: str, rate: int) -> Chart:
        # 3-D almost equals the longitudinal tool alone: dashed, so that both are visible.
        curves = [
            curve(display_name(name), place, [max(getattr(s, attribute), 1e-5) for s in rows[rate]], name == "three_d")
            for name, rows in runs.items()
        ]
        label = "setting, weakest (0) to strongest (1)"
        title_at_rate = sentence(f"{title} at ", setting_name(rate, "m/h"))
        return curve_chart(title_at_rate, label, "axial friction / Coulomb", curves, log_y=True)

    measures = (("Mean magnitude", "friction_ratio"), ("Signed mean", "signed_friction_ratio"))
    return tuple(chart(title, attribute, rate) for title, attribute in measures for rate in (3, 9))


def _tools() -> tuple[Tool, ...]:
    radius = PIPE.radius
    return (
        Tool(
            "longitudinal",
            {r: tuple(longitudinal(r / HOUR, a, FREQUENCY) for a in (2e-3, 4.5e-3, 7e-3)) for r in RATES},
        ),
        Tool("radial", {r: tuple(radial(r / HOUR, q, FREQUENCY) for q in (0.1, 0.35, 0.6)) for r in RATES}),
        Tool(
            "torsional",
            {r: tuple(torsional(r / HOUR, n * RPM, FREQUENCY, radius) for n in (10, 20, 30)) for r in RATES},
        ),
        Tool(
            "three_d",
            {
                r: tuple(
                    three_d(r / HOUR, a, n * RPM, FREQUENCY, radius) for a, n in ((2e-3, 10), (4.5e-3, 20), (7e-3, 30))
                )
                for r in RATES
            },
        ),
        Tool(
            "rocking",
            {r: tuple(rocking(r / HOUR, Rocking(d, 10.0, 0.2), radius) for d in (5.0, 10.0, 15.0)) for r in RATES},
        ),
    )


def _most(runs: dict[str, dict[int, list[SettledCycle]]], attribute: str, measure: str) -> Claim:
    table = {
        name: {rate: [getattr(s, attribute) for s in row] for rate, row in rows.items()} for name, rows in runs.items()
    }
    other_tools = [name for name in table if name != "rocking"]
    beaten = [
        f"{name} at {rate} m/h, setting {k + 1} of 3: {table[name][rate][k]:.4f} against "
        f"{table['rocking'][rate][k]:.4f}"
        for name in other_tools
        for rate in RATES
        for k in range(3)
        if table[name][rate][k] <= table["rocking"][rate][k]
    ]
    overlap = [name for name in other_tools for rate in RATES if min(table[name][rate]) < max(table["rocking"][rate])]
    return Claim(
        f"Rocking reduces axial friction more than every other tool over the field's ranges ({measure}, weakest, "
        "middle and strongest settings each compared at the same rate of penetration).",
        "section 5.3, conclusions",
        {
            "friction_over_coulomb": {
                name: between(v for row in rows.values() for v in row) for name, rows in table.items()
            },
            "tools_that_overlap_with_rocking_at_some_rate": sorted(set(overlap)),
        },
        not beaten,
        "; ".join(beaten),
    )


def _all_reduce(runs: dict[str, dict[int, list[SettledCycle]]]) -> Claim:
    worst = {name: round(max(s.friction_ratio for row in rows.values() for s in row), 4) for name, rows in runs.items()}
    holds = max(worst.values()) < 0.999
    return Claim(
        "All the technologies reduce the axial friction.",
        "conclusions",
        {"largest_friction_over_coulomb": worst},
        holds,
        ""
        if holds
        else "Torsional vibration at its weakest (10 rpm at 15 Hz) moves the surface too little to turn the "
        "deformation at the higher rates of penetration; see the study torsional.",
    )
