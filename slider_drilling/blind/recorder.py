"""The recorder of a sealed run: coloured noise, quantised readings, lost samples, log defects."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from slider_drilling.angles import wrap_angle
from slider_drilling.blind.log_defects import LogDefect
from slider_drilling.blind.sealed_plant import INTERVAL_S
from slider_drilling.drillstring import Commands, Response
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.sensors import quantise
from slider_drilling.log.write import LogWriter
from slider_drilling.messages.topics import TOPICS
from slider_drilling.rig import Rig, dump_rig

# A fixed date: the same case gives the same file, byte for byte.
_RECORDED = datetime.datetime(2000, 1, 1, tzinfo=datetime.timezone.utc)
CHANNELS = ("surface_torque", "hook_load", "standpipe_pressure")
_MIN_OUTAGE_S = 0.3


@dataclass(frozen=True)
class RecorderModel:
    """Errors of sensors and recorder. The standard deviation of each channel's noise is that of the rig file.

    Attributes:
        slow_noise_share: Share of the noise variance that is correlated in time.
        slow_noise_time: Correlation time of that noise, s.
        resolution: Of each channel in `CHANNELS`, in units of its noise.
        outages: Mean number of outages per topic and run.
        longest_outage: In s.
        lost_share: Share of single samples that are lost.
        mwd_lost_share: Share of MWD samples that are lost.
        defect: What the log leaves out besides.
    """

    slow_noise_share: float = 0.0
    slow_noise_time: float = 0.5
    resolution: tuple[float, float, float] = (0.0, 0.0, 0.0)
    outages: float = 0.0
    longest_outage: float = 1.5
    lost_share: float = 0.0
    mwd_lost_share: float = 0.0
    defect: LogDefect = LogDefect()


def random_recorder_model(generator: np.random.Generator, defect: LogDefect = LogDefect()) -> RecorderModel:
    """Returns a recorder between a clean one and one with slow noise, coarse values and many lost samples."""
    resolution = generator.choice([0.0, 0.25, 0.5, 1.0], size=3)
    return RecorderModel(
        slow_noise_share=float(generator.uniform(0.0, 0.4)), slow_noise_time=float(generator.uniform(0.2, 1.0)),
        resolution=(float(resolution[0]), float(resolution[1]), float(resolution[2])),
        outages=float(generator.uniform(0.0, 4.0)), lost_share=float(generator.choice([0.0, 0.002, 0.01])),
        mwd_lost_share=float(generator.choice([0.0, 0.05, 0.15])), defect=defect,
    )  # fmt: skip


def write_sealed_log(
    path: Path,
    rig: Rig,
    commands: Commands,
    response: Response,
    generator: np.random.Generator,
    recorder: RecorderModel = RecorderModel(),
) -> None:
    """Writes a log that holds the nominal rig file and what the recorder kept, and nothing of the truth.

    Args:
        path: Of the log.
        rig: The rig as its file states it.
        commands: What the log states that the rig did.
        response: Of the sealed plant, without noise.
        generator: Of noise and losses.
        recorder: Errors of sensors and recorder.
    """
    sensors = rig.sensors
    declared = (sensors.surface_torque.noise, sensors.hook_load.noise, sensors.standpipe_pressure.noise)
    torque, hook, pressure = (
        _noisy(getattr(response, name), sigma, share, recorder, generator)
        for name, sigma, share in zip(CHANNELS, declared, recorder.resolution, strict=True)
    )
    count, defect = commands.time.size, recorder.defect
    logged, shown = defect.sample_rows(count)
    start = float(commands.time[logged[0]]) if defect.start_share else 0.0
    drive_kept, block_kept, pump_kept, pressure_kept = (_kept(count, logged, recorder, generator) for _ in range(4))
    angle = _rounded(commands.top_drive_angle, defect.angle_resolution)
    speed = _rounded(commands.top_drive_speed, defect.speed_resolution)
    block = _rounded(commands.block_position, defect.block_resolution)
    drive, works, pump = TOPICS["top_drive"], TOPICS["draw_works"], TOPICS["mud_pump"]
    with LogWriter(path, rig_text=dump_rig(rig), recorded_by="a rig", whole=True, started=_RECORDED) as writer:
        for row, k in zip(logged, shown, strict=True):
            time = float(commands.time[row]) - start
            if drive_kept[row]:
                writer.joint_state(drive.name, time, drive.joint, angle[k], speed[k], torque[k])
            if block_kept[row] and "draw_works" not in defect.missing_series:
                writer.joint_state(works.name, time, works.joint, block[k], commands.block_speed[k], hook[k])
            if pump_kept[row] and "mud_pump" not in defect.missing_series:
                writer.joint_state(pump.name, time, pump.joint, velocity=commands.pump_speed[k])
            if pressure_kept[row]:
                writer.fluid_pressure(TOPICS["standpipe_pressure"].name, time, pressure[k])
        _write_mwd(writer, rig, response, recorder, generator, start)


def _noisy(
    values: Array, sigma: float, resolution: float, recorder: RecorderModel, generator: np.random.Generator
) -> Array:
    """Adds white noise and first-order autoregressive noise, then rounds to the resolution (in units of sigma)."""
    white = generator.normal(0.0, 1.0, values.size)
    correlation = float(np.exp(-INTERVAL_S / recorder.slow_noise_time))
    shocks = generator.normal(0.0, np.sqrt(1.0 - correlation**2), values.size)
    slow = np.empty_like(white)
    level = float(generator.normal())
    for k, shock in enumerate(shocks):
        level = correlation * level + shock
        slow[k] = level
    noisy = values + sigma * (
        np.sqrt(1.0 - recorder.slow_noise_share) * white + np.sqrt(recorder.slow_noise_share) * slow
    )
    return _rounded(noisy, resolution * sigma)


def _rounded(values: Array, resolution: float) -> Array:
    return np.round(values / resolution) * resolution if resolution > 0.0 else values


def _kept(
    count: int, logged: NDArray[np.int64], recorder: RecorderModel, generator: np.random.Generator
) -> NDArray[np.bool_]:
    """(count,) whether each sample is kept; the first and the last logged one always are."""
    kept = generator.uniform(size=count) >= recorder.lost_share
    for _ in range(int(generator.poisson(recorder.outages))):
        begin = int(generator.integers(1, count))
        kept[begin : begin + int(generator.uniform(_MIN_OUTAGE_S, recorder.longest_outage) / INTERVAL_S)] = False
    kept[logged[[0, -1]]] = True
    return np.asarray(kept, dtype=np.bool_)


def _write_mwd(
    writer: LogWriter, rig: Rig, response: Response, recorder: RecorderModel, generator: np.random.Generator,
    start: float,
) -> None:  # fmt: skip
    mwd, topic = rig.sensors.mwd, TOPICS["mwd_tool_face"]
    for measured in np.arange(mwd.period, response.time[-1], mwd.period):
        angle = float(np.interp(measured, response.time, response.tool_face)) + generator.normal(0.0, mwd.noise)
        reading = wrap_angle(quantise(wrap_angle(angle), mwd.resolution))
        time = float(measured) - start
        if generator.uniform() >= recorder.mwd_lost_share and time >= 0.0:
            writer.joint_state(topic.name, time, topic.joint, position=reading, log_time_s=time + mwd.latency)
