"""Which cases a blind check holds: balanced over effects, sizes, wells and manoeuvres from the first few on."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import islice
from typing import Any

import numpy as np

from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS
from slider_drilling.blind.log_defects import LOG_DEFECTS, NO_DEFECT
from slider_drilling.blind.manoeuvres import MANOEUVRES
from slider_drilling.blind.outside_laws import OUTSIDE_LAWS
from slider_drilling.blind.wells import DEFAULT_WELLS, WELLS
from slider_drilling.errors import InputError

NONE = "none"
SIZES = (0.5, 1.5, 4.0)
SIZE_TOLERANCE = 1.1
"""Factor within which a log is of the size that was asked for."""
DURATION_S = 400.0
# Of twenty cases: one catalogue effect, no effect, one from outside, two effects.
_KINDS = ("single", "outside", "single", "none", "single", "single", "two", "single", "outside", "single",
          "single", "none", "single", "outside", "single", "single", "two", "single", "none", "single")  # fmt: skip
_MADE_OF = {
    "single": tuple(CATALOGUE_LAWS),
    "outside": tuple(OUTSIDE_LAWS),
    "none": (NONE,),
    "two": tuple(CATALOGUE_LAWS),
}


@dataclass(frozen=True)
class Case:
    """One sealed log to be made. effects: none, one or two names; size: noise floors, of each effect alone; lacking:
    what its recorder leaves out."""

    effects: tuple[str, ...]
    size: float
    well: str
    manoeuvre: str
    seed: int
    duration: float = DURATION_S
    log_defect: str = NO_DEFECT

    @property
    def kind(self) -> str:
        """``none``, ``single``, ``outside`` or ``two``."""
        if len(self.effects) == 2:
            return "two"
        name = self.effects[0] if self.effects else NONE
        return "none" if name == NONE else "single" if name in CATALOGUE_LAWS else "outside"

    def to_json(self) -> dict[str, Any]:
        return {**asdict(self), "effects": list(self.effects)}

    def file_stem(self) -> str:
        """A name for its files that says nothing of it."""
        return hashlib.sha256(repr(self).encode()).hexdigest()[:10]


def case_from_json(tree: dict[str, Any]) -> Case:
    """The case that `Case.tree` gave."""
    return Case(**{**tree, "effects": tuple(tree["effects"])})


@dataclass(frozen=True)
class CasePlan:
    """What cases are drawn from. effects: names wanted, empty: all; sizes: noise floors; seed: another one gives
    other wells, nuisance, noise and forms of every law; lacking: what logs lack, in turn."""

    effects: tuple[str, ...] = ()
    sizes: tuple[float, ...] = SIZES
    wells: tuple[str, ...] = DEFAULT_WELLS
    manoeuvres: tuple[str, ...] = tuple(MANOEUVRES)
    seed: int = 1
    duration: float = DURATION_S
    log_defects: tuple[str, ...] = (NO_DEFECT,)

    def __post_init__(self) -> None:
        _only_known("--effects", self.effects, [*CATALOGUE_LAWS, *OUTSIDE_LAWS, NONE, "two"])
        _only_known("--wells", self.wells, WELLS)
        _only_known("--manoeuvres", self.manoeuvres, MANOEUVRES)
        _only_known("--lacking", self.log_defects, LOG_DEFECTS)
        for option, names, known in (
            ("--manoeuvres", self.manoeuvres, MANOEUVRES),
            ("--lacking", self.log_defects, LOG_DEFECTS),
        ):
            if not names:
                raise InputError(f"{option}: give one at least of {', '.join(known)}")
        if not self.sizes or not all(0.05 <= size <= 50.0 for size in self.sizes):
            raise InputError(f"--sizes {','.join(map(str, self.sizes))}: each must be within 0.05 to 50 noise floors")
        if not 60.0 <= self.duration <= 3600.0:
            raise InputError(f"--duration {self.duration:g}: must be within 60 to 3600 s")


def _only_known(option: str, names: Sequence[str], known: Sequence[str] | dict[str, Any]) -> None:
    for name in names:
        if name not in known:
            raise InputError(f"{option} {name}: not one of {', '.join(known)}")


def draw_cases(plan: CasePlan, count: int) -> list[Case]:
    """The plan's first ``count`` cases; more of them begin with the same ones."""
    return list(islice(_cases(plan), count))


def _cases(plan: CasePlan) -> Iterator[Case]:
    kinds = [kind for kind in _KINDS if _names(plan, kind)]
    turns = {kind: _shuffled(_names(plan, kind), plan.seed, index) for index, kind in enumerate(_MADE_OF)}
    sizes: dict[str, Iterator[float]] = {}
    # Effects take wells and manoeuvres in turn, each in its own order, so that no effect meets only one of them.
    wells: dict[str, Iterator[str]] = {}
    ways: dict[str, Iterator[str]] = {}
    lacks: dict[str, Iterator[str]] = {}
    number = 0
    while True:
        for kind in kinds:
            names = tuple(dict.fromkeys(next(turns[kind]) for _ in range(2 if kind == "two" else 1)))
            first = names[0]
            salt = sum(first.encode())
            size = next(sizes.setdefault(kind + first, _shuffled(plan.sizes, plan.seed, salt)))
            # Two effects at once are asked about where each of them can be told.
            size = max(size, 1.5) if kind == "two" else size
            well = next(wells.setdefault(kind, _shuffled(plan.wells, plan.seed, 1000 + len(kind))))
            way = next(ways.setdefault(kind, _shuffled(plan.manoeuvres, plan.seed, 2000 + len(kind))))
            lacking = next(lacks.setdefault(kind, _shuffled(plan.log_defects, plan.seed, 3000 + len(kind))))
            yield Case(
                names, 0.0 if kind == "none" else size, well, way, 10000 * plan.seed + number, plan.duration, lacking
            )
            number += 1


def _names(plan: CasePlan, kind: str) -> tuple[str, ...]:
    wanted = plan.effects
    if kind == "two":
        return _MADE_OF[kind] if not wanted or "two" in wanted else ()
    return tuple(name for name in _MADE_OF[kind] if not wanted or name in wanted)


def _shuffled(values: Sequence[Any], seed: int, salt: int) -> Iterator[Any]:
    """All of them in one order, then all in another, for ever."""
    generator = np.random.default_rng([seed, salt])
    while values:
        for index in generator.permutation(len(values)):
            yield values[index]
