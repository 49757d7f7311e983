"""Make a sealed slide: a controller or a crew slides on a foreign rig, with operations, and something begins."""

from __future__ import annotations

import datetime
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.blind.foreign.structure import Structure, draw_structure
from slider_drilling.blind.sealed_plant import PlantPerturbation, random_perturbation
from slider_drilling.blind.slides.beginnings import BEGINNINGS, NOTHING, Beginning
from slider_drilling.blind.slides.case import SlideCase, slide_case_from_json
from slider_drilling.blind.slides.changing_rig import ChangingRig
from slider_drilling.blind.slides.crew import draw_rocking
from slider_drilling.blind.slides.driller import Driller
from slider_drilling.blind.slides.label import SlideLabel
from slider_drilling.blind.slides.operations import Operation, draw_operations
from slider_drilling.blind.slides.size import VISIBLE, commands_of, size_over_time
from slider_drilling.blind.wells import WELLS
from slider_drilling.campaign.job import Job
from slider_drilling.control.interface import Measurements
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.files.output_files import write_atomically
from slider_drilling.log.write import LogWriter
from slider_drilling.messages.topics import TOPICS
from slider_drilling.rig import Rig, dump_rig, load_rig

_ELEMENTS = 60
_MWD_PERIODS = (8.0, 12.0, 20.0, 30.0)  # s
_RECORDED = datetime.datetime(2000, 1, 1, tzinfo=datetime.timezone.utc)  # a fixed date: the same case, the same file
_LOST = (0.0, 0.002, 0.01)  # shares of samples that a recorder loses


@dataclass(frozen=True)
class DrawnSlide:
    """What is drawn for a slide.

    Attributes:
        rig: The rig as its file states it.
        perturbation: By what its numbers and its start differ from the file.
        structure: How its plant and instruments differ from the model.
        operations: During the slide.
        target: Toolface, rad.
        lost: Share of samples that the recorder loses.
        beginning: What begins; None for nothing.
        generator: Of what is drawn after these.
    """

    rig: Rig
    perturbation: PlantPerturbation
    structure: Structure
    operations: tuple[Operation, ...]
    target: float
    lost: float
    beginning: Beginning | None
    generator: np.random.Generator


def slide_job(case: SlideCase, rig: Path, logs: Path, labels: Path) -> Job:
    """The job that makes a case; rig: file that well, string and fluids are drawn from."""
    stem = case.file_stem()
    outputs = (str(logs / f"{stem}.mcap"), str(labels / f"{stem}.json"))
    call = "slider_drilling.blind.slides.make:seal_slide"
    return Job(call, stem, {"rig": str(rig)}, case.to_json(), case.seed, outputs)


def seal_slide(job: Job) -> dict[str, Any]:
    """Write the log, then the label."""
    log, label_path = (Path(output) for output in job.outputs)
    label = make_slide(slide_case_from_json(dict(job.options)), load_rig(job.inputs["rig"]), log)
    write_atomically(label_path, (json.dumps(asdict(label), indent=1) + "\n").encode("utf-8"))
    return {}


def make_slide(case: SlideCase, base: Rig, path: Path) -> SlideLabel:
    """Write one sealed slide and return its label.

    Args:
        case: What begins, and when.
        base: Rig that well, string and fluids are drawn from.
        path: Of the log.
    """
    drawn = draw_slide(case, base)
    rig, perturbation = drawn.rig, drawn.perturbation
    changing = ChangingRig(
        rig, perturbation.nuisance, drawn.structure, case, drawn.beginning, _ELEMENTS, perturbation.start
    )
    crew = np.random.default_rng([case.seed, 2])
    rocking = draw_rocking(crew, rig, case.duration) if case.driven_by == "crew" else ()
    measured = slide(changing, Driller(rig, drawn.operations, drawn.target, rocking), case.duration)
    _write(path, rig, measured, drawn.target, drawn.lost, drawn.generator)
    return _label(case, drawn, path.name, measured)


