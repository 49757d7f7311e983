"""Effects of the string, the top drive, the drawworks, the motor and the bit."""

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
from slider_drilling.units import Quantity, Text, displayed, format_number, sentence

_MIN_MOTOR_CHANGE = 0.005  # a phrase does not mention a smaller share


@dataclass(frozen=True)
class TopDriveBacklash:
    """A dead zone of full width `angle` between drive and string; the string starts in its middle."""

    angle: float = quantity("rad", 0.0, at_least=0.0, at_most=12.6, why="in rad; two turns")


def _top_drive_backlash_phrase(v: Values) -> Text:
    return sentence("There is ", displayed(v["angle"], "rad", 2), " of play between top drive and string")


TOP_DRIVE_BACKLASH = EffectDefinition(
    "top_drive_backlash", "top_drive", TopDriveBacklash, "dead zone between drive and string",
    # The kinks of a dead zone make the cost uneven, so a fit stays near its start.
    search=lambda log: Search(
        (FitParameter("angle", 0.0, 6.3, 0.05),), scan=tuple((0.1 * 2.0 ** (0.5 * k),) for k in range(12))
    ),
    sizes=Sizes(usual={"angle": 0.4}, small={"angle": 0.1}, large={"angle": 0.5}, material={"angle": 0.03}),
    phrase=_top_drive_backlash_phrase,
    draw=lambda random, length, duration: {"angle": random.uniform(0.1, 0.6)},
)  # fmt: skip


@dataclass(frozen=True)
class TorsionalCompliance:
    """The string twists more than its sections say: torsional stiffness ``G J / (1 + extra)``."""

    extra: float = quantity("-", 0.0, at_least=-0.9, at_most=20.0, why="-0.9 is ten times as stiff")


def _torsional_compliance_phrase(v: Values) -> Text:
    more = "more" if v["extra"] > 0.0 else "less"
    return f"The string twists {percent(v['extra'])} {more} under torque than its sections say"


TORSIONAL_COMPLIANCE = EffectDefinition(
    "torsional_compliance", "string", TorsionalCompliance, "G J / (1 + extra)",
    nonphysical="a stiffer string",
    search=lambda log: Search(
        (FitParameter("extra", -0.5, 3.0, 0.02),), scan=((0.05,), (0.15,), (0.5,)), physical=(0.0, np.inf)
    ),
    sizes=Sizes(usual={"extra": 0.12}, small={"extra": 0.04}, large={"extra": 0.13}, material={"extra": 0.02}),
    phrase=_torsional_compliance_phrase,
    draw=lambda random, length, duration: {"extra": random.uniform(0.02, 0.12)},
    # A calibration of friction and stiffness scales a lone torque in the same way.
    visible=lambda channels, off_bottom: list(channels) != ["surface_torque"],
)  # fmt: skip


@dataclass(frozen=True)
class AxialOscillationTool:
    """An agitator pushes the string axially at the measured depth `depth`: ``force sin(2 pi frequency t)``."""

    force: float = quantity("N", 0.0, at_least=0.0, at_most=1e6, why="agitators give 1e+4 to 1e+5")
    frequency: float = quantity("Hz", 15.0, at_least=0.01, at_most=200.0, why="agitators run at 5 to 30")
    depth: float = quantity("m", 0.0, at_least=0.0, at_most=2e4, why="measured depth; the longest wells have 15 km")


def _search_axial_oscillation_tool(log: SearchInputs) -> Search:
    length, frequencies = log.length, log.tool_frequencies
    # Axial waves at tool frequencies are about 300 m long: the response at the surface changes over a fraction of that.
    shares = np.linspace(0.3, 0.96, 12) if frequencies else (0.45, 0.65, 0.85)
    # A spectral line gives the frequency to within one turn of phase over the log.
    frequency_step = 1e-3 if frequencies else 1.0
    return Search(
        (
            FitParameter("force", 0.0, 2e5, 2000.0),
            FitParameter("frequency", 3.0, 40.0, frequency_step, equivalents=tuple(frequencies)),
            FitParameter("depth", 0.0, length, 0.02 * length, 0.7 * length),
        ),
        scan=tuple((4e3, hertz, share * length) for share in shares for hertz in frequencies or (8.0, 16.0)),
        fidelity=1,
    )


