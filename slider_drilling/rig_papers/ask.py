"""Questions in a terminal for what a rig file needs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import click

from slider_drilling.errors import InputError
from slider_drilling.rig_papers.sheet import (
    SHEET_KEYS,
    SheetKey,
    read_circulating_pressure,
    read_motor,
    read_mud,
    read_pump,
    read_size,
    read_top_drive,
)
from slider_drilling.rig_papers.template import template_tables
from slider_drilling.schema.quantity_text import read_quantity

_READERS: dict[str, Callable[[str], Any]] = {
    "mud": read_mud,
    "motor": read_motor,
    "pump": read_pump,
    "top_drive": read_top_drive,
    "circulating_pressure": read_circulating_pressure,
    "bit": lambda text: read_size(text, "bit"),
    "hole_diameter": lambda text: read_size(text, "hole_diameter"),
    "casing_shoe": lambda text: read_quantity(text, "m", "casing_shoe"),
    "make_up_torque": lambda text: read_quantity(text, "N m", "make_up_torque"),
    "sample_rate": lambda text: read_quantity(text, "Hz", "sample_rate"),
}


def ask_for_table(what: str, read: Callable[[Path], Any]) -> Path:
    """Ask for a table's path until it can be read."""
    while True:
        path = Path(click.prompt(what, err=True).strip())
        try:
            read(path)
        except InputError as error:
            click.echo(str(error), err=True)
        else:
            return path


def ask_for_sheet(known: Mapping[str, str], units: str) -> dict[str, str]:
    """Ask for every value that is not known; an empty answer leaves one out that is not required.

    Args:
        known: Key -> text.
        units: "field" or "si", of the examples; answers carry their own.
    """
    values = dict(known)
    examples = {row[0]: row[3] for row in template_tables(units)["sheet"]}
    for key in SHEET_KEYS:
        if key.name not in values and (answer := _ask(key, examples[key.name])):
            values[key.name] = answer
    return values


def _ask(key: SheetKey, example: str) -> str:
    hint = f"such as {example}" if key.required else f"such as {example}; empty to leave out"
    while True:
        default = None if key.required else ""
        answer = str(click.prompt(f"{key.question} ({hint})", default=default, show_default=False, err=True)).strip()
        if not answer:
            return ""
        try:
            _READERS.get(key.name, str)(answer)
        except InputError as error:
            click.echo(str(error), err=True)
        else:
            return answer
