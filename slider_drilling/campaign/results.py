"""The results of a campaign: one file per job, complete or absent, named after all that the result depends on."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from slider_drilling.campaign.job import Job, key_of
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text, write_atomically

SCHEMA = "slider_drilling/result/1"
Parsed = TypeVar("Parsed")


@dataclass(frozen=True)
class JobResult:
    """The result of one job.

    Attributes:
        tree: What its function returned.
        cpu_s: Processor time.
        wall_s: Duration.
        peak_memory: Most memory that its process ever held, bytes.
    """

    tree: dict[str, Any]
    cpu_s: float
    wall_s: float
    peak_memory: int


def _result(tree: dict[str, Any]) -> JobResult:
    """Raises ValueError for values that no job gives."""
    result, numbers = tree["result"], (tree["cpu_s"], tree["wall_s"], tree["memory_bytes"])
    if not isinstance(result, dict) or not all(type(value) in (int, float) for value in numbers):
        raise ValueError
    if not all(math.isfinite(value) and value >= 0.0 for value in numbers):
        raise ValueError
    return JobResult(result, *numbers)


class ResultNotSavedError(Exception):
    """The outcome of a job could not be written, so further jobs would be lost too.

    Attributes:
        reason: Why not.
        key: Of the job.
        result: None for a job that failed, where only the reason of the failure is not saved.
    """

    def __init__(self, reason: str, key: str, result: JobResult | None) -> None:
        super().__init__(reason, key, result)  # all three, so that the exception can be pickled
        self.reason, self.key, self.result = reason, key, result


@dataclass(frozen=True)
class ResultFolder:
    """The folder of a campaign's results: ``KEY.json`` of each finished job, ``KEY.error`` of each failed one.

    A failed job is run again by the next campaign.
    """

    folder: Path

    def path(self, key: str) -> Path:
        """Returns the path of a job's result."""
        return self.folder / f"{key}.json"

    def is_done(self, key: str, job: Job) -> bool:
        """Returns whether the result and all other files that the job writes exist."""
        return self.path(key).is_file() and all(Path(output).is_file() for output in job.outputs)

    def read(self, key: str) -> JobResult:
        """Returns a job's result.

        Raises:
            InputError: Its file is not a result, or that of another job.
        """
        return self.parse(key, lambda result: result)

    def parse(self, key: str, parse: Callable[[JobResult], Parsed]) -> Parsed:
        """Returns what a function makes of a job's result.

        Raises:
            InputError: The file is not a result, is that of another job, or does not hold what the function needs.
        """
        path = self.path(key)
        try:
            tree = json.loads(read_text(path, "result"))
            if tree["schema"] != SCHEMA or key_of(tree["job"]) != key:
                raise ValueError
            return parse(_result(tree))
        except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
            raise InputError(f"{path}: not a result of this job; delete it and run again") from None

    def write(self, key: str, job: Job, result: JobResult) -> None:
        """Saves a job's result.

        Raises:
            InputError: The file cannot be written, or an input of the job has changed since the campaign began.
        """
        dependencies = job.dependencies()
        if key_of(dependencies) != key:
            raise InputError(f"{job.name}: an input changed while the job ran; run again")
        tree = {
            "schema": SCHEMA,
            "job": dependencies,
            "cpu_s": round(result.cpu_s, 3),
            "wall_s": round(result.wall_s, 3),
            "memory_bytes": result.peak_memory,
            "result": result.tree,
        }
        write_atomically(self.path(key), (json.dumps(tree, allow_nan=False) + "\n").encode("utf-8"))
        self._error_path(key).unlink(missing_ok=True)

    def write_error(self, key: str, text: str) -> None:
        """Saves why a job failed: one line, then any details.

        Raises:
            InputError: The file cannot be written.
        """
        write_atomically(self._error_path(key), text.encode("utf-8", "backslashreplace"))

    def error(self, key: str) -> str | None:
        """Returns why a job failed when it last ran, in one line; None if it has a result or was not run."""
        path = self._error_path(key)
        if self.path(key).is_file() or not path.is_file():
            return None
        return read_text(path, "error").strip().splitlines()[0]

    def _error_path(self, key: str) -> Path:
        return self.folder / f"{key}.error"