def _axial_oscillation_tool_phrase(v: Values) -> Text:
    # Its frequency is left out: it lies above half the sampling rate of most logs, which then show an alias.
    depth: tuple[Text | Quantity, ...] = (", ", Quantity(round(v["depth"]), "m"), " down") if "depth" in v else ()
    return sentence("Something shakes the string with ", displayed(v["force"], "N", 2), *depth)


AXIAL_OSCILLATION_TOOL = EffectDefinition(
    "axial_oscillation_tool", "string", AxialOscillationTool, "force sin(2 pi frequency t) at one depth",
    search=_search_axial_oscillation_tool,
    sizes=Sizes(
        usual={"force": 2e3, "frequency": 15.0, "depth": 0.7}, small={"force": 5e3, "depth": 0.7},
        large={"force": 2e4, "depth": 0.7}, material={"force": 500.0}, length_shares=("depth",),
    ),
    phrase=_axial_oscillation_tool_phrase,
    draw=lambda random, length, duration: {
        "force": random.uniform(2e3, 2e4), "frequency": random.uniform(10.0, 20.0),
        "depth": length * random.uniform(0.6, 0.9),
    },
    # Without hook load the tool looks like less friction.
    visible=lambda channels, off_bottom: "hook_load" in channels,
)  # fmt: skip


@dataclass(frozen=True)
class Heave:
    """The block moves with a wave that no command shows: it is lower by ``amplitude sin(2 pi t / period + phase)``."""

    amplitude: float = quantity("m", 0.0, at_least=0.0, at_most=3.0, why="half of crest to trough")
    period: float = quantity("s", 10.0, at_least=1.0, at_most=600.0, why="waves 3 to 20, tides of a floater more")
    phase: float = quantity("rad", 0.0, at_least=-12.6, at_most=12.6, why="in rad; two turns")


def _heave_to_rig_file(fitted: Values, length: float) -> Values:
    """A wave of negative amplitude is the same wave half a period later."""
    if not fitted.get("amplitude", 0.0) < 0.0:
        return fitted
    phase = (fitted.get("phase", 0.0) + 2.0 * np.pi) % (2.0 * np.pi) - np.pi
    return {**fitted, "amplitude": -fitted["amplitude"], "phase": phase}


def _heave_phrase(v: Values) -> Text:
    period = f" every {format_number(v['period'])} s" if "period" in v else ""
    height = Quantity(abs(v["amplitude"]), "m", 2)
    return sentence("The block moves up and down by ", height, f"{period}, which no command shows")


HEAVE = EffectDefinition(
    "heave", "draw_works", Heave, "block + amplitude sin(2 pi t / period + phase)",
    # The rocking is in the spectrum too, so the period of a peak can be wrong by one per cent, which loses the phase.
    search=lambda log: Search(
        (
            FitParameter("amplitude", -3.0, 3.0, 0.02),
            FitParameter("period", 2.5, 45.0, 0.02),
            FitParameter("phase", -7.0, 7.0, 0.2),
        ),
        scan=tuple(
            (0.05, period * (1.0 + error), phase)
            for period in log.wave_periods[:4]
            for error in (-0.012, -0.006, 0.0, 0.006, 0.012)
            for phase in (0.3, 1.9)
        ),
    ),
    sizes=Sizes(
        usual={"amplitude": 0.08, "period": 10.0}, small={"amplitude": 0.05, "period": 9.0},
        large={"amplitude": 0.2, "period": 11.0},
        material={"amplitude": 0.01},
    ),
    phrase=_heave_phrase,
    draw=lambda random, length, duration: {
        "amplitude": random.uniform(0.02, 0.2), "period": random.uniform(7.0, 14.0),
        "phase": random.uniform(0.0, 2.0 * math.pi),
    },
    # Torque alone shows a wave of the block only through drag.
    visible=lambda channels, off_bottom: "hook_load" in channels or "standpipe_pressure" in channels,
    per_run={"phase": (0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi)},
    to_rig_file=_heave_to_rig_file,
)  # fmt: skip


@dataclass(frozen=True)
class MotorWear:
    """Torque per differential pressure is multiplied by ``1 - torque_loss``; `extra_leak` is added to the motor's leak.

    A motor that leaks more slows more under load.
    """

    torque_loss: float = quantity("-", 0.0, at_least=-1.0, below=1.0, why="a share; 1 leaves none")
    extra_leak: float = quantity("-", 0.0, at_least=-1.0, below=1.0, why="a share of the flow at max_pressure")


