"""The page of the engine's constants lists every number at the head of a module, with its value."""

from __future__ import annotations

import ast
import importlib
import re
from pathlib import Path

import numpy as np

import slider_drilling.gap
from slider_drilling.benchmarks.sensitivity import CONSTANTS

_PACKAGE = Path(slider_drilling.gap.__file__).parent
_PAGE = Path(__file__).parents[2] / "docs" / "design" / "engine_constants.md"


def _listed() -> tuple[dict[str, list[str]], set[str]]:
    """The cells of each constant of the table, and the names of the mere tolerances below it."""
    section = _PAGE.read_text(encoding="utf-8").partition("## Every number of the engine")[2].partition("\n## ")[0]
    table, _, tolerances = section.partition("Mere numerical")
    rows = {match[1]: match[0].split(" | ")[1:] for match in re.finditer(r"^\| `([\w.]+)` \|.*$", table, re.MULTILINE)}
    return rows, set(re.findall(r"`([\w.]+)`", tolerances))


def _numbers() -> dict[str, object]:
    """Every name at the head of a module whose value is made of numbers."""
    found: dict[str, object] = {}
    for file in sorted(_PACKAGE.rglob("*.py")):
        name = ".".join(file.relative_to(_PACKAGE).with_suffix("").parts)
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if not isinstance(node, (ast.Assign, ast.AnnAssign)) or node.value is None or not _has_number(node.value):
                continue
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            module = importlib.import_module(f"slider_drilling.gap.{name}")
            for each in target.elts if isinstance(target, ast.Tuple) else [target]:
                assert isinstance(each, ast.Name)
                value = getattr(module, each.id)
                if isinstance(value, (int, float, np.ndarray)) or _is_of_numbers(value):
                    found[f"{name}.{each.id}"] = value
    return found


def _has_number(node: ast.AST) -> bool:
    constants = [each.value for each in ast.walk(node) if isinstance(each, ast.Constant)]
    return any(isinstance(value, (int, float)) and not isinstance(value, bool) for value in constants)


def _is_of_numbers(value: object) -> bool:
    """Whether this is a tuple of numbers, or of rounds of a search: all that hold more than text."""
    return isinstance(value, tuple) and not all(isinstance(each, str) for each in value) and not any(
        hasattr(each, "message") for each in value
    )  # fmt: skip


def test_every_number_is_listed_once() -> None:
    rows, tolerances = _listed()
    assert not rows.keys() & tolerances
    assert rows.keys() | tolerances == _numbers().keys()
    assert all(len(cells) == 3 and all(cell.strip(" |") for cell in cells) for cells in rows.values())


def test_listed_values_are_those_of_the_engine() -> None:
    numbers = _numbers()
    for name, (value, *_) in _listed()[0].items():
        number = numbers[name]
        assert value == (f"{number:.3g}" if isinstance(number, (int, float)) else "list"), name


def test_what_is_said_to_be_varied_is() -> None:
    varied = {f"{constant.module}.{constant.name}" for constant in CONSTANTS}
    assert varied == {name for name, cells in _listed()[0].items() if "varied above" in cells[2]}
