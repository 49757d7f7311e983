"""Run everything and write docs/reference/benchmarks.md."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from string import Template

from slider_drilling.benchmarks import meshes, peers, published, scaling
from slider_drilling.benchmarks.machine import describe
from slider_drilling.benchmarks.result import BenchmarkResult
from slider_drilling.benchmarks.suite import measure

HERE = Path(__file__).parent
BUSY = """\
**Other programs used this machine during the measurement**: wall times are too long and real-time factors too low.
Nanoseconds per element-step are processor time and suffer less."""
PAGE = HERE.parents[1] / "docs" / "reference" / "benchmarks.md"


def main() -> None:
    """Measure everything and write the page; progress goes to stderr."""
    sections = {
        "machine": machine,
        "figures": lambda: figures(measure(lambda stage: print(f"measuring {stage}", file=sys.stderr))),
        "peers": lambda: peers.markdown(peers.compare()),
        "published": lambda: published.markdown(published.compare()),
        "by_elements": lambda: scaling.table("elements", "ns per element-step", scaling.by_elements(), ".2f"),
        "by_runs": lambda: scaling.table("runs", "ns per element-step", scaling.by_runs(), ".2f"),
        "by_threads": lambda: scaling.table("threads", "s", scaling.by_threads(), ".2f"),
        "meshes": lambda: meshes.markdown(meshes.compare()),
        "single_precision": meshes.single_precision,
        "crooked": meshes.crooked,
    }
    filled = {}
    for name, section in sections.items():
        print(f"measuring {name}", file=sys.stderr)
        filled[name] = section()
    text = Template((HERE / "page.md.in").read_text(encoding="utf-8")).substitute(filled)
    PAGE.write_text(text, encoding="utf-8")
    print(f"wrote {PAGE}", file=sys.stderr)


def machine() -> str:
    """The machine as a list, with a warning if it was busy."""
    lines = [f"* {name}: {value}" for name, value in describe().items()]
    if os.getloadavg()[0] > 0.5 * (os.cpu_count() or 1):
        lines += ["", BUSY]
    return "\n".join(lines)


def figures(results: list[BenchmarkResult]) -> str:
    """The results as a table."""
    lines = ["| figure | value | reference | ratio | the reference; how it was measured |", "|---|---|---|---|---|"]
    for result in results:
        value = "-" if result.value is None else f"{result.value:.4g} {result.unit.strip('-')}"
        reference = "" if result.reference is None else f"{result.reference:.4g}"
        ratio = "" if result.ratio is None else f"{result.ratio:.3g}"
        how = "; ".join(filter(None, (result.reference_name, result.note)))
        lines.append(f"| `{result.name}` | {value} | {reference} | {ratio} | {how} |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
