"""Effects at the contact between string and hole. mu is the friction of the contact model at a place."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slider_drilling.effects.definition import (
    EffectDefinition,
    FitParameter,
    Search,
    SearchInputs,
    Sizes,
    Values,
    percent,
)
from slider_drilling.schema.fields import quantity
from slider_drilling.units import Quantity, Text, format_number, sentence


@dataclass(frozen=True)
class Stribeck:
    """Friction falls with the slip speed v: ``mu (1 + drop exp(-v / speed))``."""

    drop: float = quantity("-", 0.0, above=-1.0, at_most=10.0, why="a share of friction; -1 leaves none")
    speed: float = quantity("m/s", 0.05, at_least=1e-4, at_most=10.0, why="slip at which it fades: mm/s to m/s")


def _stribeck_phrase(v: Values) -> Text:
    more = "higher" if v["drop"] > 0.0 else "lower"
    change = f"Friction of a string that hardly moves is {percent(v['drop'])} {more} than of one that slides fast"
    if "speed" not in v:
        return change
    return sentence(change, " (it changes around ", Quantity(v["speed"], "m/s", 2), ")")


STRIBECK = EffectDefinition(
    "stribeck", "contact", Stribeck, "mu (1 + drop exp(-v / speed))",
    nonphysical="friction that rises with slip speed",
    # A fit of stick-slip stays near its start: half the speed or twice the drop shifts the phase too far to recover.
    search=lambda log: Search(
        (FitParameter("drop", -0.6, 4.0, 0.05), FitParameter("speed", 0.004, 1.0, 0.01)),
        scan=tuple((drop, speed) for drop in (0.25, 0.5, 1.0, 2.0) for speed in (0.015, 0.03, 0.06, 0.12, 0.3)),
        physical=(0.0, np.inf),
    ),
    sizes=Sizes(usual={"drop": 0.3, "speed": 0.05}, small={"drop": 0.2}, large={"drop": 0.6}, material={"drop": 0.05}),
    phrase=_stribeck_phrase,
    draw=lambda random, length, duration: {"drop": random.uniform(0.1, 0.5), "speed": random.uniform(0.02, 0.1)},
)  # fmt: skip


@dataclass(frozen=True)
class ViscousDrag:
    """Mud drags at the pipe with ``coefficient v`` per metre, axially and, at the pipe's radius, tangentially."""

    coefficient: float = quantity("N s/m2", 0.0, at_least=0.0, at_most=1e4, why="a metre of string: water 1, mud 100")


def _viscous_drag_phrase(v: Values) -> Text:
    return f"The mud drags at the moving pipe: {format_number(v['coefficient'])} N s/m2"


VISCOUS_DRAG = EffectDefinition(
    "viscous_drag", "contact", ViscousDrag, "coefficient v per metre, axial and tangential",
    search=lambda log: Search((FitParameter("coefficient", 0.0, 300.0, 2.0),), scan=((5.0,), (20.0,), (60.0,))),
    sizes=Sizes(
        usual={"coefficient": 25.0}, small={"coefficient": 5.0}, large={"coefficient": 25.0},
        material={"coefficient": 1.0},
    ),
    phrase=_viscous_drag_phrase,
    draw=lambda random, length, duration: {"coefficient": random.uniform(2.0, 30.0)},
)  # fmt: skip


@dataclass(frozen=True)
class StaticAging:
    """Friction grows while a contact rests: ``mu (1 + growth (1 - exp(-t_rest / time)))``.

    A contact rests while it moves slower than `rest_speed`: axial drilling creep is rest, rocking is not. Once it
    moves, the rest time is forgotten over `slip_distance` of travel.
    """

    growth: float = quantity("-", 0.0, above=-1.0, at_most=10.0, why="a share of friction; -1 leaves none")
    time: float = quantity("s", 5.0, at_least=1e-2, at_most=1e5, why="of rest: seconds to hours")
    rest_speed: float = quantity("m/s", 0.01, at_least=1e-5, at_most=1.0, why="below rocking, above drilling creep")
    slip_distance: float = quantity("m", 0.005, at_least=1e-5, at_most=100.0, why="asperities to turns of pipe")


_GROWTH = FitParameter("growth", -0.6, 6.0, 0.05)
def _static_aging_phrase(v: Values) -> Text:
    grows = "grows" if v["growth"] > 0.0 else "falls"
    within = f", within about {format_number(v['time'], 2)} s" if "time" in v else ""
    return f"Friction {grows} by {percent(v['growth'])} while the string rests{within}"


