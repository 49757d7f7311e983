"""The parameter `rig`, the same in every node that needs a rig file."""

from __future__ import annotations

from pathlib import Path

from slider_drilling.files.installed_files import installed_file
from slider_drilling.files.output_files import read_text
from slider_drilling.log import read_log
from slider_drilling.nodes.parameters import NodeParameter
from slider_drilling.rig import Rig, parse_rig

EXAMPLE = "config/rig.example.yaml"
RIG_PARAMETER = NodeParameter("rig", "", "path of the rig file, or of a log that has one; empty: the 4 km example well")


def read_rig(path: str) -> tuple[Rig, str]:
    """A rig and the text of its file; an empty path stands for the example. Raises InputError."""
    source = Path(path) if path else installed_file(EXAMPLE)
    if source.suffix == ".mcap" or source.is_dir():
        log = read_log(source)
        return log.rig(), log.rig_text or ""
    text = read_text(source, "rig file")
    return parse_rig(text, str(source)), text


def rig_name(path: str) -> str:
    """The rig file's name without suffix, which identifies the rig in `diagnostics`."""
    return Path(path or "rig.example.yaml").stem
