"""Study: the three zones of slide drilling on the string (paper section 2.2, Fig. 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.drillstring import Plant
from slider_drilling.drillstring.zones_from_motion import friction_torque, zones_from_motion
from slider_drilling.pages import Chart
from slider_drilling.paper_studies.study import Claim, Study, curve, curve_chart, rounded, setting_name
from slider_drilling.paper_studies.whole_well import ELEMENTS, INTERVAL, slide
from slider_drilling.rig import Rig
from slider_drilling.rig.example import example_rig
from slider_drilling.wellbore.zones import Zones, zones_in_closed_form

RATE = 9.0
PERIOD = 24.0
CYCLES = 8
AMPLITUDES = (2.0, 4.0, 8.0, 12.0, 16.0, 20.0, 26.0)
AGGRESSIVENESS = (0.2, 0.5, 1.0, 1.5)


@dataclass(frozen=True)
class ZoneCase:
    """One settled rocking cycle.

    Attributes:
        surface_torque: Amplitude, N m.
        reactive_torque: N m.
        motion, closed_form: Zones by motion and in closed form.
        depth: m, (n,).
        swing: Rotation, peak to peak, rad, (n,).
        held: Mean torque, N m, (n,).
        tool_face_swing: Peak to peak, rad.
    """

    surface_torque: float
    reactive_torque: float
    motion: Zones
    closed_form: Zones
    depth: np.ndarray
    swing: np.ndarray
    held: np.ndarray
    tool_face_swing: float


def study() -> Study:
    """Rocking amplitude 2-26 rad, and bits from mild to aggressive, on the example rig at 9 m/h."""
    rig = example_rig()
    by_amplitude = [simulate_zones(rig, amplitude) for amplitude in AMPLITUDES]
    by_bit = [simulate_zones(replace(rig, bit=replace(rig.bit, aggressiveness=a)), 12.0) for a in AGGRESSIVENESS]
    torque = [r.surface_torque / 1e3 for r in by_amplitude]
    reactive = [r.reactive_torque / 1e3 for r in by_bit]
    return Study(
        name="zones",
        title="Three zones of slide drilling along the string",
        settings={"rig": "example, 4000 m", "rate_m_per_h": RATE, "period_s": PERIOD, "amplitude_rad": "2 to 26",
                  "bit_aggressiveness": "0.2 to 1.5", "elements": ELEMENTS},
        figures=_figures(by_amplitude, by_bit, torque, reactive),
        claims=(_three(by_amplitude), _deeper(by_amplitude), _stable(by_amplitude), _reactive(by_bit)),
        notes=("By motion: rocked to where rotation swings by more than the pre-sliding 0.16 rad. In closed form: a "
               "torque reaches as far as the friction torque of the pipe above (or below) adds up to it.",),
    )  # fmt: skip


def _figures(
    by_amplitude: list[ZoneCase], by_bit: list[ZoneCase], torque: list[float], reactive: list[float]
) -> tuple[Chart, ...]:
    named = [(setting_name(a, "rad"), case) for a, case in zip(AMPLITUDES, by_amplitude, strict=True)]
    depth = "measured depth, m"
    reached = [
        curve("rocked to, by motion", torque, [r.motion.rocked_to for r in by_amplitude]),
        curve("rocked to, closed form", torque, [r.closed_form.rocked_to for r in by_amplitude], True, 0),
        curve("reactive from, closed form", torque, [r.closed_form.reactive_from for r in by_amplitude], True, 1),
    ]
    held_back = [
        curve("reactive from, closed form", reactive, [r.closed_form.reactive_from for r in by_bit], True, 1),
        curve("rocked to, by motion", reactive, [r.motion.rocked_to for r in by_bit], colour=0),
    ]
    swings = [curve(name, np.maximum(case.swing, 1e-4), case.depth) for name, case in named]
    torques = [curve(name, case.held / 1e3, case.depth) for name, case in named]
    return (
        curve_chart("Reach of the surface torque", "surface torque amplitude, kN m", depth, reached, depth_down=True),
        curve_chart("Reach of the reactive torque (12 rad)", "reactive torque, kN m", depth, held_back,
                    depth_down=True),
        curve_chart("Swing of the string in one cycle", "rotation, peak to peak, rad", depth, swings, log_x=True,
                    depth_down=True),
        curve_chart("Mean torque held in one cycle", "torque, kN m", depth, torques, depth_down=True),
    )  # fmt: skip


def simulate_zones(rig: Rig, amplitude: float) -> ZoneCase:
    commands = slide(rig, CYCLES * PERIOD, RATE, amplitude, PERIOD)
    plant = Plant(rig, ELEMENTS, INTERVAL)
    count = round((CYCLES - 1) * PERIOD / INTERVAL)
    plant.advance(commands.samples(slice(0, count)))
    stride = round(PERIOD / 48.0 / INTERVAL)
    rotation, torque, surface, bit, face = [], [], [], [], []
    for first in range(count, commands.time.size - stride + 1, stride):
        response = plant.advance(commands.samples(slice(first, first + stride)))
        profile = plant.profile()
        rotation.append(profile.rotation)
        torque.append(profile.torque)
        surface += response.surface_torque.tolist()
        bit += response.bit_torque.tolist()
        face += response.tool_face.tolist()
    reactive = float(np.mean(bit))
    amplitude_of_torque = 0.5 * float(np.ptp(surface))
    return ZoneCase(
        surface_torque=amplitude_of_torque,
        reactive_torque=reactive,
        motion=zones_from_motion(profile.measured_depth, np.array(rotation), np.array(torque), reactive),
        closed_form=zones_in_closed_form(
            profile.length, friction_torque(plant, profile), amplitude_of_torque, reactive),
        depth=profile.measured_depth,
        swing=np.ptp(np.array(rotation), axis=0),
        held=np.mean(np.array(torque), axis=0),
        tool_face_swing=float(np.ptp(face)),
    )


def _three(runs: list[ZoneCase]) -> Claim:
    static = [r.closed_form.reactive_from - r.motion.rocked_to for r in runs]
    some = [s > 0.0 for s in static]
    return Claim(
        "There are three zones in slide drilling: surface torque, static friction, bit reactive torque.",
        "section 2.2, Fig. 5",
        {"amplitude_rad": list(AMPLITUDES), "surface_torque_kn_m": rounded((r.surface_torque / 1e3 for r in runs), 2),
         "rocked_to_m": rounded((r.motion.rocked_to for r in runs), 0),
         "reactive_from_m": rounded((r.closed_form.reactive_from for r in runs), 0)},
        any(some),
        "" if all(some) else
        f"There are three zones up to {max((a for a, s in zip(AMPLITUDES, some, strict=True) if s), default=0):g} rad "
        "of rocking; beyond, the rocking reaches the reactive zone and no static zone is left.",
    )  # fmt: skip


def _deeper(runs: list[ZoneCase]) -> Claim:
    depth = [r.motion.rocked_to for r in runs]
    return Claim(
        "A surface torque twists the string down to a maximum depth, which its amplitude sets.", "section 2.2",
        {"surface_torque_kn_m": rounded((r.surface_torque / 1e3 for r in runs), 2), "rocked_to_m": rounded(depth, 0),
         "closed_form_m": rounded((r.closed_form.rocked_to for r in runs), 0)},
        bool(np.all(np.diff(depth) >= 0.0)) and depth[0] < depth[-1],
    )  # fmt: skip


def _stable(runs: list[ZoneCase]) -> Claim:
    swing = [float(np.degrees(r.tool_face_swing)) for r in runs]
    static = [r.closed_form.reactive_from - r.motion.rocked_to > 0.0 for r in runs]
    kept = [s for s, has in zip(swing, static, strict=True) if has]
    return Claim(
        "Friction of the bottom-hole assembly holds the reactive torque and keeps the toolface stable while a static "
        "zone is left.", "section 2.2",
        {"tool_face_change_in_a_cycle_deg": rounded(swing, 2), "static_zone_left": static},
        bool(kept) and max(kept) < 5.0,
        "" if bool(kept) and max(kept) < 5.0 else "The toolface still moves with a static zone; see the "
        "measured values.",
    )  # fmt: skip


def _reactive(runs: list[ZoneCase]) -> Claim:
    reach = [r.closed_form.reactive_from for r in runs]
    return Claim(
        "The reactive torque of the motor is counteracted by friction from the bit upwards.",
        "section 2.2, Fig. 5",
        {"reactive_torque_n_m": rounded((r.reactive_torque for r in runs), 0), "reactive_from_m": rounded(reach, 0)},
        bool(np.all(np.diff(reach) < 0.0)),
    )
