"""The rig file's reference, from the schema that checks it."""

from __future__ import annotations

import dataclasses
import inspect

from slider_drilling.effects import Effects
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import Rig
from slider_drilling.rig.ranges_table import HEAD, ranges_table

INTRODUCTION = """\
# Rig file

One YAML file says everything that a simulation needs. Numbers are SI; the survey's angles are degrees. Floats with an
exponent are written `2.06e+11`: YAML reads `2.06e11` as text. A key that is unknown or missing, and a number outside
its range, is refused with one line that names file, key, value and what to do.

A unit may stand beside a number: `density: 9.6 ppg`, `displacement: 0.28 rev/gal`, `diameter: 8.5 in`. The same holds
for `--set`. A mud density of 9.6 without its unit is asked about, not taken as kg/m3.

A number that stands on no paper may be marked as assumed, with its spread, one standard deviation in its unit or in
%: `leak: {value: 0.15, spread: 0.05, assumed: true, why: motors of this size}`. The diagnosis takes the spread as its
prior.

A key without a default has to be there, unless it may be left out. `schema: slider_drilling/rig/1` is the first line
of every file. Text:
`well.name` is what pages call the well; `string.sections[].name` is for you. Rows of `well.survey` are measured depth
m, inclination deg, azimuth deg, joined by minimum curvature; the sections' lengths, from the surface down, add up to
the bit's depth.

"""


def rig_page() -> str:
    """The page as Markdown."""
    blocks = [field.name for field in dataclasses.fields(Rig) if field.name != "schema"]
    rows = ranges_table()
    parts = [INTRODUCTION]
    for name in blocks:
        own = [row for row in rows if row[0].startswith((f"{name}.", f"{name}["))]
        if own:
            parts.append(f"## `{name}`\n\n{_about(name)}{_table(own)}\n")
    example = installed_file("config/rig.example.yaml").read_text(encoding="utf-8")
    said = "`config/rig.example.yaml`, the well of every example here:"
    parts.append(f"## An example\n\n{said}\n\n```yaml\n{example}```\n")
    return "".join(parts)


def _about(name: str) -> str:
    if name == "effects":
        return ("Optional; every effect is off until it is named. [Effects](effects.md) has their laws. "
                f"There are {len(dataclasses.fields(Effects))} of them.\n\n")  # fmt: skip
    kind = inspect.get_annotations(Rig, eval_str=True)[name]
    text = inspect.getdoc(kind) or ""
    return "" if text.startswith(f"{kind.__name__}(") else f"{text}\n\n"


def _table(rows: list[tuple[str, ...]]) -> str:
    lines = [HEAD, ("---",) * len(HEAD)]
    lines += [(f"`{row[0]}`", *(cell.replace("|", "\\|") for cell in row[1:])) for row in rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
