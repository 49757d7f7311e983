"""Rig files read, checked and written. Nothing else parses rig YAML."""

from __future__ import annotations

import os
from typing import Any

import yaml

from slider_drilling.effects import Effects
from slider_drilling.files.output_files import read_text
from slider_drilling.rig.parts import Rig
from slider_drilling.rig.relations import check_relations
from slider_drilling.schema.fields import build_dataclass, to_tree
from slider_drilling.schema.yaml_tree import parse_yaml

LONGEST = 1_000_000
"""Bytes of a rig file: one with ten thousand stations has half of it."""


def load_rig(path: str | os.PathLike[str]) -> Rig:
    """Read a rig file. Raises InputError naming file, key and value for anything that cannot be used."""
    return parse_rig(read_text(path, "rig file", LONGEST), str(path))


def parse_rig(text: str, source: str = "rig") -> Rig:
    """A rig from YAML text; ``source`` names it in errors. Raises InputError."""
    return rig_from_tree(parse_yaml(text, source), source)


def rig_from_tree(tree: Any, source: str = "rig") -> Rig:
    """A rig from keys and values as YAML gives them; ``source`` names it in errors. Raises InputError."""
    rig = build_dataclass(Rig, tree, source)
    check_relations(rig, source)
    return rig


def check_rig(rig: Rig, source: str = "rig") -> Rig:
    """The rig itself, where it could be read from a file. Raises InputError as `parse_rig` does, else.

    A rig made in code is not checked: fits try numbers that no file may hold, thousands of times a second.
    """
    rig_from_tree(to_tree(rig), source)
    return rig


def dump_rig(rig: Rig) -> str:
    """The rig as YAML that `parse_rig` takes back unchanged; effects that are all neutral are left out."""
    tree = to_tree(rig)
    effects = {name: block for name, block in tree.pop("effects").items() if block != to_tree(getattr(Effects(), name))}
    if effects:
        tree["effects"] = effects
    if not rig.well.name:
        del tree["well"]["name"]
    return yaml.safe_dump({"schema": tree.pop("schema"), **tree}, sort_keys=False)
