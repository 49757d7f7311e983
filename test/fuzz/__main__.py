"""Hostile rigs, tables, plug-ins, and commands killed: `python test/fuzz rigs --cases 1000 --seed 1`.

Prints what came of them and ends with 1 where anything but a refusal in one line or a run did. A case is found again by
its seed and number.
"""

from __future__ import annotations

import argparse
import sys

import kills
import plug_ins
import rigs
import tables

KINDS = {"rigs": rigs.fuzz, "tables": tables.fuzz, "plug_ins": plug_ins.fuzz, "kills": kills.fuzz}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--cases", type=int, default=1000, help="of kills: of each command with each signal")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    sys.exit(KINDS[given.kind](given.cases, given.seed))
