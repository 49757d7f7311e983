"""Study: weight transfer in the slide of a whole well, with and without rocking and with each tool in the string.

This is not in the paper, which stops at one contact. Rocking and the axial tool run in the plant as they are. The plant
has no forcing around the hole and none of the normal force. The radial, torsional and 3-D tools therefore enter as the
friction ratio that the contact alone settles to (signed mean), over 150 m on either side of the tool.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.contact import PAPER
from slider_drilling.drillstring import Commands, Modifiers, Plant, simulate
from slider_drilling.effects import AxialOscillationTool
from slider_drilling.pages import Chart, Panel, Table
from slider_drilling.paper_studies.pipe import Pipe
from slider_drilling.paper_studies.settled_cycle import settled_cycle
from slider_drilling.paper_studies.study import Claim, Study, curve, curve_chart, rounded
from slider_drilling.paper_studies.tool_motions import ToolMotion, radial, three_d, torsional
from slider_drilling.paper_studies.whole_well import ELEMENTS, HOUR, longer, slide
from slider_drilling.rig import Rig
from slider_drilling.rig.example import example_rig
from slider_drilling.units import Quantity, Text, quantities_in, sentence

RATE = 9.0
DURATION = 900.0
REACH = 150.0
"""m either side of a tool; its vibration dies out in the friction of about that much pipe."""
TOOL_FORCE = 20e3
"""N; an axial tool's pressure pulse of 1.6 MPa on its piston of 0.0127 m2."""
TOOL_DEPTH = 3400.0
EXTRA = (0.0, 800.0, 1600.0, 2400.0)
LEAST_HOOK_LOAD = 0.05
"""Of the hanging weight: below it the top of the string must be pushed."""


@dataclass(frozen=True)
class SlideResult:
    """Means over the last quarter of a slide.

    Attributes:
        hook_load, weight_on_bit: N.
        spread: Standard deviation of the weight on bit, N.
        rate_of_penetration: m/s.
        share: Fraction of the weight that is let down and reaches the bit.
    """

    hook_load: float
    weight_on_bit: float
    spread: float
    rate_of_penetration: float
    share: float


def study() -> Study:
    """The example rig at 9 m/h for 900 s: rocking amplitude and period, each tool, tool depth, longer wells."""
    rig = example_rig()
    cases = _cases(rig)
    outcomes = {name: run_slide(rig, *case) for name, case in cases.items()}
    amplitudes = (0.0, 2.0, 5.0, 10.0, 15.0, 20.0, 25.0)
    by_amplitude = [run_slide(rig, slide(rig, DURATION, RATE, a, 24.0)) for a in amplitudes]
    periods = (10.0, 15.0, 24.0, 40.0, 60.0)
    by_period = [run_slide(rig, slide(rig, DURATION, RATE, 15.0, t)) for t in periods]
    depths = (2500.0, 2800.0, 3100.0, 3400.0, 3700.0)
    by_depth = [run_slide(_with_axial_tool(rig, d), slide(rig, DURATION, RATE)) for d in depths]
    reach = {
        name: [_longer_run(rig, extra, name) for extra in EXTRA] for name in ("without", "rocking 20 rad", "axial tool")
    }
    return Study(
        name="weight_transfer",
        title="Weight transfer in the slide of a whole well",
        settings={"rig": "example", "string_m": rig.string.length, "rate_m_per_h": RATE, "duration_s": DURATION,
                  "elements": ELEMENTS, "tool_depth_m": TOOL_DEPTH},
        figures=(
            _chart("Rocking amplitude, period 24 s", "amplitude, rad", amplitudes, by_amplitude),
            _chart(sentence("Rocking period, amplitude ", Quantity(15.0, "rad", 2)), "period, s", periods, by_period),
            _chart(sentence("Depth of the axial tool, ", Quantity(TOOL_FORCE / 1e3, "kN", 2), " at 15 Hz"),
                   "measured depth, m", depths, by_depth),
            _reach_chart(rig, reach),
        ),
        claims=(_transfers(outcomes), _best(outcomes), _amplitude(amplitudes, by_amplitude), _further(rig, reach)),
        notes=(__doc__.split("\n\n", 1)[1].replace("\n", " ").strip(),),
        tables=(_table(outcomes),),
    )  # fmt: skip