STATIC_AGING = EffectDefinition(
    "static_aging", "contact", StaticAging, "mu (1 + growth (1 - exp(-t_rest / time)))",
    nonphysical="friction that falls while the contact rests",
    search=lambda log: Search(
        (_GROWTH, FitParameter("time", 0.3, 150.0, 2.0)),
        scan=tuple((growth, time) for growth in (0.3, 1.2) for time in (1.0, 5.0, 20.0, 60.0)),
        physical=(0.0, np.inf),
    ),
    sizes=Sizes(
        usual={"growth": 0.5, "time": 5.0}, small={"growth": 0.2}, large={"growth": 0.6},
        material={"growth": 0.1},
    ),
    phrase=_static_aging_phrase,
    draw=lambda random, length, duration: {"growth": random.uniform(0.1, 0.6), "time": random.uniform(2.0, 20.0)},
)  # fmt: skip
STICK_SLIP_AGING_SEARCH = Search(
    (_GROWTH, FitParameter("time", 0.3, 150.0, 1.0), FitParameter("slip_distance", 0.002, 4.0, 0.05)),
    scan=((0.5, 2.0, 0.01), (0.5, 10.0, 0.01), (0.5, 5.0, 0.3), (1.0, 10.0, 1.0)),
    physical=(0.0, np.inf), fidelity=1,
)  # fmt: skip
"""Search for `static_aging` in stick-slip, with the slip distance free.

While rocking, a few millimetres cannot be distinguished from none. In stick-slip each cycle ends in a short rest, and
this distance decides whether the string keeps sticking. The phase depends on the mesh too: the coarsest mesh is wrong
by a cycle now and then.
"""


@dataclass(frozen=True)
class BucklingContact:
    """Compressed pipe (T < 0) presses on the wall with ``factor r T^2 / (4 E I)`` per metre, r the radial clearance."""

    factor: float = quantity("-", 0.0, at_least=0.0, at_most=20.0, why="1 is a full helix")


def _buckling_contact_phrase(v: Values) -> Text:
    return f"Compressed pipe presses on the wall with {format_number(v['factor'])} times the force of a helix"


BUCKLING_CONTACT = EffectDefinition(
    "buckling_contact", "contact", BucklingContact, "side force + factor r T^2 / (4 E I) for T < 0",
    search=lambda log: Search((FitParameter("factor", 0.0, 20.0, 0.2),), scan=((0.5,), (1.0,), (4.0,))),
    sizes=Sizes(usual={"factor": 1.5}, small={"factor": 0.3}, large={"factor": 1.0}, material={"factor": 0.1}),
    phrase=_buckling_contact_phrase,
    draw=lambda random, length, duration: {"factor": random.uniform(0.5, 2.0)},
)  # fmt: skip


@dataclass(frozen=True)
class CuttingsBed:
    """Friction is multiplied by `factor` between the measured depths `top` and `bottom`; both must be given."""

    factor: float = quantity("-", 1.0, at_least=0.0, at_most=20.0, why="a multiple of the contact's own friction")
    top: float = quantity("m", 0.0, at_least=0.0, at_most=2e4, why="measured depth; the longest wells have 15 km")
    bottom: float = quantity("m", 0.0, at_least=0.0, at_most=2e4, why="measured depth; the longest wells have 15 km")


def _search_cuttings_bed(log: SearchInputs) -> Search:
    """Frees the excess of friction over the whole bed, the middle and the length of the bed.

    A log determines the excess best, the length least, and the middle hardly at all.
    """
    length = log.length
    narrow = [(0.6 * 0.12 * length, (0.21 + 0.1 * k) * length, 0.12 * length) for k in range(8)]
    wide = [(0.4 * 0.25 * length, (share + 0.125) * length, 0.25 * length) for share in (0.25, 0.45, 0.7)]
    return Search(
        (
            FitParameter("excess", -0.15 * length, length, 0.02 * length, 0.0, "m"),
            FitParameter("middle", 0.0, length, 0.01 * length, 0.6 * length, "m"),
            FitParameter("length", 0.03 * length, 0.6 * length, 0.03 * length, 0.2 * length, "m"),
        ),
        scan=(*narrow, *wide), physical=(0.0, np.inf),
    )  # fmt: skip


def _cuttings_bed_to_rig_file(fitted: Values, length: float) -> Values:
    if "excess" not in fitted:
        return fitted
    middle, long = fitted.get("middle", 0.6 * length), fitted.get("length", 0.2 * length)
    return {
        "factor": float(np.clip(1.0 + fitted["excess"] / long, 0.2, 20.0)),
        "top": max(middle - 0.5 * long, 0.0),
        "bottom": min(middle + 0.5 * long, length),
    }


