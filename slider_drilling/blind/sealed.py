"""Logs whose cause is sealed: a plant that differs from the diagnosing one in mesh, step, nuisance and law."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from slider_drilling.diagnosis.drill_string import rig_with
from slider_drilling.drillstring import Commands, Modifiers, Plant, Response
from slider_drilling.drillstring.sensors import quantise, wrap
from slider_drilling.gap.model import Array
from slider_drilling.log.write import LogWriter
from slider_drilling.messages.topics import TOPICS
from slider_drilling.rig import FrictionInterval, Rig, Section, dump_rig
from slider_drilling.wellbore.mesh import build_mesh

SEALED_ELEMENTS = 260
_CHUNK_S = 8.0
_DURATION_S = 400.0
_INTERVAL_S = 0.1


@dataclass(frozen=True)
class Law:
    """What the sealed plant does that its rig file does not say.

    name: of the catalogue's effect, ``none``, or of something outside it; site: where it acts; in_catalogue: whether
    the diagnosis could name it. values(time): effect and nuisance values as they are then (they may vary: a step that
    is a ramp in truth); friction, curvature (elements' middles -> (n,)): profiles along the hole; commands: what the
    rig really did; sensors: what the surface reads.
    """

    name: str
    site: str | None
    in_catalogue: bool
    values: Callable[[float], dict[str, float]] = field(default=lambda time: {})
    friction: Callable[[Array], Array] | None = None
    curvature: Callable[[Array], Array] | None = None
    commands: Callable[[Commands], Commands] = field(default=lambda commands: commands)
    sensors: Callable[[Response], Response] = field(default=lambda response: response)
    varies: bool = False
    interval: tuple[float, float] | None = None
    rig: Callable[[Rig], Rig] = field(default=lambda rig: rig)


def random_rig(generator: np.random.Generator, base: Rig) -> Rig:
    """A well and string near the base rig's: a vertical part, a build, a horizontal."""
    kick, build = generator.uniform(700.0, 1400.0), generator.uniform(600.0, 1000.0)
    length = kick + build + generator.uniform(700.0, 1600.0)
    survey = (
        (0.0, 0.0, 10.0),
        (kick, 0.0, 10.0),
        (kick + build, generator.uniform(80.0, 90.0), 14.0),
        (length, 90.0, 14.0),
    )
    pipe, assembly = base.string.sections[0], base.string.sections[-1]
    sections = (
        Section(pipe.name, length - 60.0, pipe.outer_diameter, pipe.inner_diameter),
        Section(assembly.name, 60.0, assembly.outer_diameter, assembly.inner_diameter),
    )
    intervals = (FrictionInterval(kick + build, 0.8), FrictionInterval(length, 1.0))
    well = replace(base.well, survey=survey, friction_intervals=intervals)
    return replace(base, well=well, string=replace(base.string, sections=sections))


def random_nuisance(generator: np.random.Generator) -> dict[str, float]:
    """Nuisance multiples off by some per cent."""
    spread = {"friction_1": 0.06, "friction_2": 0.06, "torsional_damping": 0.15, "axial_damping": 0.15,
              "bit_stiffness": 0.07, "motor_gain": 0.03, "pressure_gain": 0.015}  # fmt: skip
    return {name: float(np.exp(generator.normal(0.0, sigma))) for name, sigma in spread.items()}


def random_commands(generator: np.random.Generator, rig: Rig) -> Commands:
    """Rocking of several amplitudes and speeds with rests between, a flow step, steps of block speed."""
    time = np.arange(0.0, _DURATION_S, _INTERVAL_S, dtype=np.float64)
    speed: Array = np.zeros_like(time)
    at = 5.0
    while at < _DURATION_S - 40.0:
        amplitude, rate = generator.uniform(6.0, 28.0), generator.uniform(1.5, 4.5)
        quarter = amplitude / rate
        cycles = int(generator.integers(3, 6))
        for leg in range(2 * cycles):
            length = quarter if leg in (0, 2 * cycles) else 2.0 * quarter
            here = (time >= at) & (time < at + length)
            speed[here] = rate if leg % 2 == 0 else -rate
            at += length
        here = (time >= at) & (time < at + quarter)
        speed[here] = rate
        at += quarter + generator.uniform(8.0, 20.0)
    reach = 4
    speed = np.convolve(speed, np.ones(reach) / reach, mode="same").astype(np.float64)
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * _INTERVAL_S)])
    block_speed = np.interp(time, *_steps(generator, 0.0022, 0.0036))
    block = np.concatenate([[0.0], np.cumsum(0.5 * (block_speed[1:] + block_speed[:-1]) * _INTERVAL_S)])
    crank = rig.hydraulics.reference_flow / rig.mud_pump.displacement
    pump = np.where((time > 200.0) & (time < 235.0), 0.93 * crank, crank)
    return Commands(time, angle, speed, block, block_speed, pump)