def _motor_wear_phrase(v: Values) -> Text:
    loss, leak = v.get("torque_loss", 0.0), v.get("extra_leak", 0.0)
    clauses = []
    if abs(loss) >= _MIN_MOTOR_CHANGE or abs(leak) < _MIN_MOTOR_CHANGE:
        less = "less" if loss >= 0.0 else "more"
        clauses.append(f"gives {percent(loss)} {less} torque per pressure than the file says")
    if abs(leak) >= _MIN_MOTOR_CHANGE:
        clauses.append(f"{'loses' if leak > 0.0 else 'keeps'} {percent(leak)} more of its speed at full pressure")
    return f"The motor {' and '.join(clauses)}"


MOTOR_WEAR = EffectDefinition(
    "motor_wear", "motor", MotorWear, "torque per pressure (1 - torque_loss), leak + extra_leak",
    nonphysical="a motor that gives more torque per pressure",
    search=lambda log: Search(
        (FitParameter("torque_loss", -0.5, 0.8, 0.02), FitParameter("extra_leak", 0.0, 0.8, 0.05)),
        scan=((0.1, 0.05), (0.2, 0.2), (0.1, 0.5)), physical=(0.0, np.inf),
    ),
    sizes=Sizes(
        usual={"torque_loss": 0.28, "extra_leak": 0.2}, small={"torque_loss": 0.1},
        large={"torque_loss": 0.25, "extra_leak": 0.2},
        material={"torque_loss": 0.05, "extra_leak": 0.05},
    ),
    phrase=_motor_wear_phrase,
    draw=lambda random, length, duration: {
        "torque_loss": random.uniform(0.05, 0.3), "extra_leak": random.uniform(0.0, 0.2)
    },
    visible=lambda channels, off_bottom: not off_bottom,
)  # fmt: skip


@dataclass(frozen=True)
class FormationChange:
    """From `time` on, in s since the run began, the rock's depth-of-cut stiffness is multiplied by `factor`."""

    factor: float = quantity("-", 1.0, at_least=0.01, at_most=100.0, why="soft clay to hard stringers")
    time: float = quantity("s", 0.0, at_least=0.0, at_most=1e7, why="since the run began")


def _formation_change_phrase(v: Values) -> Text:
    since = f"From {v['time']:.0f} s on the" if "time" in v else "The"
    return f"{since} rock takes {format_number(v['factor'])} times the weight for the same cut"


FORMATION_CHANGE = EffectDefinition(
    "formation_change", "bit", FormationChange, "rock stiffness times factor from time on",
    search=lambda log: Search(
        (
            FitParameter("factor", 0.15, 6.0, 0.05),
            FitParameter("time", 0.0, log.duration, 0.02 * log.duration, 0.5 * log.duration),
        ),
        scan=tuple((1.4, share * log.duration) for share in (0.15, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85)),
    ),
    sizes=Sizes(
        usual={"factor": 1.4, "time": 150.0}, small={"factor": 0.7, "time": 600.0},
        large={"factor": 2.0, "time": 600.0},
        material={"factor": 0.1},
    ),
    phrase=_formation_change_phrase,
    draw=lambda random, length, duration: {
        "factor": random.uniform(0.6, 2.0), "time": duration * random.uniform(0.3, 0.7)
    },
    visible=lambda channels, off_bottom: not off_bottom,
    per_run={"time": (0.0,)},
    during_run=True,
)  # fmt: skip


@dataclass(frozen=True)
class DriveEffects:
    """The part of the rig file's ``effects`` section on string, drives, motor and bit."""

    top_drive_backlash: TopDriveBacklash = TopDriveBacklash()
    torsional_compliance: TorsionalCompliance = TorsionalCompliance()
    axial_oscillation_tool: AxialOscillationTool = AxialOscillationTool()
    heave: Heave = Heave()
    motor_wear: MotorWear = MotorWear()
    formation_change: FormationChange = FormationChange()


DRIVES_AND_BIT = (
    TOP_DRIVE_BACKLASH, TORSIONAL_COMPLIANCE, AXIAL_OSCILLATION_TOOL, HEAVE, MOTOR_WEAR, FORMATION_CHANGE,
)  # fmt: skip
