"""A rig from wherever it is."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from slider_drilling import rig as rig_file
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import Rig, parse_rig, rig_from_tree

WELLS = {"example": "config/rig.example.yaml", "short": "config/rig.short.yaml", "long": "config/rig.long.yaml"}


def load_rig(source: str | os.PathLike[str] | Mapping[str, Any] | None = None) -> Rig:
    """A rig from a rig file's path, its text (more than one line), or its keys and values.

    Without a source, or with ``"example"``, ``"short"`` or ``"long"``: the wells of 4.0, 2.6 and 5.6 km that come
    with the package. Raises InputError naming file, key and value for anything that cannot be used.
    """
    if source is None:
        source = "example"
    if isinstance(source, Mapping):
        return rig_from_tree(dict(source), "rig")
    if isinstance(source, str) and source in WELLS:
        source = installed_file(WELLS[source])
    if isinstance(source, str) and "\n" in source:
        return parse_rig(source, "rig")
    return rig_file.load_rig(source)
