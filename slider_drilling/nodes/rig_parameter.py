"""The parameter `rig`, the same for every node that needs the rig file."""

from __future__ import annotations

from pathlib import Path

from slider_drilling.files import read_text
from slider_drilling.nodes.parameters import Declared
from slider_drilling.rig import Rig, parse_rig
from slider_drilling.share import share_file

EXAMPLE = "config/rig.example.yaml"
RIG = Declared("rig", "", "path of the rig file; empty: the 4 km example well")


def rig_of(path: str) -> tuple[Rig, str]:
    """A rig and its file's text, from a path or, where that is empty, from the example. Raises InputError."""
    source = Path(path) if path else share_file(EXAMPLE)
    text = read_text(source, "rig file")
    return parse_rig(text, str(source)), text


def name_of(path: str) -> str:
    """What a rig is called in `diagnostics`: its file's name."""
    return Path(path or "rig.example.yaml").stem
