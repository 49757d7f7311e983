"""Laws that no catalogue holds: what a diagnosis should call unknown, at the right site."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.blind.plant_law import FAST_UPDATE_S, SLOW_UPDATE_S, LawFactory, OperatingPoint, PlantLaw
from slider_drilling.drillstring import Commands, Response
from slider_drilling.rig import Rig


def tilted_asperities(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Asperities that lie across: friction depends on direction otherwise than the file says."""

    def change(r: Rig, at: OperatingPoint) -> Rig:
        asperity = replace(r.contact.asperity, orientation=min(1.2 * size, 1.5))
        return replace(r, contact=replace(r.contact, asperity=asperity))

    return PlantLaw("tilted_asperities", "contact", False, change_rig=change)


def soft_contact(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """A pre-sliding length several times the file's."""

    def change(r: Rig, at: OperatingPoint) -> Rig:
        return replace(r, contact=replace(r.contact, stiffness=r.contact.stiffness / (1.0 + 5.0 * size)))

    return PlantLaw("soft_contact", "contact", False, change_rig=change)


def breathing_friction(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Friction that comes and goes with a period of about a minute."""
    period, phase = generator.uniform(50.0, 90.0), generator.uniform(0.0, 6.0)

    def values(at: OperatingPoint) -> dict[str, float]:
        return _friction(1.0 + 0.2 * size * np.sin(2.0 * np.pi * at.time / period + phase), at)

    return PlantLaw("breathing_friction", "contact", False, values=values, update_interval=SLOW_UPDATE_S)


def bent_pipe(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Friction that depends on the pipe's angle: a bend that lies against the wall once a turn."""
    phase = generator.uniform(0.0, 6.0)

    def values(at: OperatingPoint) -> dict[str, float]:
        return _friction(1.0 + 0.15 * size * np.sin(at.angle + phase), at)

    return PlantLaw("bent_pipe", "contact", False, values=values, update_interval=FAST_UPDATE_S)


def _friction(factor: float, at: OperatingPoint) -> dict[str, float]:
    """Friction multiplied now: the plant's drift, with the rate that gets there in this time."""
    return {"friction_drift.rate": (max(factor, 0.05) - 1.0) / max(at.time, 1.0)}


def slipping_encoder(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """The drive turns less than its encoder says."""

    def really(commands: Commands) -> Commands:
        share = max(1.0 - 0.08 * size, 0.3)
        return replace(commands, top_drive_angle=share * commands.top_drive_angle,
                       top_drive_speed=share * commands.top_drive_speed)  # fmt: skip

    return PlantLaw("slipping_encoder", "top_drive", False, ("sensor",), change_commands=really)


def sticking_sheave(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """A sheave that sticks: the hook load reads too much, then too little, at its own time."""
    half = generator.uniform(15.0, 40.0)

    def read(response: Response) -> Response:
        off = 4e3 * size * np.where((response.time // half) % 2.0 == 0.0, 1.0, -1.0)
        return replace(response, hook_load=response.hook_load + off)

    return PlantLaw("sticking_sheave", "draw_works", False, ("sensor",), change_response=read)


def hook_load_gain(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """A dead-line sensor that is off by a factor."""
    sign = generator.choice([-1.0, 1.0])
    return PlantLaw("hook_load_gain", "sensor", False, ("draw_works",),
               change_response=lambda r: replace(r, hook_load=(1.0 + 0.02 * sign * size) * r.hook_load))  # fmt: skip


def washout(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """Pressure that is lost slowly over the run."""
    begins = generator.uniform(0.0, 0.3)

    def read(response: Response) -> Response:
        since = np.clip(response.time - begins * response.time[-1], 0.0, None)
        return replace(response, standpipe_pressure=response.standpipe_pressure - 1e5 * size * since / 60.0)

    return PlantLaw("washout", "hydraulics", False, ("sensor",), change_response=read)


def leaking_pump(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """A pump that gives less and less of what its strokes say."""

    def really(commands: Commands) -> Commands:
        share = 1.0 - 0.01 * size * commands.time / commands.time[-1]
        return replace(commands, pump_speed=np.clip(share, 0.3, 1.0) * commands.pump_speed)

    return PlantLaw("leaking_pump", "hydraulics", False, change_commands=really)


def dulling_bit(generator: np.random.Generator, rig: Rig, size: float) -> PlantLaw:
    """A bit whose torque per weight falls over the run."""

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
