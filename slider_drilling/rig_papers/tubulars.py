"""Drill pipe, heavy-weight drill pipe and their connections.

Sources: API Spec 5DP, 1st edition, 2009 (sizes, tool joints); API RP 7G, 16th edition, 1998 (connections, strength and
weight formulas of Appendix A); Smith Services Dimensional Data Handbook, 3rd edition, 2002 (heavy-weight drill pipe).
`equipment_tables` says which rows were compared with published text. They are in in, lb/ft and psi as there; functions
take and return these units unless their name says SI.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

GRADES = {"E": 75_000.0, "X": 95_000.0, "G": 105_000.0, "S": 135_000.0}
"""Yield strength of a grade, psi: E-75, X-95, G-105, S-135."""
_TOOL_JOINT_YIELD = 120_000.0  # psi
_MAKE_UP_STRESS = 72_000.0  # psi, 60 % of the yield
_THREAD_FRICTION = 0.08
_JOINT = 29.4  # ft, of pipe between the tool joints in the formula of RP 7G
_STEEL = 3.3996  # lb/ft of a square inch of steel
_UPSET = 0.015  # of the weight of plain pipe: metal of the upsets
PREMIUM_WALL = 0.8
"""Share of the wall that premium class pipe has left, worn from outside."""


@dataclass(frozen=True)
class Connection:
    """A rotary shouldered connection (RP 7G, Appendix A): sizes in in, taper in in/ft.

    Attributes:
        pitch_diameter: At the gauge point (C).
        counterbore: Diameter of the box counterbore (Qc).
        pin_length: Of the pin (Lpc).
        thread_height: Not truncated (H).
        root_truncation: Of the thread (Srs).
        taper: On diameter.
        tong_length: Of pin and box together, without the threads.
    """

    pitch_diameter: float
    counterbore: float
    pin_length: float
    thread_height: float
    root_truncation: float
    taper: float
    tong_length: float


_V038 = (0.216005, 0.038, 2.0)
_V050 = (0.216005, 0.025, 2.0)
CONNECTIONS = {
    "NC26": Connection(2.668, 2.938, 3.0, *_V038, 15.0),
    "NC31": Connection(3.183, 3.453, 3.5, *_V038, 16.0),
    "NC38": Connection(3.808, 4.078, 4.0, *_V038, 17.0),
    "NC40": Connection(4.072, 4.344, 4.5, *_V038, 17.0),
    "NC46": Connection(4.626, 4.906, 4.5, *_V038, 17.0),
    "NC50": Connection(5.0417, 5.3125, 4.5, *_V038, 17.0),
    "5 1/2 FH": Connection(5.591, 5.906, 5.0, *_V050, 18.0),
    "6 5/8 FH": Connection(6.519, 6.844, 5.0, *_V050, 19.0),
}
SAME_CONNECTION = {"2 3/8 IF": "NC26", "2 7/8 IF": "NC31", "3 1/2 IF": "NC38", "4 FH": "NC40", "4 IF": "NC46",
                   "4 1/2 XH": "NC46", "4 1/2 IF": "NC50", "5 XH": "NC50"}  # fmt: skip
"""Older names."""


@dataclass(frozen=True)
class DrillPipe:
    """Drill pipe of one size and nominal weight.

    Attributes:
        outer_diameter, inner_diameter: Of the body, in.
        nominal_weight: The name of the pipe, lb/ft.
        connection: Key of `CONNECTIONS`.
        tool_joints: Outer and inner diameter of the tool joint for grades E, X, G and S, in.
    """

    outer_diameter: float
    nominal_weight: float
    inner_diameter: float
    connection: str
    tool_joints: tuple[tuple[float, float], ...]

    def tool_joint(self, grade: str) -> tuple[float, float]:
        """Outer and inner diameter of a grade's tool joint, in."""
        return self.tool_joints[min(list(GRADES).index(grade), len(self.tool_joints) - 1)]


DRILL_PIPE = (
    DrillPipe(2.375, 6.65, 1.815, "NC26", ((3.375, 1.75),)),
    DrillPipe(2.875, 10.40, 2.151, "NC31", ((4.125, 2.125), (4.125, 2.0), (4.125, 2.0), (4.375, 1.625))),
    DrillPipe(3.5, 13.30, 2.764, "NC38", ((4.75, 2.6875), (5.0, 2.5625), (5.0, 2.4375), (5.0, 2.125))),
    DrillPipe(3.5, 15.50, 2.602, "NC38", ((5.0, 2.5625), (5.0, 2.4375), (5.0, 2.125))),
    DrillPipe(4.0, 14.00, 3.340, "NC40", ((5.25, 2.8125), (5.25, 2.6875), (5.5, 2.4375), (5.5, 2.0))),
    DrillPipe(4.0, 15.70, 3.240, "NC40", ((5.25, 2.6875), (5.5, 2.4375), (5.5, 2.0))),
    DrillPipe(4.5, 16.60, 3.826, "NC46", ((6.25, 3.25), (6.25, 3.0), (6.25, 3.0), (6.25, 2.75))),
    DrillPipe(4.5, 20.00, 3.640, "NC46", ((6.25, 3.0), (6.25, 2.75), (6.25, 2.5), (6.25, 2.25))),
    DrillPipe(5.0, 19.50, 4.276, "NC50", ((6.625, 3.75), (6.625, 3.5), (6.625, 3.25), (6.625, 2.75))),
    DrillPipe(5.0, 25.60, 4.000, "NC50", ((6.625, 3.5), (6.625, 3.0), (6.625, 2.75))),
    DrillPipe(5.5, 21.90, 4.778, "5 1/2 FH", ((7.0, 4.0), (7.0, 3.75), (7.25, 3.5), (7.5, 3.0))),
    DrillPipe(5.5, 24.70, 4.670, "5 1/2 FH", ((7.0, 4.0), (7.25, 3.5), (7.25, 3.5), (7.5, 3.0))),
    DrillPipe(6.625, 25.20, 5.965, "6 5/8 FH", ((8.0, 5.0), (8.0, 5.0), (8.25, 4.75), (8.5, 4.25))),
    DrillPipe(6.625, 27.70, 5.901, "6 5/8 FH", ((8.0, 5.0), (8.25, 4.75), (8.25, 4.75), (8.5, 4.25))),
)


