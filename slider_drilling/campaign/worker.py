"""The process that jobs run in: reads jobs, one a line, writes their results into files, answers a line for each.

It ends when whoever started it does: its standard input is then closed. An interrupt at the terminal is not its
business; half a result is none.
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

# One thread each: there is a process for every core. Before numpy is imported.
_LIBRARIES = ("OPENBLAS", "OMP", "MKL", "NUMBA")
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in _LIBRARIES}


def as_line(job: Job, key: str, folder: Path) -> str:
    """A job as the worker reads it."""
    return json.dumps({"job": asdict(job), "key": key, "folder": str(folder), "code": code_version()})


def main() -> None:
    """Take jobs until standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    faulthandler.enable()
    # Answers go where standard output went; what a job prints goes to standard error.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    lines: queue.Queue[str] = queue.Queue()
    threading.Thread(target=_read, args=(lines,), daemon=True).start()
    while True:
        print(json.dumps(_answer(lines.get())), file=answers, flush=True)


def _read(lines: queue.Queue[str]) -> None:
    for line in sys.stdin:
        lines.put(line)
    os._exit(0)


def _answer(line: str) -> dict[str, Any]:
    order = json.loads(line)
    tree = order["job"]
    job = Job(**{**tree, "outputs": tuple(tree["outputs"]), "forbidden_folders": tuple(tree["forbidden_folders"])})
    results = ResultFolder(Path(order["folder"]))
    if order["code"] != code_version():
        return {"error": f"this worker runs {code_version()}, the campaign {order['code']}: install the same code"}
    try:
        result = run_job(job)
    except InputError as error:
        return _failed(results, order["key"], str(error), str(error))
    except Exception as error:
        why = f"{type(error).__name__}: {' '.join(str(error).split())}"
        return _failed(results, order["key"], why, traceback.format_exc())
    try:
        results.write(order["key"], job, result)
    except InputError as error:
        return {"unkept": str(error), "result": asdict(result)}
    return {}


def run_job(job: Job) -> JobResult:
    """Run it here and now. Raises what its function raises."""
    began, processor = time.perf_counter(), time.process_time()
    function = job.function()
    with forbid_folders(job.forbidden_folders, (*job.inputs.values(), *job.outputs)):
        tree = function(job)
    return JobResult(tree, time.process_time() - processor, time.perf_counter() - began, _peak_memory())


def _peak_memory() -> int:
    if sys.platform == "win32":
        return 0
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


def _failed(results: ResultFolder, key: str, why: str, full: str) -> dict[str, Any]:
    try:
        results.write_error(key, f"{why}\n\n{full}\n")
    except InputError as error:
        return {"error": f"{why}; and {error}"}
    return {"error": why}


if __name__ == "__main__":
    main()
