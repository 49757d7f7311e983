"""The ranges of a rig file's numbers as a table, made from the schema that checks them."""

from __future__ import annotations

from slider_drilling.rig.rig_file import Rig
from slider_drilling.schema.fields import NumberField, number_fields

HEAD = ("key", "unit", "range", "default", "reason for the range")


def ranges_table() -> list[tuple[str, ...]]:
    """One row of `HEAD` for every number of the rig file."""
    return [
        (row.key, row.range.unit, str(row.range), _default(row), row.range.why)
        for row in number_fields(Rig)
    ]


def _default(row: NumberField) -> str:
    if row.default is None:
        return "may be left out" if row.optional else ""
    return f"{row.default:g}"


def ranges_markdown() -> str:
    """The table as Markdown, for the documentation."""
    lines = [HEAD, ("---",) * len(HEAD), *((f"`{row[0]}`", *row[1:]) for row in ranges_table())]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


if __name__ == "__main__":
    print(ranges_markdown(), end="")
