"""Laws outside the catalogue: a diagnosis should call them unknown and give the right site."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.blind.plant_law import FAST_UPDATE_S, SLOW_UPDATE_S, LawFactory, OperatingPoint, PlantLaw
from slider_drilling.drillstring import Commands, Response
from slider_drilling.effects import AngleFriction
from slider_drilling.rig import Rig


def tilted_asperities(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns asperities at another angle: friction depends on the direction of slip in another way."""

    def change(r: Rig, at: OperatingPoint) -> Rig:
        asperity = replace(r.contact.asperity, orientation=min(1.2 * size, 1.5))
        return replace(r, contact=replace(r.contact, asperity=asperity))

    return PlantLaw("tilted_asperities", "contact", False, change_rig=change)


def soft_contact(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a contact whose pre-sliding length is several times that of the rig file."""

    def change(r: Rig, at: OperatingPoint) -> Rig:
        return replace(r, contact=replace(r.contact, stiffness=r.contact.stiffness / (1.0 + 5.0 * size)))

    return PlantLaw("soft_contact", "contact", False, change_rig=change)


def breathing_friction(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns friction that oscillates with a period of about a minute."""
    period, phase = generator.uniform(50.0, 90.0), generator.uniform(0.0, 6.0)

    def values(at: OperatingPoint) -> dict[str, float]:
        return _friction(1.0 + 0.2 * size * np.sin(2.0 * np.pi * at.time / period + phase), at)

    return PlantLaw("breathing_friction", "contact", False, values=values, update_interval=SLOW_UPDATE_S)


def bent_pipe(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns friction that depends on the pipe's angle, see `AngleFriction`."""
    friction = AngleFriction(0.15 * size, generator.uniform(0.0, 6.0), np.sin)

    def values(at: OperatingPoint) -> dict[str, float]:
        return _friction(friction(at.angle), at)

    return PlantLaw("bent_pipe", "contact", False, values=values, update_interval=FAST_UPDATE_S)


def _friction(factor: float, at: OperatingPoint) -> dict[str, float]:
    """Returns the rate of the plant's friction drift that gives this factor on friction now."""
    return {"friction_drift.rate": (max(factor, 0.05) - 1.0) / max(at.time, 1.0)}


def slipping_encoder(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a drive that turns less than its encoder shows."""

    def true_motion(commands: Commands) -> Commands:
        share = max(1.0 - 0.08 * size, 0.3)
        return replace(commands, top_drive_angle=share * commands.top_drive_angle,
                       top_drive_speed=share * commands.top_drive_speed)  # fmt: skip

    return PlantLaw("slipping_encoder", "top_drive", False, ("sensor",), change_commands=true_motion)


def sticking_sheave(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a sticking sheave: the hook load reads too high, then too low, with a period of its own."""
    half = generator.uniform(15.0, 40.0)

    def read(response: Response) -> Response:
        error = 4e3 * size * np.where((response.time // half) % 2.0 == 0.0, 1.0, -1.0)
        return replace(response, hook_load=response.hook_load + error)

    return PlantLaw("sticking_sheave", "draw_works", False, ("sensor",), change_response=read)


def hook_load_gain(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a dead-line sensor that is wrong by a factor."""
    sign = generator.choice([-1.0, 1.0])

    def read(response: Response) -> Response:
        return replace(response, hook_load=(1.0 + 0.02 * sign * size) * response.hook_load)

    return PlantLaw("hook_load_gain", "sensor", False, ("draw_works",), change_response=read)


def washout(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a washout: pressure is lost slowly during the run."""
    start_share = generator.uniform(0.0, 0.3)

    def read(response: Response) -> Response:
        since = np.clip(response.time - start_share * response.time[-1], 0.0, None)
        return replace(response, standpipe_pressure=response.standpipe_pressure - 1e5 * size * since / 60.0)

    return PlantLaw("washout", "hydraulics", False, ("sensor",), change_response=read)


def leaking_pump(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a pump whose flow per stroke falls during the run."""

    def true_motion(commands: Commands) -> Commands:
        share = 1.0 - 0.01 * size * commands.time / commands.time[-1]
        return replace(commands, pump_speed=np.clip(share, 0.3, 1.0) * commands.pump_speed)

    return PlantLaw("leaking_pump", "hydraulics", False, change_commands=true_motion)


def dulling_bit(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Returns a bit whose torque per weight falls during the run."""

    def change(r: Rig, at: OperatingPoint) -> Rig:
        sharp = max(1.0 - 0.2 * size * at.time / at.duration, 0.1)
        return replace(r, bit=replace(r.bit, aggressiveness=sharp * r.bit.aggressiveness))

    return PlantLaw("dulling_bit", "bit", False, change_rig=change, update_interval=SLOW_UPDATE_S)


OUTSIDE_LAWS: dict[str, LawFactory] = {
    make.__name__: make
    for make in (
        tilted_asperities, soft_contact, breathing_friction, bent_pipe, slipping_encoder, sticking_sheave,
        hook_load_gain, washout, leaking_pump, dulling_bit,
    )
}  # fmt: skip