def draw_slide(case: SlideCase, base: Rig) -> DrawnSlide:
    """What a case draws; base: rig that well, string and fluids are drawn from."""
    # The order of the draws defines the slides of a seed.
    generator = np.random.default_rng([case.seed, 1])
    rig = WELLS[case.well](generator, base)
    mwd = replace(rig.sensors.mwd, period=float(generator.choice(_MWD_PERIODS)))
    rig = replace(rig, sensors=replace(rig.sensors, mwd=mwd))
    perturbation, structure = random_perturbation(generator), draw_structure(generator)
    operations = draw_operations(generator, case.duration)
    target = float(generator.uniform(-math.pi, math.pi))
    lost = float(generator.choice(_LOST))
    beginning = None if case.begins == NOTHING else BEGINNINGS[case.begins](generator, rig, case.onset)
    return DrawnSlide(rig, perturbation, structure, tuple(operations), target, lost, beginning, generator)


def slide(rig: ChangingRig, driller: Driller, duration: float) -> list[Measurements]:
    """Every sample of a slide of this duration, s."""
    measured = [rig.measurements]
    for _ in range(round(duration / rig.interval)):
        measured.append(rig.step(driller.command(measured[-1], rig.interval)))
    return measured


def _label(case: SlideCase, drawn: DrawnSlide, log: str, measured: Sequence[Measurements]) -> SlideLabel:
    spans = tuple((each.name, each.start, each.end) for each in drawn.operations)
    label = SlideLabel(
        log, case.begins, NOTHING, (), None, False, None, case.growth, None, 0.0, spans, case.duration, case.seed,
        case.well, asdict(drawn.perturbation), asdict(drawn.structure),
    )  # fmt: skip
    beginning = drawn.beginning
    if beginning is None:
        return label
    commands = commands_of(measured)
    size = size_over_time(drawn.rig, drawn.perturbation.nuisance, beginning, case, commands)
    return replace(
        label, name=beginning.name, accepted=beginning.accepted, site=beginning.site,
        in_catalogue=beginning.in_catalogue, onset=case.onset, reached=_reached(commands.time, size),
        size=float(size.max()),
    )  # fmt: skip


def _reached(time: Array, size: Array) -> float | None:
    visible = np.flatnonzero(size >= VISIBLE)
    return float(time[visible[0]]) if visible.size else None


def _write(
    path: Path, rig: Rig, measured: Sequence[Measurements], target: float, lost: float, generator: np.random.Generator
) -> None:
    """A log that holds the rig file and what a recorder kept, and nothing of the truth."""
    drive, works, pump, mwd = (TOPICS[name] for name in ("top_drive", "draw_works", "mud_pump", "mwd_tool_face"))
    kept = generator.uniform(size=(len(measured), 4)) >= lost
    kept[0] = True
    with LogWriter(path, rig_text=dump_rig(rig), recorded_by="a rig", whole=True, started=_RECORDED) as writer:
        aimed = TOPICS["tool_face_target"]
        writer.joint_state(aimed.name, measured[0].time, aimed.joint, position=target)
        for sample, row in zip(measured, kept, strict=True):
            time = sample.time
            if row[0]:
                writer.joint_state(drive.name, time, drive.joint, sample.top_drive_angle, sample.top_drive_speed,
                                   sample.surface_torque)  # fmt: skip
            if row[1]:
                writer.joint_state(works.name, time, works.joint, sample.block_position, sample.block_speed,
                                   sample.hook_load)  # fmt: skip
            if row[2]:
                writer.joint_state(pump.name, time, pump.joint, velocity=sample.pump_speed)
            if row[3]:
                writer.fluid_pressure(TOPICS["standpipe_pressure"].name, time, sample.standpipe_pressure)
            for decoded in sample.mwd:
                writer.joint_state(mwd.name, decoded.measured_at, mwd.joint, position=decoded.tool_face,
                                   log_time_s=decoded.arrived_at)  # fmt: skip