def _reach_chart(rig: Rig, reach: dict[str, list[SlideResult]]) -> Chart:
    lengths = [rig.string.length + extra for extra in EXTRA]
    curves = [
        curve(quantities_in(name), lengths, [result.hook_load / 1e3 for result in row]) for name, row in reach.items()
    ]
    level = (LEAST_HOOK_LOAD * _hanging(rig) / 1e3, "5 % of the hanging weight")
    return curve_chart("How far one can still slide", "well length, m", "hook load, kN", curves, level=level)


def _cases(rig: Rig) -> dict[str, tuple]:
    """Commands, rig and local friction ratio of each case."""
    plain = slide(rig, DURATION, RATE)
    radius = Pipe().radius
    motions: dict[str, ToolMotion] = {
        "radial tool, ratio 0.6": radial(RATE / HOUR, 0.6, 15.0),
        "torsional tool, 20 rpm": torsional(RATE / HOUR, 20.0 * math.pi / 30.0, 15.0, radius),
        "3-D tool, 4 mm and 20 rpm": three_d(RATE / HOUR, 4e-3, 20.0 * math.pi / 30.0, 15.0, radius),
    }
    ratios = {name: settled_cycle(motion, Pipe(), PAPER).signed_friction_ratio for name, motion in motions.items()}
    return {
        "without": (plain,),
        "rocking 10 rad": (slide(rig, DURATION, RATE, 10.0, 24.0),),
        "rocking 20 rad": (slide(rig, DURATION, RATE, 20.0, 24.0),),
        "axial tool, 20 kN": (plain, TOOL_DEPTH),
        **{name: (plain, None, ratio) for name, ratio in ratios.items()},
    }


def run_slide(rig: Rig, commands: Commands, axial_tool: float | None = None, ratio: float = 1.0) -> SlideResult:
    """Simulate a slide.

    Args:
        axial_tool: Measured depth of an axial tool, m.
        ratio: Factor of friction within `REACH` of `TOOL_DEPTH`.
    """
    if axial_tool is not None:
        rig = _with_axial_tool(rig, axial_tool)
    modifiers = Modifiers()
    if ratio != 1.0:
        depth = Plant(rig, ELEMENTS).mesh.middle
        modifiers = Modifiers(friction_factor=np.where(np.abs(depth - TOOL_DEPTH) < REACH, ratio, 1.0))
    response = simulate(rig, commands, ELEMENTS, modifiers=modifiers)
    last = response.time > 0.75 * response.time[-1]
    hook, weight = float(np.mean(response.hook_load[last])), response.weight_on_bit[last]
    let_down = response.hook_load[0] - hook
    drilled = float(response.bit_depth[last][-1] - response.bit_depth[last][0])
    return SlideResult(
        hook_load=hook,
        weight_on_bit=float(np.mean(weight)),
        spread=float(np.std(weight)),
        rate_of_penetration=drilled / float(np.ptp(response.time[last])),
        share=float(np.mean(weight) / max(let_down, 1.0)),
    )


def _with_axial_tool(rig: Rig, depth: float) -> Rig:
    tool = AxialOscillationTool(TOOL_FORCE, 15.0, depth)
    return replace(rig, effects=replace(rig.effects, axial_oscillation_tool=tool))


def _longer_run(rig: Rig, extra: float, name: str) -> SlideResult:
    well = longer(rig, extra)
    commands = slide(well, 2.0 * DURATION, RATE, 20.0 if name.startswith("rocking") else 0.0, 24.0)
    # The axial tool keeps its distance from the bit.
    return run_slide(well, commands, TOOL_DEPTH + extra if name.startswith("axial") else None)


def _hanging(rig: Rig) -> float:
    return float(simulate(rig, slide(rig, 1.0, 0.0), ELEMENTS).hook_load[0])


def _chart(title: Text, label: str, x: tuple[float, ...], runs: list[SlideResult]) -> Chart:
    panels = (
        ("hook load, kN", [result.hook_load / 1e3 for result in runs]),
        ("weight on bit, kN", [result.weight_on_bit / 1e3 for result in runs]),
        ("spread of weight on bit, kN", [result.spread / 1e3 for result in runs]),
        ("rate of penetration, m/h", [result.rate_of_penetration * HOUR for result in runs]),
    )
    return Chart(title, label, tuple(Panel(name, (curve("", x, values),)) for name, values in panels))


