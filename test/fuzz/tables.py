"""Bad CSV tables and mapping files. An accepted one must be written as a log and read back."""

from __future__ import annotations

import copy
import random
import tempfile
from pathlib import Path
from typing import Any

import yaml
from tally import Tally

from slider_drilling.log import read_log, save_log
from slider_drilling.table_import import read_table

MAPPING: dict[str, Any] = {
    "schema": "slider_drilling/csv/1",
    "time": {"column": "t", "unit": "s"},
    "channels": {
        "surface_torque": {"column": "torque", "unit": "kN m"},
        "top_drive_speed": {"column": "rpm", "unit": "rpm"},
        "block_position": {"column": "block", "unit": "ft", "sign": -1.0, "from_first": True},
        "standpipe_pressure": {"column": "spp", "unit": "psi"},
        "tool_face": {"column": "tf", "unit": "deg", "on_change": True, "delay": 3.0},
    },
}
CELLS = [
    "",
    "nan",
    "inf",
    "-inf",
    "1e400",
    "1e30",
    "-999.25",
    "x",
    '"',
    '"1',
    "1,5",
    "2024-01-01T00:00:00Z",
    "\x00",
    "µ",
    "9" * 400,
    "1e-320",
    "-",
    " 1 ",
    "0x10",
    "1_0",
    "\x1b[31m",
]
VALUES: list[Any] = [
    None,
    "",
    "x",
    1e30,
    -1,
    10**30,
    [],
    {},
    True,
    "rpm",
    "s",
    "ms",
    "iso8601",
    ";",
    "\t",
    "tt",
    [1, "a"],
    "12:30",
    "1970-01-01",
    "9999-12-31T23:59:59Z",
]


def fuzz(cases: int, seed: int) -> int:
    """Run the cases; returns 1 if one neither ran nor was refused in one line."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder:
        for number in range(cases):
            draw = random.Random(f"table {seed} {number}")
            tally.run(lambda draw=draw: _tried(draw, Path(folder)), f"seed {seed} case {number}")
    return tally.report("tables")


def _tried(draw: random.Random, folder: Path) -> str:
    table, mapping, log = folder / "t.csv", folder / "m.yaml", folder / "o.mcap"
    table.write_bytes(_table(draw))
    mapping.write_bytes(_mapping(draw))
    rows = None if draw.random() < 0.9 else (draw.randint(0, 40), draw.randint(0, 40))
    found = read_table(table, mapping, None, rows)
    save_log(found, log, "fuzz")
    again = read_log(log)
    same = (found.top_drive is None) == (again.top_drive is None)
    return "ran" if same else "not read back"


def _table(draw: random.Random) -> bytes:
    start = draw.choice((0.0, 0.0, 0.0, 1.7e9, 1.7e9, 1.7e12, -5.0, 1e300))
    lines = [["t", "torque", "rpm", "block", "spp", "tf"]]
    for k in range(draw.randint(0, 40)):
        lines.append(
            [f"{start + 0.1 * k}", f"{draw.gauss(10, 3)}", "30", f"{90 - 0.01 * k}", "2500", f"{10 * (k // 9)}"]
        )
    for _ in range(draw.choice((0, 0, 1, 1, 2))):
        row = draw.choice(lines)
        row[draw.randrange(len(row))] = draw.choice(CELLS)
    if draw.random() < 0.05:
        draw.choice(lines).append("1")
    if draw.random() < 0.05:
        draw.shuffle(lines)
    comma = draw.choice((",", ",", ",", ";"))
    content = draw.choice(("\n", "\r\n", "\r")).join(comma.join(row) for row in lines).encode()
    if draw.random() < 0.15:
        at = draw.randrange(len(content) + 1)
        content = (
            content[:at] + draw.choice((b"\xff", b"\x00", b'"', b"\n" * 50, b"")) + content[at + draw.randint(0, 9) :]
        )
    return content


def _mapping(draw: random.Random) -> bytes:
    tree = copy.deepcopy(MAPPING)
    for _ in range(draw.choice((0, 0, 1, 1, 2))):
        node: Any = draw.choice((tree, tree["time"], tree["channels"], *tree["channels"].values()))
        if not isinstance(node, dict) or not node:
            continue
        key = draw.choice((*node, "delimiter", "skip_lines", "null_values", "start", "unit_line", "names", "integral"))
        node[key] = copy.deepcopy(draw.choice(VALUES))
        if not all(isinstance(tree.get(name), dict) for name in ("time", "channels")):
            break
    text = yaml.safe_dump(tree)
    if draw.random() < 0.1:
        at = draw.randrange(len(text))
        text = text[:at] + draw.choice(("[", "{", "'", "\t", ": ", "&a ", "*a", "!!x ")) + text[at:]
    return text.encode()
