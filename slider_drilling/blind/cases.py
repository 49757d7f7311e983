"""The cases of a blind check: balanced over effects, sizes, wells and manoeuvres from the first few on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
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

NO_EFFECT = "none"
SIZES = (0.5, 1.5, 4.0)
SIZE_TOLERANCE = 1.1
"""Factor within which a sealed log reaches its target size."""
MIN_SIZE_OF_TWO = 1.5
"""Smallest size of two effects in one log: a smaller one can hardly be identified beside another."""
DURATION_S = 400.0
PLANTS = ("foreign", "model")
"""What a sealed plant is: of foreign structure (`blind.foreign`), or our equations on another mesh."""
# Of twenty cases twelve have one effect, three a law outside the catalogue, three none and two have two effects.
_KINDS = ("single", "outside", "single", "none", "single", "single", "two", "single", "outside", "single",
          "single", "none", "single", "outside", "single", "single", "two", "single", "none", "single")  # fmt: skip
_NAMES_OF_KIND = {
    "single": tuple(CATALOGUE_LAWS), "outside": tuple(OUTSIDE_LAWS), "none": (NO_EFFECT,), "two": tuple(CATALOGUE_LAWS),
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """One sealed log to be made.

    Attributes:
        effects: One or two names; ``none`` for no effect.
        size: Target size of each effect alone, in noise floors.
        well: Name in `WELLS`.
        manoeuvre: Name in `MANOEUVRES`.
        seed: Of everything that is drawn.
        duration: Of the run, s.
        log_defect: Name in `LOG_DEFECTS`.
        plant: Name in `PLANTS`.
    """

    effects: tuple[str, ...]
    size: float
    well: str
    manoeuvre: str
    seed: int
    duration: float = DURATION_S
    log_defect: str = NO_DEFECT
    plant: str = "model"

    @property
    def kind(self) -> str:
        """``none``, ``single``, ``outside`` or ``two``."""
        if len(self.effects) == 2:
            return "two"
        name = self.effects[0] if self.effects else NO_EFFECT
        return "none" if name == NO_EFFECT else "single" if name in CATALOGUE_LAWS else "outside"

    def to_json(self) -> dict[str, Any]:
        """Returns the fields as JSON holds them."""
        return {**asdict(self), "effects": list(self.effects)}

    def file_stem(self) -> str:
        """Returns a name for the case's files that does not reveal its content."""
        return hashlib.sha256(json.dumps(self.to_json()).encode()).hexdigest()[:10]


def case_from_json(tree: Mapping[str, Any]) -> Case:
    """Returns the case that `Case.to_json` gave."""
    return Case(**{**tree, "effects": tuple(tree["effects"])})


@dataclass(frozen=True)
class CasePlan:
    """What cases are drawn from.

    Attributes:
        effects: Names of effects, ``none`` or ``two``; empty for all.
        sizes: Target sizes, in noise floors.
        wells: Names in `WELLS`.
        manoeuvres: Names in `MANOEUVRES`.
        seed: Another seed gives other wells, nuisance parameters, noise and forms of every law.
        duration: Of each run, s.
        log_defects: Names in `LOG_DEFECTS`, used in turn.
        plants: Names in `PLANTS`, used in turn.

    Raises:
        InputError: A name is unknown, or a number out of range.
    """

    effects: tuple[str, ...] = ()
    sizes: tuple[float, ...] = SIZES
    wells: tuple[str, ...] = DEFAULT_WELLS
    manoeuvres: tuple[str, ...] = tuple(MANOEUVRES)
    seed: int = 1
    duration: float = DURATION_S
    log_defects: tuple[str, ...] = (NO_DEFECT,)
    plants: tuple[str, ...] = ("foreign",)

    def __post_init__(self) -> None:
        _check_names("--effects", self.effects, [*CATALOGUE_LAWS, *OUTSIDE_LAWS, NO_EFFECT, "two"])
        _check_names("--wells", self.wells, WELLS)
        for option, names, known in (
            ("--manoeuvres", self.manoeuvres, MANOEUVRES), ("--log-defects", self.log_defects, LOG_DEFECTS),
            ("--plants", self.plants, PLANTS),
        ):  # fmt: skip
            _check_names(option, names, known)
            if not names:
                raise InputError(f"{option}: give at least one of {', '.join(known)}")
        if not self.sizes or not all(0.05 <= size <= 50.0 for size in self.sizes):
            raise InputError(f"--sizes {','.join(map(str, self.sizes))}: each must be 0.05 to 50 noise floors")
        if not 60.0 <= self.duration <= 3600.0:
            raise InputError(f"--duration {self.duration:g}: must be 60 to 3600 s")


def _check_names(option: str, names: Sequence[str], known: Sequence[str] | Mapping[str, Any]) -> None:
    for name in names:
        if name not in known:
            raise InputError(f"{option} {name}: unknown; use {', '.join(known)}")


def draw_cases(plan: CasePlan, count: int) -> list[Case]:
    """Returns the plan's first `count` cases. A larger count starts with the same cases."""
    return list(islice(_cases(plan), count))


def _cases(plan: CasePlan) -> Iterator[Case]:
    kinds = [kind for kind in _KINDS if _names(plan, kind)]
    names_of_kind = {kind: _shuffled(_names(plan, kind), plan.seed, salt) for salt, kind in enumerate(_NAMES_OF_KIND)}
    # Each kind takes sizes, wells, manoeuvres and defects in an order of its own, so that no effect meets only one.
    sizes: dict[str, Iterator[float]] = {}
    wells: dict[str, Iterator[str]] = {}
    manoeuvres: dict[str, Iterator[str]] = {}
    defects: dict[str, Iterator[str]] = {}
    plants: dict[str, Iterator[str]] = {}
    number = 0
    while True:
        for kind in kinds:
            names = tuple(dict.fromkeys(next(names_of_kind[kind]) for _ in range(2 if kind == "two" else 1)))
            size = next(sizes.setdefault(kind + names[0], _shuffled(plan.sizes, plan.seed, sum(names[0].encode()))))
            size = 0.0 if kind == "none" else max(size, MIN_SIZE_OF_TWO) if kind == "two" else size
            well = next(wells.setdefault(kind, _shuffled(plan.wells, plan.seed, 1000 + len(kind))))
            manoeuvre = next(manoeuvres.setdefault(kind, _shuffled(plan.manoeuvres, plan.seed, 2000 + len(kind))))
            defect = next(defects.setdefault(kind, _shuffled(plan.log_defects, plan.seed, 3000 + len(kind))))
            plant = next(plants.setdefault(kind, _shuffled(plan.plants, plan.seed, 4000 + len(kind))))
            yield Case(names, size, well, manoeuvre, 10000 * plan.seed + number, plan.duration, defect, plant)
            number += 1


def _names(plan: CasePlan, kind: str) -> tuple[str, ...]:
    wanted = plan.effects
    if kind == "two":
        return _NAMES_OF_KIND[kind] if not wanted or "two" in wanted else ()
    return tuple(name for name in _NAMES_OF_KIND[kind] if not wanted or name in wanted)


def _shuffled(values: Sequence[Any], seed: int, salt: int) -> Iterator[Any]:
    """Yields all values in a random order, then all in another order, without end."""
    generator = np.random.default_rng([seed, salt])
    while values:
        for index in generator.permutation(len(values)):
            yield values[index]