def _table(outcomes: dict[str, SlideResult]) -> Table:
    header = ("case", "hook load", "weight on bit", "its spread", "rate of penetration", "weight let down that arrives")
    rows = tuple(
        (quantities_in(name), Quantity(o.hook_load / 1e3, "kN", 4), Quantity(o.weight_on_bit / 1e3, "kN"),
         Quantity(o.spread / 1e3, "kN"), Quantity(o.rate_of_penetration * HOUR, "m/h"), f"{100.0 * o.share:.0f} %")
        for name, o in outcomes.items()
    )  # fmt: skip
    return Table(header, rows, "Last quarter of 900 s")


def _transfers(outcomes: dict[str, SlideResult]) -> Claim:
    measured = {"weight_on_bit_kn": {name: round(o.weight_on_bit / 1e3, 2) for name, o in outcomes.items()},
                "share_let_down_that_arrives": {name: round(o.share, 3) for name, o in outcomes.items()}}
    base = outcomes["without"]
    better = {name: o.share > base.share for name, o in outcomes.items() if name != "without"}
    return Claim(
        "Every technology improves the transfer of weight to the bit.",
        "not in the paper for a whole well; conclusions",
        measured, all(better.values()),
        "" if all(better.values()) else "Not better than without: "
        + ", ".join(n for n, ok in better.items() if not ok),
    )  # fmt: skip


def _best(outcomes: dict[str, SlideResult]) -> Claim:
    share = {name: round(o.share, 3) for name, o in outcomes.items()}
    best = max(share, key=lambda name: share[name])
    return Claim("Rocking transfers more weight than any tool in the string.", "conclusions (for one contact)",
                 {"share_let_down_that_arrives": share}, best.startswith("rocking"),
                 "" if best.startswith("rocking") else
                 f"{best} brings {share[best]:.3f} of the weight let down to the bit, rocking at best "
                 f"{max(s for n, s in share.items() if n.startswith('rocking')):.3f}. In the plant the vibration of "
                 "an axial tool hardly dies out along the string, since contacts that only deform take little energy. "
                 "It works far from where it sits; what a real tool loses in mud and couplings is not in the "
                 "model.")  # fmt: skip


def _amplitude(amplitudes: tuple[float, ...], runs: list[SlideResult]) -> Claim:
    hook = [o.hook_load for o in runs]
    return Claim("The larger the rocking amplitude, the less friction holds the string back.",
                 "section 5.3 (for one contact)",
                 {"amplitude_rad": list(amplitudes), "hook_load_kn": rounded((h / 1e3 for h in hook), 1),
                  "weight_on_bit_kn": rounded((o.weight_on_bit / 1e3 for o in runs), 1)},
                 bool(np.all(np.diff([o.share for o in runs]) > -0.01)))  # fmt: skip


def _further(rig: Rig, reach: dict[str, list[SlideResult]]) -> Claim:
    least = LEAST_HOOK_LOAD * _hanging(rig)
    limits = {}
    for name, row in reach.items():
        hook = np.array([o.hook_load for o in row])
        lengths = rig.string.length + np.array(EXTRA)
        below = np.flatnonzero(hook < least)
        if not below.size:
            limits[f"{name}, at least"] = float(lengths[-1])
        elif below[0] == 0:
            limits[f"{name}, at most"] = float(lengths[0])
        else:
            k = int(below[0])
            reach_m = np.interp(least, [hook[k], hook[k - 1]], [lengths[k], lengths[k - 1]])
            limits[name] = round(float(reach_m), 0)
    better = reach["rocking 20 rad"][-1].hook_load > reach["without"][-1].hook_load
    return Claim("Rocking makes longer slides possible.", "not in the paper",
                 {"how_far_m": limits,
                  "hook_load_kn": {name: rounded((o.hook_load / 1e3 for o in row), 1) for name, row in reach.items()}},
                 bool(better))  # fmt: skip
