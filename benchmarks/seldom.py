"""What the diagnosis makes of logs whose samples come seldom: ``python -m benchmarks.seldom EVERY LOG...``.

Of every series of a rig's, but the rare MWD tool-face, one of EVERY samples is kept; one row of markdown a log.
"""

from __future__ import annotations

import sys
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from slider_drilling.diagnosis.diagnose import diagnose
from slider_drilling.diagnosis.tree import as_json
from slider_drilling.log import RigLog, read_log

_SERIES = ("top_drive", "draw_works", "mud_pump", "standpipe_pressure")


def main(every: int, logs: list[Path]) -> None:
    """Print the rows as they come."""
    print(f"| log, one of {every} samples kept | said | E as given | re-tuned | with it |\n|---|---|---|---|---|")
    for path in logs:
        log = thinned(read_log(path), every)
        tree = as_json(diagnose([log], log.rig()))
        said = " and ".join([*tree["effects"], *(["unknown"] if "unknown" in tree["verdict"] else [])])
        sizes = [tree["gap"][name] for name in ("nominal", "tuned", "with_effect")]
        cells = ["" if size is None else f"{size:.2f}" for size in sizes]
        print(f"| `{path.stem}` | {said or tree['verdict']} | {' | '.join(cells)} |", flush=True)


def thinned(log: RigLog, every: int) -> RigLog:
    """The log with one of so many samples of each series."""
    kept: dict[str, Any] = {}
    for name in _SERIES:
        series = getattr(log, name)
        if series is not None:
            some = {field.name: getattr(series, field.name)[::every] for field in fields(series)}
            kept[name] = replace(series, **some)
    return replace(log, **kept)


if __name__ == "__main__":
    main(int(sys.argv[1]), [Path(argument) for argument in sys.argv[2:]])
