"""No module of the package imports itself by way of others, not even inside functions."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
from scipy.sparse.csgraph import connected_components

PACKAGE = Path(__file__).resolve().parent.parent / "slider_drilling"


def module_name(file: Path) -> str:
    return ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")


def imported(file: Path, modules: set[str]) -> set[str]:
    """The package's modules that a file imports; `from package import name` is the module where name is one."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= names & modules if names <= modules else {node.module, *(names & modules)}
    return found & modules


def test_modules_import_each_other_in_one_direction() -> None:
    files = {module_name(file): file for file in sorted(PACKAGE.rglob("*.py"))}
    names = list(files)
    graph = np.zeros((len(names), len(names)), dtype=bool)
    for row, name in enumerate(names):
        for other in imported(files[name], set(names)):
            graph[row, names.index(other)] = True
    _, group = connected_components(graph, directed=True, connection="strong")
    circles = [[names[k] for k in np.flatnonzero(group == number)] for number in np.unique(group)]
    assert [circle for circle in circles if len(circle) > 1] == []
