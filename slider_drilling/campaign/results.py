"""A campaign's results: one file each, whole or absent, named by what the result depends on."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider_drilling.campaign.job import Job
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text, write_atomically

SCHEMA = "slider_drilling/result/1"


@dataclass(frozen=True)
class JobResult:
    """What came of a job. tree: what its function returned; cpu: s of processor; wall: s; memory: bytes, the most that
    the process that ran it ever held."""

    tree: dict[str, Any]
    cpu_s: float
    wall_s: float
    peak_memory: int


class ResultNotSavedError(Exception):
    """What came of a job could not be written, so that going on would be for nothing. key: the job's; result: None
    where it failed, so that only the reason of that is not on the disk."""

    def __init__(self, why: str, key: str, result: JobResult | None) -> None:
        super().__init__(why, key, result)  # all of them, so that it comes whole from another process
        self.reason, self.key, self.result = why, key, result


@dataclass(frozen=True)
class ResultFolder:
    """The folder that a campaign's results are in: ``KEY.json`` of a job that ended, ``KEY.error`` of one that did
    not, which running again tries once more."""

    folder: Path

    def path(self, key: str) -> Path:
        return self.folder / f"{key}.json"

    def is_done(self, key: str, job: Job) -> bool:
        """Whether the result and whatever else the job writes are there."""
        return self.path(key).is_file() and all(Path(output).is_file() for output in job.outputs)

    def read(self, key: str) -> JobResult:
        """Raises InputError where it is no result."""
        path = self.path(key)
        try:
            tree = json.loads(read_text(path, "result"))
            return JobResult(tree["result"], tree["cpu_s"], tree["wall_s"], tree["memory_bytes"])
        except (ValueError, KeyError, TypeError):
            raise InputError(f"{path}: not a result of a campaign; delete it and run again") from None

    def write(self, key: str, job: Job, result: JobResult) -> None:
        """Raises InputError where it cannot be written."""
        tree = {
            "schema": SCHEMA,
            "job": job.dependencies(),
            "cpu_s": round(result.cpu_s, 3),
            "wall_s": round(result.wall_s, 3),
            "memory_bytes": result.peak_memory,
            "result": result.tree,
        }
        write_atomically(self.path(key), (json.dumps(tree, allow_nan=False) + "\n").encode("utf-8"))
        self._error(key).unlink(missing_ok=True)

    def write_error(self, key: str, text: str) -> None:
        """Keep why a job gave no result. Raises InputError where it cannot be written."""
        write_atomically(self._error(key), text.encode("utf-8", "backslashreplace"))

    def error(self, key: str) -> str | None:
        """Why a job gave no result when it last ran, in a line; None where it was not run or has one."""
        path = self._error(key)
        if self.path(key).is_file() or not path.is_file():
            return None
        return read_text(path, "error").strip().splitlines()[0]

    def _error(self, key: str) -> Path:
        return self.folder / f"{key}.error"
