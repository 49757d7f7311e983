"""Fuzz tests: `python test/fuzz rigs --cases 1000 --seed 1`.

Bad rigs, tables and plug-ins; commands that are killed or run on full disks. Prints counts of the outcomes and the peak
memory. Exits with 1 if a case neither ran nor was refused in one line. Seed and number reproduce a case.
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
COMMAND_KINDS = {"kills": kills.fuzz, "full_disks": full_disks.fuzz}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=[*KINDS, *COMMAND_KINDS])
    parser.add_argument("--cases", type=int, default=1000, help="kills: of each command with each signal; full_disks: "
                        "of each command")  # fmt: skip
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="kills, full_disks: commands whose name starts with this")
    options = parser.parse_args()
    if options.kind in COMMAND_KINDS:
        sys.exit(COMMAND_KINDS[options.kind](options.cases, options.seed, options.only))
    sys.exit(KINDS[options.kind](options.cases, options.seed))
