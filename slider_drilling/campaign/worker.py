"""The process in which jobs run: it reads one job a line, writes the result into a file, and answers with a line.

It ends with the process that started it, whose end closes its standard input. It ignores an interrupt at the terminal:
the process that started it decides.
"""

from __future__ import annotations

import faulthandler
import json
import os
import queue
import signal
import sys
import threading
import time
import traceback
from dataclasses import asdict
from pathlib import Path
from typing import Any

from slider_drilling.campaign.code_version import code_version
from slider_drilling.campaign.forbidden_folders import forbid_folders
from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import JobResult, ResultFolder
from slider_drilling.errors import InputError
from slider_drilling.process.peak_memory import peak_bytes

# One thread for each library, since there is a process for each core. Libraries read this when they are imported.
_LIBRARIES = ("OPENBLAS", "OMP", "MKL", "NUMBA")
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in _LIBRARIES}


def job_line(job: Job, key: str, folder: Path) -> str:
    """Returns a job as the worker reads it."""
    return json.dumps({"job": asdict(job), "key": key, "folder": str(folder), "code": code_version()})


def main() -> None:
    """Runs jobs until standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    faulthandler.enable()
    # Answers use the original standard output; what a job prints goes to standard error.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    lines: queue.Queue[str] = queue.Queue()
    threading.Thread(target=_read_lines, args=(lines,), daemon=True).start()
    while True:
        print(json.dumps(_answer(lines.get())), file=answers, flush=True)


def _read_lines(lines: queue.Queue[str]) -> None:
    """Passes lines on; at their end it ends the process, also in the middle of a job."""
    for line in sys.stdin:
        lines.put(line)
    os._exit(0)


def _answer(line: str) -> dict[str, Any]:
    """Runs one job. The answer is empty, or says why there is no result or why it is not saved."""
    request = json.loads(line)
    tree = request["job"]
    job = Job(**(tree | {name: tuple(tree[name]) for name in ("outputs", "forbidden_folders")}))
    results = ResultFolder(Path(request["folder"]))
    if request["code"] != code_version():
        return {"error": f"this worker runs {code_version()}, the campaign {request['code']}: install the same code"}
    try:
        result = run_job(job)
    except InputError as error:
        return _failed(results, request["key"], str(error), str(error))
    except Exception as error:
        reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
        return _failed(results, request["key"], reason, traceback.format_exc())
    try:
        results.write(request["key"], job, result)
    except InputError as error:
        return {"not_saved": str(error), "result": asdict(result)}
    return {}


def run_job(job: Job) -> JobResult:
    """Runs a job in this process.

    Raises:
        Exception: Whatever the job's function raises.
    """
    start, cpu_start = time.perf_counter(), time.process_time()
    function = job.function()
    with forbid_folders(job.forbidden_folders, (*job.inputs.values(), *job.outputs)):
        tree = function(job)
    return JobResult(tree, time.process_time() - cpu_start, time.perf_counter() - start, peak_bytes() or 0)


def _failed(results: ResultFolder, key: str, reason: str, details: str) -> dict[str, Any]:
    try:
        results.write_error(key, f"{reason}\n\n{details}\n")
    except InputError as error:
        return {"error": f"{reason}; and {error}"}
    return {"error": reason}


if __name__ == "__main__":
    main()
