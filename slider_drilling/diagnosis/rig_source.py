"""Where the rig file of a diagnosis came from, and what a reader must know about it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from slider_drilling.effects import Effects
from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.rig import Rig


@dataclass(frozen=True)
class RigSource:
    """Origin of a rig file.

    Attributes:
        name: Name that is shown.
        source: ``given`` beside the log, or ``attached`` to it.
        path: File that holds it; None for a rig made in Python.
    """

    name: str
    source: Literal["given", "attached"]
    path: str | None


def find_rig_source(logs: Sequence[RigLog], rig: Rig) -> RigSource:
    """Where this rig came from, by the rig files that the logs name or carry."""
    for log in logs:
        if log.rig_text is None or log.rig_source is None or _own_rig(log) != rig:
            continue
        # An attachment is named "run.mcap: rig.yaml", a file beside the log by its path.
        file, colon, attachment = log.rig_source.rpartition(": ")
        if colon and attachment.endswith("rig.yaml"):
            return RigSource(f"{attachment} in {Path(file).name}", "attached", file)
        return RigSource(Path(log.rig_source).name, "given", log.rig_source)
    return RigSource("the rig given", "given", None)


def rig_remarks(source: RigSource, logs: Sequence[RigLog], rig: Rig) -> list[str]:
    """What a reader must know about the rig file before believing a verdict."""
    remarks = []
    switched_on = [
        f.name for f in dataclasses.fields(Effects) if getattr(rig.effects, f.name) != getattr(Effects(), f.name)
    ]
    if source.source == "attached":
        recorder = logs[0].metadata.get("recorded_by", "")
        by = f" ({recorder})" if recorder else ""
        remarks.append(f"the log is compared with the rig file attached to it, the one that it was recorded with{by}")
    if switched_on:
        effects = "an effect" if len(switched_on) == 1 else "effects"
        it = "it is" if len(switched_on) == 1 else "they are"
        advice = "" if source.source == "given" else "; to find such effects, give a rig file without them with --rig"
        remarks.append(
            f"the rig file has {effects} switched on ({', '.join(switched_on)}): {it} in the model, not in the "
            f"gap{advice}"
        )
    return remarks


def _own_rig(log: RigLog) -> Rig | None:
    try:
        return log.rig()
    except InputError:
        return None
