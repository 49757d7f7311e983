"""What a recorder makes of a sealed run: noise of some colour, quantised readings, samples that are lost."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from slider_drilling.blind.log_defects import LogDefect
from slider_drilling.blind.sealed_plant import INTERVAL_S
from slider_drilling.drillstring import Commands, Response
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.sensors import quantise, wrap_angle
from slider_drilling.log.write import LogWriter
from slider_drilling.messages.topics import TOPICS
from slider_drilling.rig import Rig, dump_rig

# The same case is the same file, byte for byte, whenever it is made.
_RECORDED = datetime.datetime(2000, 1, 1, tzinfo=datetime.timezone.utc)
CHANNELS = ("surface_torque", "hook_load", "standpipe_pressure")


@dataclass(frozen=True)
class RecorderModel:
    """How the sensors err; of all channels the one-sigma error is the rig file's.

    colour: share of the noise's variance that is slow; memory: s over which that share forgets; resolution: of each
    of `CHANNELS`, in its noise; stretches: lost ones per run and topic, each up to longest s; lost, mwd_lost: share
    of single samples that never come; lack: what it leaves out.
    """

    slow_noise_share: float = 0.0
    slow_noise_time: float = 0.5
    resolution: tuple[float, float, float] = (0.0, 0.0, 0.0)
    outages: float = 0.0
    longest_outage: float = 1.5
    lost_share: float = 0.0
    mwd_lost_share: float = 0.0
    defect: LogDefect = LogDefect()


def random_recorder_model(generator: np.random.Generator, lack: LogDefect = LogDefect()) -> RecorderModel:
    """From a clean one to one that is slow, coarse and patchy; all of them leave this out."""
    resolution = generator.choice([0.0, 0.25, 0.5, 1.0], size=3)
    return RecorderModel(
        slow_noise_share=float(generator.uniform(0.0, 0.4)), slow_noise_time=float(generator.uniform(0.2, 1.0)),
        resolution=(float(resolution[0]), float(resolution[1]), float(resolution[2])),
        outages=float(generator.uniform(0.0, 4.0)), lost_share=float(generator.choice([0.0, 0.002, 0.01])),
        mwd_lost_share=float(generator.choice([0.0, 0.05, 0.15])), defect=lack,
    )  # fmt: skip


def write_sealed_log(
    path: Path,
    rig: Rig,
    commands: Commands,
    response: Response,
    generator: np.random.Generator,
    recorder: RecorderModel = RecorderModel(),
) -> None:
    """A log with the nominal rig file, erring sensors and no truth."""
    sensors = rig.sensors
    declared = (sensors.surface_torque.noise, sensors.hook_load.noise, sensors.standpipe_pressure.noise)
    torque, hook, pressure = (
        _read(getattr(response, name), sigma, share, recorder, generator)
        for name, sigma, share in zip(CHANNELS, declared, recorder.resolution, strict=True)
    )
    count, lack = commands.time.size, recorder.defect
    stamped, seen = lack.sample_rows(count)
    begun = float(commands.time[stamped[0]]) if lack.start_share else 0.0
    driven, lowered, pumped, pressed = (_received(count, stamped, recorder, generator) for _ in range(4))
    angle, speed = (
        _in_steps(commands.top_drive_angle, lack.angle_resolution),
        _in_steps(commands.top_drive_speed, lack.speed_resolution),
    )
    block = _in_steps(commands.block_position, lack.block_resolution)
    drive, works, pump = TOPICS["top_drive"], TOPICS["draw_works"], TOPICS["mud_pump"]
    with LogWriter(path, rig_text=dump_rig(rig), recorded_by="a rig", whole=True, started=_RECORDED) as writer:
        for row, k in zip(stamped, seen, strict=True):
            time = float(commands.time[row]) - begun
            if driven[row]:
                writer.joint_state(drive.name, time, drive.joint, angle[k], speed[k], torque[k])
            if lowered[row] and "draw_works" not in lack.missing_series:
                writer.joint_state(works.name, time, works.joint, block[k], commands.block_speed[k], hook[k])
            if pumped[row] and "mud_pump" not in lack.missing_series:
                writer.joint_state(pump.name, time, pump.joint, velocity=commands.pump_speed[k])
            if pressed[row]:
                writer.fluid_pressure(TOPICS["standpipe_pressure"].name, time, pressure[k])
        _write_mwd(writer, rig, response, recorder, generator, begun)


def _read(values: Array, sigma: float, share: float, recorder: RecorderModel, generator: np.random.Generator) -> Array:
    white = generator.normal(0.0, 1.0, values.size)
    keep = float(np.exp(-INTERVAL_S / recorder.slow_noise_time))
    shocks = generator.normal(0.0, np.sqrt(1.0 - keep**2), values.size)
    slow = np.empty_like(white)
    level = float(generator.normal())
    for k, shock in enumerate(shocks):
        level = keep * level + shock
        slow[k] = level
    noisy = values + sigma * (
        np.sqrt(1.0 - recorder.slow_noise_share) * white + np.sqrt(recorder.slow_noise_share) * slow
    )
    return _in_steps(noisy, share * sigma)


def _in_steps(values: Array, step: float) -> Array:
    return np.round(values / step) * step if step > 0.0 else values


def _received(
    count: int, stamped: NDArray[np.int64], recorder: RecorderModel, generator: np.random.Generator
) -> NDArray[np.bool_]:
    """(count,) whether each sample comes; of those that are stamped the first and the last always do."""
    came = generator.uniform(size=count) >= recorder.lost_share
    for _ in range(int(generator.poisson(recorder.outages))):
        begin = int(generator.integers(1, count))
        came[begin : begin + int(generator.uniform(0.3, recorder.longest_outage) / INTERVAL_S)] = False
    came[stamped[[0, -1]]] = True
    return np.asarray(came, dtype=np.bool_)


def _write_mwd(
    writer: LogWriter,
    rig: Rig,
    response: Response,
    recorder: RecorderModel,
    generator: np.random.Generator,
    begun: float,
) -> None:
    mwd, topic = rig.sensors.mwd, TOPICS["mwd_tool_face"]
    for measured in np.arange(mwd.period, response.time[-1], mwd.period):
        angle = float(np.interp(measured, response.time, response.tool_face)) + generator.normal(0.0, mwd.noise)
        shown = wrap_angle(quantise(wrap_angle(angle), mwd.resolution))
        time = float(measured) - begun
        if generator.uniform() >= recorder.mwd_lost_share and time >= 0.0:
            writer.joint_state(topic.name, time, topic.joint, position=shown, log_time_s=time + mwd.latency)