def _steps(generator: np.random.Generator, low: float, high: float) -> tuple[list[float], list[float]]:
    levels = generator.uniform(low, high, size=3)
    return [0.0, 158.0, 160.0, 278.0, 280.0, _DURATION_S], [float(levels[k // 2]) for k in range(6)]


def run_sealed(rig: Rig, nuisance: dict[str, float], law: Law, commands: Commands) -> Response:
    """What the plant with the law does, noise-free; finer mesh and another step than any diagnosis uses."""
    actual = law.commands(commands)
    mesh = build_mesh(rig, SEALED_ELEMENTS)
    extra = Modifiers(
        1.0 if law.friction is None else law.friction(mesh.middle),
        0.0 if law.curvature is None else law.curvature(mesh.middle),
    )
    chunk = round(_CHUNK_S / _INTERVAL_S) if law.varies else commands.time.size
    pieces, state = [], None
    for begin in range(0, commands.time.size, chunk):
        part = slice(begin, begin + chunk)
        values = nuisance | law.values(float(commands.time[begin]) + 0.5 * _CHUNK_S)
        tuned = law.rig(rig_with(rig, values))
        plant = Plant(tuned, SEALED_ELEMENTS, _INTERVAL_S, modifiers=extra, substeps=_substeps(tuned))
        if state is not None:
            plant.restore(state)
        fields = [np.asarray(getattr(actual, name))[part] for name in Commands.__dataclass_fields__]
        pieces.append(plant.advance(Commands(*fields)))
        state = plant.save()
    joined = [np.concatenate([getattr(piece, name) for piece in pieces]) for name in Response.__dataclass_fields__]
    return law.sensors(Response(*joined))


def _substeps(rig: Rig) -> int:
    """A third more steps than the plant would choose itself."""
    return int(np.ceil(1.33 * Plant(rig, SEALED_ELEMENTS, _INTERVAL_S)._bundle.substeps))


def size_in_noise(rig: Rig, plain: Response, changed: Response) -> float:
    """How far a law moves the most moved channel, RMS in noise floors."""
    sensors = rig.sensors
    noise = {"surface_torque": sensors.surface_torque.noise, "hook_load": sensors.hook_load.noise,
             "standpipe_pressure": sensors.standpipe_pressure.noise}  # fmt: skip
    return max(
        float(np.sqrt(np.mean((getattr(changed, name) - getattr(plain, name)) ** 2))) / sigma
        for name, sigma in noise.items()
    )


def write_sealed(path: Path, rig: Rig, commands: Commands, response: Response, generator: np.random.Generator) -> None:
    """A log with the nominal rig file, noisy sensors and no truth."""
    sensors, mwd = rig.sensors, rig.sensors.mwd

    def noisy(values: Array, sigma: float) -> Array:
        return values + generator.normal(0.0, sigma, values.size)

    torque = noisy(response.surface_torque, sensors.surface_torque.noise)
    hook = noisy(response.hook_load, sensors.hook_load.noise)
    pressure = noisy(response.standpipe_pressure, sensors.standpipe_pressure.noise)
    drive, works, pump = TOPICS["top_drive"], TOPICS["draw_works"], TOPICS["mud_pump"]
    tool = TOPICS["mwd_tool_face"]
    with LogWriter(path, rig_text=dump_rig(rig), recorded_by="slider-drilling blind-check") as writer:
        for k, time in enumerate(commands.time):
            writer.joint_state(
                drive.name,
                float(time),
                drive.joint,
                commands.top_drive_angle[k],
                commands.top_drive_speed[k],
                torque[k],
            )
            writer.joint_state(
                works.name, float(time), works.joint, commands.block_position[k], commands.block_speed[k], hook[k]
            )
            writer.joint_state(pump.name, float(time), pump.joint, velocity=commands.pump_speed[k])
            writer.fluid_pressure(TOPICS["standpipe_pressure"].name, float(time), pressure[k])
        for measured in np.arange(mwd.period, commands.time[-1], mwd.period):
            angle = float(np.interp(measured, response.time, response.tool_face)) + generator.normal(0.0, mwd.noise)
            shown = wrap(quantise(wrap(angle), mwd.resolution))
            writer.joint_state(
                tool.name, float(measured), tool.joint, position=shown, log_time_s=measured + mwd.latency
            )