@dataclass(frozen=True)
class HeavyWeightPipe:
    """Heavy-weight drill pipe: sizes in in, weight with tool joints in lb/ft."""

    outer_diameter: float
    inner_diameter: float
    weight: float
    connection: str
    tool_joint: tuple[float, float]


HEAVY_WEIGHT_PIPE = (
    HeavyWeightPipe(3.5, 2.0625, 25.3, "NC38", (4.75, 2.1875)),
    HeavyWeightPipe(4.0, 2.5625, 29.7, "NC40", (5.25, 2.6875)),
    HeavyWeightPipe(4.5, 2.75, 41.0, "NC46", (6.25, 2.875)),
    HeavyWeightPipe(5.0, 3.0, 49.3, "NC50", (6.5, 3.0625)),
    HeavyWeightPipe(5.5, 3.375, 57.0, "5 1/2 FH", (7.0, 3.5)),
    HeavyWeightPipe(6.625, 4.5, 70.8, "6 5/8 FH", (8.0, 4.625)),
)


def find_drill_pipe(outer_diameter: float, nominal_weight: float | None) -> DrillPipe | None:
    """The pipe of this size (in) and nominal weight (lb/ft; None: the only or the lighter one of the size)."""
    found = [pipe for pipe in DRILL_PIPE if abs(pipe.outer_diameter - outer_diameter) < 0.02]
    if nominal_weight is not None:
        found = [pipe for pipe in found if abs(pipe.nominal_weight - nominal_weight) < 0.15]
    return found[0] if found else None


def find_heavy_weight_pipe(outer_diameter: float) -> HeavyWeightPipe | None:
    """The heavy-weight drill pipe of this size, in."""
    return next((pipe for pipe in HEAVY_WEIGHT_PIPE if abs(pipe.outer_diameter - outer_diameter) < 0.02), None)


def tool_joint_yield(connection: Connection, outer: float, inner: float) -> float:
    """Torque that makes a tool joint yield, ft lbf (RP 7G, A.8.2): of pin or box, whichever is weaker.

    Args:
        connection: Its thread.
        outer, inner: Diameters of the tool joint, in.
    """
    taper = connection.taper / 12.0
    pin_loss = 2.0 * (connection.thread_height / 2.0 - connection.root_truncation) + taper / 8.0
    pin = math.pi / 4.0 * ((connection.pitch_diameter - pin_loss) ** 2 - inner**2)
    box = math.pi / 4.0 * (outer**2 - (connection.counterbore - 0.375 * taper) ** 2)
    mean_radius = (2.0 * connection.pitch_diameter - (connection.pin_length - 0.625) * taper) / 4.0
    shoulder_radius = (outer + connection.counterbore) / 4.0
    lever = 0.25 / (2.0 * math.pi) + _THREAD_FRICTION * (mean_radius / math.cos(math.radians(30.0)) + shoulder_radius)
    return _TOOL_JOINT_YIELD * min(pin, box) / 12.0 * lever


def make_up_torque(connection: Connection, outer: float, inner: float) -> float:
    """Recommended make-up torque of a new tool joint, ft lbf: at 60 % of its yield."""
    return _MAKE_UP_STRESS / _TOOL_JOINT_YIELD * tool_joint_yield(connection, outer, inner)


def torsional_yield(outer: float, inner: float, yield_strength: float) -> float:
    """Torque that makes a pipe's body (diameters in in) of this yield strength (psi) yield, ft lbf (RP 7G, A.9)."""
    return 0.096167 * math.pi / 32.0 * (outer**4 - inner**4) * yield_strength / outer


def premium_outer_diameter(outer: float, inner: float) -> float:
    """Outer diameter of premium class pipe, in."""
    return inner + PREMIUM_WALL * (outer - inner)


def adjusted_weight(pipe: DrillPipe, grade: str) -> float:
    """Weight with tool joints, lb/ft (RP 7G, Appendix A, with 1.5 % for the upsets)."""
    plain = _STEEL * math.pi / 4.0 * (pipe.outer_diameter**2 - pipe.inner_diameter**2) * (1.0 + _UPSET)
    outer, inner = pipe.tool_joint(grade)
    length = CONNECTIONS[pipe.connection].tong_length
    upset = pipe.outer_diameter + 0.125
    joint = 0.222 * length * (outer**2 - inner**2) + 0.167 * (outer**3 - upset**3)
    joint -= 0.501 * inner**2 * (outer - upset)
    return (plain * _JOINT + joint) / (_JOINT + (length + 2.253 * (outer - upset)) / 12.0)
