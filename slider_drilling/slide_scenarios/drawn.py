"""Random slides: the rig that the controller knows, the true rig, and the losses of the MWD."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.blind.foreign.structure import draw_structure
from slider_drilling.blind.wells import DEFAULT_WELLS, WELLS
from slider_drilling.effects import EFFECTS, Effects, effects_with
from slider_drilling.rig import Rig, Sensors, check_rig
from slider_drilling.slide_scenarios.scenario import Scenario

DURATION_S = 900.0
_ONE_EFFECT, _TWO_EFFECTS = 0.4, 0.2  # shares of slides with one and with two effects

Random = np.random.Generator


def draw_slide(
    number: int, seed: int, base: Rig, duration: float = DURATION_S, effects: Sequence[str] = tuple(sorted(EFFECTS)),
    foreign: bool = False,
) -> Scenario:  # fmt: skip
    """Returns a random slide of a closed-loop campaign.

    The true rig differs from the rig file of the controller in friction of cased and open hole, damping, compliance,
    motor, rock, survey and circulation pressure. The controller does not know the twist at the start, MWD samples that
    are lost or wrong, and effects of the catalogue. It knows the noise and the MWD's period, which differ between
    slides.

    Args:
        number: Of the slide.
        seed: Of the campaign.
        base: Rig that wells, string and fluids are drawn from.
        duration: In s.
        effects: Those that the true rig may have.
        foreign: Whether plant and instruments have a foreign structure, which is drawn as well.

    Raises:
        InputError: A rig near the base is not valid.
    """
    # The order of the draws defines the slides of a seed.
    random = np.random.default_rng((seed, number))
    nominal = _nominal_rig(random, base)
    present, names = _effects(random, nominal, duration, effects)
    truth = replace(_true_rig(random, nominal), effects=present)
    target = float(random.uniform(-180.0, 180.0))
    return Scenario(
        name=f"slide {number}", well=f"{nominal.string.length / 1e3:.1f} km", about=", ".join(names) or "no effect",
        targets=((0.0, target),), duration=duration, start_twist=float(random.uniform(-6.0, 6.0)),
        mwd_lost=float(random.uniform(0.0, 0.2)), mwd_outliers=float(random.choice([0.0, 0.02, 0.05])),
        rigs=(check_rig(nominal), check_rig(truth)),
        structure=draw_structure(np.random.default_rng((seed, number, 7))) if foreign else None,
    )  # fmt: skip


def _nominal_rig(random: Random, base: Rig) -> Rig:
    rig = WELLS[str(random.choice(DEFAULT_WELLS))](random, base)
    sensors = rig.sensors
    mwd = replace(sensors.mwd, period=float(random.choice([8.0, 12.0, 20.0, 30.0])))
    return replace(rig, sensors=replace(_with_other_noise(random, sensors), mwd=mwd))


def _with_other_noise(random: Random, sensors: Sensors) -> Sensors:
    torque, hook, pressure = (
        replace(sensor, noise=_perturbed(random, sensor.noise, 0.4))
        for sensor in (sensors.surface_torque, sensors.hook_load, sensors.standpipe_pressure)
    )
    return replace(sensors, surface_torque=torque, hook_load=hook, standpipe_pressure=pressure)


def _true_rig(random: Random, rig: Rig) -> Rig:
    well, string, common = rig.well, rig.string, float(np.exp(random.normal(0.0, 0.15)))
    intervals = tuple(
        replace(interval, factor=_perturbed(random, common * interval.factor, 0.1))
        for interval in well.friction_intervals
    )
    survey = tuple(
        (depth, float(np.clip(inclination + random.normal(0.0, 0.4), 0.0, 120.0)), azimuth + random.normal(0.0, 0.8))
        if inclination > 0.0 else (depth, inclination, azimuth)
        for depth, inclination, azimuth in well.survey
    )  # fmt: skip
    return replace(
        rig,
        well=replace(well, friction_intervals=intervals, survey=survey),
        string=replace(
            string, axial_damping=_perturbed(random, string.axial_damping, 0.4),
            torsional_damping=_perturbed(random, string.torsional_damping, 0.4),
            shear_modulus=_perturbed(random, string.shear_modulus, 0.03),
        ),
        bit=replace(
            rig.bit, aggressiveness=_perturbed(random, rig.bit.aggressiveness, 0.1),
            depth_of_cut_stiffness=_perturbed(random, rig.bit.depth_of_cut_stiffness, 0.25),
        ),
        motor=replace(rig.motor, torque_per_pressure=_perturbed(random, rig.motor.torque_per_pressure, 0.05)),
        hydraulics=replace(
            rig.hydraulics, reference_pressure=_perturbed(random, rig.hydraulics.reference_pressure, 0.01)
        ),
    )  # fmt: skip


def _perturbed(random: Random, value: float, spread: float) -> float:
    """Returns a log-normal value; spread is the standard deviation of its logarithm."""
    return value * float(np.exp(random.normal(0.0, spread)))


def _effects(random: Random, rig: Rig, duration: float, among: Sequence[str]) -> tuple[Effects, list[str]]:
    chance = random.uniform()
    count = 2 if chance < _TWO_EFFECTS else 1 if chance < _TWO_EFFECTS + _ONE_EFFECT else 0
    names = [str(name) for name in random.choice(among, size=min(count, len(among)), replace=False)] if among else []
    return effects_with(**{name: EFFECTS[name].draw(random, rig.string.length, duration) for name in names}), names
