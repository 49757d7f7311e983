"""The reference of a programme's file, from the schema that checks it."""

from __future__ import annotations

import inspect

from slider_drilling.files.installed_files import installed_file
from slider_drilling.programmes.find_programme import BUILT_IN
from slider_drilling.programmes.limits import StepLimits
from slider_drilling.programmes.programme import programme_numbers
from slider_drilling.programmes.steps import ACTIONS
from slider_drilling.rig.ranges_table import HEAD
from slider_drilling.schema.fields import NumberField

INTRODUCTION = """\
# Programme

One YAML file: a list of steps that a crew or a rig computer follows, each within its limits.
[How to write one](../how_to/programmes.md). Numbers are SI and radians; a unit may stand beside a number (`speed: 60
rpm`, `flow: 29 L/s`, `tool_face: 30 deg`). A key that is unknown or missing, and a number outside its range, is refused
with one line that names file, key, value and what to do.

`schema: slider_drilling/programme/1` is the first line. `name` and `about` are text for pages and logs. A step is one
key of those below; beside it may stand `limits`, which replace those of the programme for this step, and a `note`.

"""


DEFAULTS = """\
What neither step nor programme gives holds from the rig file: 25 kN m to the right and 15 kN m to the left, or 90 % of
the weakest connection and of the top drive; 85 % of the motor's largest pressure, as weight and above circulation; 30
degrees of toolface.

"""


def programme_page() -> str:
    """The page as Markdown."""
    rows = list(programme_numbers())
    parts = [INTRODUCTION, "## The whole programme\n\n", _table([row for row in rows if "[]" not in row.key])]
    parts.append(f"\n{_about(StepLimits)}\n\n{DEFAULTS}")
    for key, kind in ACTIONS.items():
        own = [row for row in rows if row.key.startswith(f"steps[].{key}.")]
        parts.append(f"## `{key}`\n\n{_about(kind)}\n\n{_table(own)}\n")
    for name, path in BUILT_IN.items():
        text = installed_file(path).read_text(encoding="utf-8")
        parts.append(f"## Example: {name}\n\n`{path}`, or `--programme {name}`:\n\n```yaml\n{text}```\n\n")
    return "".join(parts)


def _about(kind: type) -> str:
    """Its docstring, the attributes as a list."""
    text = inspect.getdoc(kind) or ""
    said, _, attributes = text.partition("Attributes:")
    names = [line.strip() for line in attributes.splitlines() if line.strip()]
    listed = "\n".join(f"* `{name}`:{rest}" for name, _, rest in (line.partition(":") for line in names))
    return f"{said.strip()}\n\n{listed}".strip()


def _table(rows: list[NumberField]) -> str:
    lines = [HEAD, ("---",) * len(HEAD)]
    for row in rows:
        default = f"{row.default:g}" if row.default is not None else "may be left out" if row.optional else ""
        lines.append((f"`{row.key}`", row.range.unit, str(row.range), default, row.range.why))
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
