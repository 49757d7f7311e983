"""Description of the machine."""

from __future__ import annotations

import os
import platform
from importlib.metadata import version
from pathlib import Path

from slider_drilling.process.peak_memory import peak_bytes


def describe() -> dict[str, str]:
    """Processor, its cores and vector units, memory, system, Python and the libraries that matter."""
    from slider_drilling.process.jit_cache import vector_bits

    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "vectors": f"{vector_bits()} bits",
        "memory": f"{os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2**30:.0f} GiB",
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        **{name: version(name) for name in ("numba", "llvmlite", "numpy", "scipy")},
        "load": "{:.1f} {:.1f} {:.1f} processes over 1, 5 and 15 minutes".format(*os.getloadavg()),
    }


def peak_megabytes() -> float | None:
    """Peak memory of this process, MB; None if the system does not report it."""
    peak = peak_bytes()
    return None if peak is None else peak / 2**20


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:  # no such file outside Linux
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