def _draw_cuttings_bed(random: np.random.Generator, length: float, duration: float) -> dict[str, float]:
    middle, half = length * random.uniform(0.5, 0.85), random.uniform(60.0, 200.0)
    return {"factor": random.uniform(1.3, 2.5), "top": middle - half, "bottom": middle + half}


def _cuttings_bed_phrase(v: Values) -> Text:
    top, bottom = (Quantity(round(v[end]), "m") for end in ("top", "bottom"))
    factor = format_number(v["factor"])
    return sentence(f"Something makes friction {factor} times as high between ", top, " and ", bottom)


CUTTINGS_BED = EffectDefinition(
    "cuttings_bed", "contact", CuttingsBed, "factor mu from top to bottom",
    nonphysical="less friction over one depth interval",
    search=_search_cuttings_bed,
    sizes=Sizes(
        usual={"factor": 1.9, "top": 0.65, "bottom": 0.8}, small={"factor": 1.8, "top": 0.64, "bottom": 0.72},
        large={"factor": 3.5, "top": 0.64, "bottom": 0.72}, material={"factor": 0.2}, length_shares=("top", "bottom"),
    ),
    phrase=_cuttings_bed_phrase,
    draw=_draw_cuttings_bed,
    to_rig_file=_cuttings_bed_to_rig_file,
    reported=lambda length: (
        FitParameter("factor", 0.2, 20.0, 0.1),
        FitParameter("top", 0.0, length, 0.01 * length, 0.5 * length),
        FitParameter("bottom", 0.0, length, 0.01 * length, 0.7 * length),
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Tortuosity:
    """Local curvature that no survey shows adds ``|T| curvature`` of side force per metre in the open hole.

    The open hole is the last friction interval of the well.
    """

    curvature: float = quantity("rad/m", 0.0, at_least=0.0, at_most=0.2, why="1 degree per 30 m is 6e-4")


def _tortuosity_phrase(v: Values) -> Text:
    degrees = Quantity(math.degrees(v["curvature"]) * 30.0, "deg/30 m", 2)
    return sentence("The open hole is more crooked than the survey shows, by ", degrees)


TORTUOSITY = EffectDefinition(
    "tortuosity", "contact", Tortuosity, "side force + |T| curvature in the open hole",
    search=lambda log: Search((FitParameter("curvature", 0.0, 0.02, 1e-4),), scan=((2e-4,), (8e-4,), (3e-3,))),
    sizes=Sizes(
        usual={"curvature": 6e-4}, small={"curvature": 2e-4}, large={"curvature": 8e-4},
        material={"curvature": 1e-4},
    ),
    phrase=_tortuosity_phrase,
    draw=lambda random, length, duration: {"curvature": random.uniform(1e-4, 1e-3)},
)  # fmt: skip


@dataclass(frozen=True)
class FrictionDrift:
    """Friction changes steadily with the time t since the run began: ``mu (1 + rate t)``."""

    rate: float = quantity("1/s", 0.0, at_least=-0.1, at_most=0.1, why="by a share of friction each second: 1e-4")


def _friction_drift_phrase(v: Values) -> Text:
    return f"Friction {'rises' if v['rate'] > 0.0 else 'falls'} by {percent(60.0 * v['rate'])} per minute"


FRICTION_DRIFT = EffectDefinition(
    "friction_drift", "contact", FrictionDrift, "mu (1 + rate t)",
    search=lambda log: Search((FitParameter("rate", -2e-3, 1e-2, 5e-5),), scan=((3e-4,), (-3e-4,), (1.5e-3,))),
    sizes=Sizes(usual={"rate": 4e-4}, small={"rate": 1e-4}, large={"rate": 4e-4}, material={"rate": 0.02 / 60.0}),
    phrase=_friction_drift_phrase,
    draw=lambda random, length, duration: {"rate": random.uniform(-0.2, 0.4) / duration},
    during_run=True,
)  # fmt: skip


@dataclass(frozen=True)
class ContactEffects:
    """The contact's part of the rig file's ``effects`` section."""

    stribeck: Stribeck = Stribeck()
    viscous_drag: ViscousDrag = ViscousDrag()
    static_aging: StaticAging = StaticAging()
    buckling_contact: BucklingContact = BucklingContact()
    cuttings_bed: CuttingsBed = CuttingsBed()
    tortuosity: Tortuosity = Tortuosity()
    friction_drift: FrictionDrift = FrictionDrift()


# In the order in which a diagnosis tries them.
CONTACT = (STRIBECK, VISCOUS_DRAG, STATIC_AGING, BUCKLING_CONTACT, FRICTION_DRIFT, TORTUOSITY, CUTTINGS_BED)
