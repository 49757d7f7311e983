"""Which rig file a diagnosis holds the logs against, and where it came from."""

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
    """name: of the file as it is told; source: given beside the log, or attached to it; path: None where it was made in
    Python and has no file."""

    name: str
    source: Literal["given", "attached"]
    path: str | None


def find_rig_source(logs: Sequence[RigLog], rig: Rig) -> RigSource:
    """Where this rig came from, by what the logs carry."""
    for log in logs:
        if log.rig_text is None or log.rig_source is None or _carried(log) != rig:
            continue
        # An attachment is told as "run.mcap: rig.yaml", a file beside the log by its path.
        file, colon, attachment = log.rig_source.rpartition(": ")
        if colon and attachment.endswith("rig.yaml"):
            return RigSource(f"{attachment} in {Path(file).name}", "attached", file)
        return RigSource(Path(log.rig_source).name, "given", log.rig_source)
    return RigSource("the rig given", "given", None)


def rig_remarks(origin: RigSource, logs: Sequence[RigLog], rig: Rig) -> list[str]:
    """What a reader must know of the rig file before believing a verdict."""
    found = []
    on = [f.name for f in dataclasses.fields(Effects) if getattr(rig.effects, f.name) != getattr(Effects(), f.name)]
    if origin.source == "attached":
        recorder = logs[0].metadata.get("recorded_by", "")
        by = f" ({recorder})" if recorder else ""
        found.append(f"held against the rig file that the log itself carries, the one it was recorded with{by}")
    if on:
        plural = "an effect" if len(on) == 1 else "effects"
        advice = "" if origin.source == "given" else "; to look for them, give a rig file without them with --rig"
        found.append(f"the rig file has {plural} switched on ({', '.join(on)}), so they are no gap{advice}")
    return found


def _carried(log: RigLog) -> Rig | None:
    try:
        return log.rig()
    except InputError:
        return None
