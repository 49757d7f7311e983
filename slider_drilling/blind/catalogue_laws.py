"""The laws of the catalogue's effects in sealed logs.

Most differ in form from the law that the diagnosis fits, so that a sealed log does not repeat the model that is tested
on it. An effect without another form here has the registry's law, its amplitude scaled by the size.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.blind.plant_law import SLOW_UPDATE_S, LawFactory, OperatingPoint, PlantLaw
from slider_drilling.drillstring import Commands, Response
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.effects import EFFECTS, EffectDefinition
from slider_drilling.rig import Rig


def registry_law(definition: EffectDefinition) -> LawFactory:
    """Returns the effect's own law; size 1 is its usual size, size 0 is neutral."""

    def make(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
        values = definition.sizes.values("usual", rig.string.length)
        amplitude = next(iter(values))
        neutral = getattr(definition.section(), amplitude)
        values[amplitude] = neutral + size * (values[amplitude] - neutral)
        return _constant(definition.name, definition.site, **values)

    return make


def _constant(name: str, site: str, **values: float) -> PlantLaw:
    by_name = {f"{name}.{key}": value for key, value in values.items()}
    return PlantLaw(name, site, True, values=lambda at: by_name)


def stribeck(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a Stribeck law with a little mud drag, which the catalogue's law does not have."""
    values = {
        "stribeck.drop": 0.3 * size,
        "stribeck.speed": generator.uniform(0.02, 0.12),
        "viscous_drag.coefficient": 0.3,
    }
    return PlantLaw("stribeck", "contact", True, values=lambda at: values)


def viscous_drag(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns the drag of a mud that thins a little while it is stirred."""

    def values(at: OperatingPoint) -> dict[str, float]:
        return {"viscous_drag.coefficient": 25.0 * size * (1.0 - 0.0003 * at.time)}

    return PlantLaw("viscous_drag", "contact", True, values=values, update_interval=SLOW_UPDATE_S)


def static_aging(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns aging with another rest speed and another slip distance."""
    return _constant("static_aging", "contact", growth=0.5 * size, time=generator.uniform(2.0, 15.0),
                   rest_speed=0.008, slip_distance=0.008)  # fmt: skip


def buckling_contact(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns buckling in a hole that is 5 % wider than the rig file states."""
    law = _constant("buckling_contact", "contact", factor=1.5 * size)
    return replace(
        law, change_rig=lambda r, at: replace(r, well=replace(r.well, hole_diameter=1.05 * r.well.hole_diameter))
    )


def cuttings_bed(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a cuttings bed with sloping ends."""
    length = rig.string.length
    middle, half = length * generator.uniform(0.55, 0.85), length * generator.uniform(0.04, 0.08)

    def friction(depth: Array) -> Array:
        return 1.0 + 0.9 * size * np.clip((half + 40.0 - np.abs(depth - middle)) / 80.0, 0.0, 1.0)

    return PlantLaw("cuttings_bed", "contact", True, friction=friction, depth_interval=(middle - half, middle + half))


def tortuosity(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns curvature that varies along the open hole."""
    top = rig.well.friction_intervals[0].to

    def curvature(depth: Array) -> Array:
        return np.where(depth > top, 6e-4 * size * (1.0 + 0.5 * np.sin(2.0 * np.pi * depth / 90.0)), 0.0)

    return PlantLaw("tortuosity", "contact", True, curvature=curvature)


def friction_drift(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a drift of friction that slows down."""

    def values(at: OperatingPoint) -> dict[str, float]:
        factor = 1.0 + 0.2 * size * (1.0 - np.exp(-at.time / 500.0))
        return {"friction_drift.rate": (factor - 1.0) / max(at.time, 1.0)}

    return PlantLaw("friction_drift", "contact", True, values=values, update_interval=SLOW_UPDATE_S)


def top_drive_backlash(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a dead zone that widens a little during the run."""

    def values(at: OperatingPoint) -> dict[str, float]:
        return {"top_drive_backlash.angle": 0.4 * size * (1.0 + 0.0003 * at.time)}

    return PlantLaw("top_drive_backlash", "top_drive", True, values=values, update_interval=SLOW_UPDATE_S)


def torsional_compliance(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a lower shear modulus: the compliance changes and nothing else does."""
    soft = 1.0 / (1.0 + 0.12 * size)

    def change(r: Rig, at: OperatingPoint) -> Rig:
        return replace(r, string=replace(r.string, shear_modulus=soft * r.string.shear_modulus))

    return PlantLaw("torsional_compliance", "string", True, change_rig=change)


def axial_oscillation_tool(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns an agitator whose frequency partly follows the flow."""
    depth, hertz = rig.string.length * generator.uniform(0.6, 0.85), generator.uniform(10.0, 18.0)

    def values(at: OperatingPoint) -> dict[str, float]:
        return {"axial_oscillation_tool.force": 2e3 * size, "axial_oscillation_tool.depth": depth,
                "axial_oscillation_tool.frequency": hertz * (0.6 + 0.4 * at.flow)}  # fmt: skip

    return PlantLaw("axial_oscillation_tool", "string", True, values=values, update_interval=SLOW_UPDATE_S)


def heave(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a wave with a second harmonic of a tenth of its amplitude."""
    omega, phase = 2.0 * np.pi / generator.uniform(7.0, 14.0), generator.uniform(0.0, 6.0)

    def true_motion(commands: Commands) -> Commands:
        wave = 0.08 * size * (np.sin(omega * commands.time + phase) + 0.1 * np.sin(2.0 * omega * commands.time))
        rate = np.gradient(wave, commands.time)
        return replace(commands, block_position=commands.block_position + wave, block_speed=commands.block_speed + rate)

    return PlantLaw("heave", "draw_works", True, change_commands=true_motion)


def motor_wear(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns motor wear whose leak grows during the run."""

    def values(at: OperatingPoint) -> dict[str, float]:
        return {"motor_wear.torque_loss": min(0.28 * size, 0.8),
                "motor_wear.extra_leak": min(0.2 * size * (1.0 + 0.001 * at.time), 0.6)}  # fmt: skip

    return PlantLaw("motor_wear", "motor", True, values=values, update_interval=SLOW_UPDATE_S)


def formation_change(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a formation boundary that the bit takes 16 s to cross."""
    start_share = generator.uniform(0.25, 0.75)

    def values(at: OperatingPoint) -> dict[str, float]:
        share = float(np.clip((at.time - start_share * at.duration + 8.0) / 16.0, 0.0, 1.0))
        return {"formation_change.factor": 1.0 + 0.4 * size * share}

    return PlantLaw("formation_change", "bit", True, values=values, update_interval=SLOW_UPDATE_S)


def torque_sensor_gain(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a gain error that gets smaller towards large torques."""

    def read(response: Response) -> Response:
        torque = response.surface_torque
        return replace(response, surface_torque=torque * (1.0 + 0.2 * size / (1.0 + np.abs(torque) / 2e5)))

    return PlantLaw("torque_sensor_gain", "sensor", True, change_response=read)


def torque_sensor_lag(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns two equal first-order lags in series."""

    def read(response: Response) -> Response:
        torque, share = response.surface_torque, 1.0 - np.exp(-0.1 / (0.25 * size))
        for _ in range(2):
            out = np.empty_like(torque)
            level = torque[0]
            for k, value in enumerate(torque):
                level += share * (value - level)
                out[k] = level
            torque = out
        return replace(response, surface_torque=torque)

    return PlantLaw("torque_sensor_lag", "sensor", True, change_response=read)


def torque_sensor_bias(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a bias that drifts by 2.5 % of itself in 100 s."""

    def read(response: Response) -> Response:
        return replace(response, surface_torque=response.surface_torque + 500.0 * size * (1.0 + response.time / 4000.0))

    return PlantLaw("torque_sensor_bias", "sensor", True, change_response=read)


def torque_at_motor(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a drive whose friction falls while its gears warm up."""

    def values(at: OperatingPoint) -> dict[str, float]:
        warm_up = 1.0 - 0.3 * (1.0 - np.exp(-at.time / 200.0))
        return {"torque_at_motor.inertia": 900.0 * size, "torque_at_motor.friction": 200.0 * size * warm_up}

    return PlantLaw("torque_at_motor", "top_drive", True, values=values, update_interval=SLOW_UPDATE_S)


_OTHER_FORMS: dict[str, LawFactory] = {
    make.__name__: make
    for make in (
        stribeck, viscous_drag, static_aging, buckling_contact, cuttings_bed, tortuosity, friction_drift,
        top_drive_backlash, torsional_compliance, axial_oscillation_tool, heave, motor_wear, formation_change,
        torque_sensor_gain, torque_sensor_lag, torque_sensor_bias, torque_at_motor,
    )
}  # fmt: skip
CATALOGUE_LAWS: dict[str, LawFactory] = {
    name: _OTHER_FORMS.get(name) or registry_law(definition) for name, definition in EFFECTS.items()
}
