"""Bad rig files: extreme numbers, wrong types, missing, doubled or misspelt keys, damaged text."""

from __future__ import annotations

import copy
import random
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from tally import Tally

from slider_drilling.control import SlideController
from slider_drilling.drillstring import VirtualRig
from slider_drilling.rig import Rig, dump_rig, parse_rig, rig_from_tree
from slider_drilling.rig.rig_file import Rig as Parts
from slider_drilling.schema.fields import number_fields

EXAMPLE = (Path(__file__).parents[2] / "config" / "rig.example.yaml").read_text()
TREE = yaml.safe_load(EXAMPLE)
NUMBERS = [row for row in number_fields(Parts) if not row.key.startswith("well.survey")]
WILD: list[Any] = [
    0,
    -1,
    1e-300,
    1e300,
    10**400,
    float("nan"),
    float("inf"),
    True,
    None,
    "12:30",
    "x",
    [],
    {},
    [[1]],
    -0.0,
    1e-12,
    1e9,
    "1e5",
    "[/x]",
    "\x1b[31m",
]
TORN = [
    "[",
    "{",
    "&a [*a]",
    "*b",
    "<<: {a: 1}",
    "!!int ",
    "\t",
    "'",
    '"',
    "? ",
    "- ",
    ": ",
    "#",
    "\x00",
    "%YAML 9\n",
    "9" * 400,
    "2024-13-45",
    "\u202e",
    "0x",
    "1_0",
    ".nan",
    "---\n",
]


def fuzz(cases: int, seed: int) -> int:
    """Run the cases; returns 1 if one neither ran nor was refused in one line."""
    tally = Tally()
    for number in range(cases):
        draw = random.Random(f"rig {seed} {number}")
        kind = draw.choice((_within, _within, _wild, _torn))
        tally.run(lambda kind=kind, draw=draw: _used(kind(draw), draw), f"seed {seed} case {number} {kind.__name__}")
    return tally.report("rigs")


def _within(draw: random.Random) -> Rig:
    """Change several numbers within their ranges, limits included."""
    tree = copy.deepcopy(TREE)
    for row in draw.sample(NUMBERS, draw.randint(1, 6)):
        limits = row.range
        low, high = max(limits.at_least, limits.above), min(limits.at_most, limits.below)
        value = draw.choice(
            (
                low,
                high,
                draw.uniform(low, high),
                draw.uniform(low, high),
                low + (high - low) * 10.0 ** draw.uniform(-9.0, 0.0),
            )
        )
        _set(tree, row.key, value)
    return rig_from_tree(tree)


def _wild(draw: random.Random) -> Rig:
    """Replace any value by any other."""
    tree = copy.deepcopy(TREE)
    tree["effects"] = {"stribeck": {"drop": 0.3}, "cuttings_bed": {"factor": 2.0, "top": 100.0, "bottom": 900.0}}
    for _ in range(draw.randint(1, 3)):
        node: Any = tree
        for _ in range(draw.randint(0, 4)):
            key = draw.choice(list(node) if isinstance(node, dict) else range(len(node)))
            if not isinstance(node[key], (dict, list)) or not node[key]:
                break
            node = node[key]
        key = draw.choice(list(node) if isinstance(node, dict) else range(len(node)))
        if isinstance(node, dict) and draw.random() < 0.2:
            node[f"{key}x"] = node.pop(key)
        elif isinstance(node[key], float) and draw.random() < 0.5:
            node[key] *= draw.choice((-1.0, 1e-3, 1e3, 1e6, 57.3, 0.3048, 2.0))
        else:
            node[key] = copy.deepcopy(draw.choice(WILD))
    return rig_from_tree(tree)


def _torn(draw: random.Random) -> Rig:
    """Cut, double and insert pieces of the text."""
    text = EXAMPLE
    for _ in range(draw.randint(1, 3)):
        at, end = sorted(draw.randrange(len(text)) for _ in range(2))
        end = min(end, at + 60)
        piece = draw.choice((draw.choice(TORN) * draw.choice((1, 1, 1, 2000)), "", text[at:end] * 2))
        text = text[:at] + piece + text[end:]
    return parse_rig(text)


def _used(rig: Rig, draw: random.Random) -> str:
    """Write an accepted rig, read it back, and run it under the controller."""
    if draw.random() < 0.1 and parse_rig(dump_rig(rig)) != rig:
        return "not read back"
    plant = VirtualRig(rig, seed=1, elements=20)
    controller = SlideController(rig)
    measured = plant.measurements
    for _ in range(20):
        measured = plant.step(controller.step(measured))
    channels = (measured.surface_torque, measured.hook_load, measured.standpipe_pressure, plant.truth.tool_face)
    return "ran" if np.all(np.isfinite(channels)) else "not finite"


def _set(tree: dict[str, Any], key: str, value: float) -> None:
    node: Any = tree
    *way, name = key.replace("[]", "").split(".")
    for part in way:
        node = node.setdefault(part, {})
        node = node[0] if isinstance(node, list) else node
    node[name] = value
