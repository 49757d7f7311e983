"""Hostile rigs, tables, plug-ins; commands killed, and on full disks: `python test/fuzz rigs --cases 1000 --seed 1`.

Prints what came of them, and the most memory that it took; ends with 1 where anything but a refusal in one line or a
run did. A case is found again by its seed and number.
"""

from __future__ import annotations

import argparse
import sys

import full_disks
import kills
import plug_ins
import rigs
import tables

KINDS = {"rigs": rigs.fuzz, "tables": tables.fuzz, "plug_ins": plug_ins.fuzz}
OF_COMMANDS = {"kills": kills.fuzz, "full_disks": full_disks.fuzz}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=[*KINDS, *OF_COMMANDS])
    parser.add_argument("--cases", type=int, default=1000, help="kills: of each command with each signal; full_disks: "
                        "of each command")  # fmt: skip
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="kills, full_disks: commands whose name begins so")
    given = parser.parse_args()
    if given.kind in OF_COMMANDS:
        sys.exit(OF_COMMANDS[given.kind](given.cases, given.seed, given.only))
    sys.exit(KINDS[given.kind](given.cases, given.seed))
