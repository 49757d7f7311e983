"""Start-up time and memory."""

from __future__ import annotations

import subprocess
import sys

from slider_drilling.benchmarks.result import BenchmarkResult
from slider_drilling.benchmarks.timing import wall_seconds

_PEAK = "from slider_drilling.benchmarks.machine import peak_megabytes; print(peak_megabytes())"
_SIMULATED = (
    "from slider_drilling.benchmarks.workload import rocking_commands\n"
    "from slider_drilling.drillstring import simulate\n"
    "from slider_drilling.rig.example import example_rig\n"
    "rig = example_rig(); simulate(rig, rocking_commands(rig, 300.0))\n"
)


def start_up() -> list[BenchmarkResult]:
    """Time of --help, import time of the plant, and peak memory of a 300 s simulation, each in its own process."""
    click = wall_seconds(lambda: _python("-c", "import click"))
    numba = wall_seconds(lambda: _python("-c", "import numba, numpy"))
    return [
        BenchmarkResult("help_s", wall_seconds(lambda: _python("-m", "slider_drilling", "--help")), "s", click,
               "python that imports click"),
        BenchmarkResult("import_s", wall_seconds(lambda: _python("-c", "import slider_drilling.drillstring")), "s",
               numba,
               "python that imports numba and numpy", "the plant, code compiled before"),
        BenchmarkResult("peak_memory", _peak(_SIMULATED), "MB", _peak("import numba, numpy\n"),
               "python that imports numba and numpy", "300 s of the example rig"),
    ]  # fmt: skip


def _peak(program: str) -> float | None:
    answer = _python("-c", program + _PEAK).strip()
    return None if answer == "None" else float(answer)


def _python(*arguments: str) -> str:
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=True).stdout
