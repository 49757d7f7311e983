"""`vector_env`: many slides at once, for training controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import TYPE_CHECKING

from slider_drilling.api.checks import check_elements, check_seed
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import Rig, load_rig

if TYPE_CHECKING:
    from slider_drilling.training.vector_environment import VectorSlideEnvironment

MAX_SLOTS = 100_000
DRAWN = 256  # drawn rigs at most unless asked for more: drawing one takes 10 to 20 ms


def vector_env(
    n: int,
    rig: Rig | Sequence[Rig] | None = None,
    *,
    seed: int = 0,
    drawn: int | None = None,
    effects: bool | Sequence[str] = True,
    foreign: float = 0.0,
    duration: float = 900.0,
    samples: int = 10,
    elements: int = 40,
    actions: str = "speed",
    autoreset: str = "next_step",
    threads: int | None = None,
) -> VectorSlideEnvironment:
    """Many slides at once as a gymnasium vector environment (extra ``gym``).

    Each is a virtual rig: plant, drives, sensors, MWD with its delay, losses and noise. `VectorSlideEnvironment` says
    what actions, observations and rewards are.

    Args:
        n: Number of slots, each with a rig of its own.
        rig: Rig that wells, strings and fluids are drawn around, by default that of the package; or several rigs, which
            are then used exactly as they are.
        seed: Rig k is that of slide k of ``closed-loop --campaign`` with this seed.
        drawn: Number of different rigs; by default `n`, at most 256. Each episode takes one of them at random.
        effects: Whether rigs have effects of the catalogue that their file lacks, or which ones.
        foreign: Share of rigs whose plant is of foreign structure: another friction law, tool joints, bending
            stiffness, a drive with a speed loop. Five times slower.
        duration: Of an episode, s.
        samples: Of the sensors, that an action holds for: 10 are a second at the 10 Hz of the package's rig.
        elements: Elements of each string.
        actions: ``speed`` (of top drive and block) or ``command`` (all that a controller commands).
        autoreset: ``next_step``, ``same_step`` or ``disabled``, as in gymnasium.
        threads: How many step the rigs; by default all that are idle. Their number changes no bit of the result.

    Raises:
        InputError: An argument cannot be used, or gymnasium is not installed.
    """
    from slider_drilling.training.draw import draw_rigs, given_rigs

    counts = {"drawn": drawn, "threads": threads}
    given = {name: count for name, count in counts.items() if count is not None}
    _check_kinds({"n": n, "samples": samples, **given}, Integral, "a whole number")
    _check_kinds({"duration": duration, "foreign": foreign}, Real, "a number")
    _check_kinds({"actions": actions, "autoreset": autoreset}, str, "a word")
    if not 1 <= n <= MAX_SLOTS:
        raise InputError(f"vector_env: n = {n}: must be within 1 to {MAX_SLOTS}")
    check_seed(seed, "vector_env")
    check_elements(elements, "vector_env")
    try:
        from slider_drilling.training.vector_environment import EpisodeOptions, VectorSlideEnvironment
    except ImportError as error:
        raise InputError(f"vector_env: {error}; pip install 'slider_drilling[gym]'") from None
    options = EpisodeOptions(duration, samples, actions, autoreset, threads)
    if rig is not None and not isinstance(rig, Rig):
        several = _several(rig, drawn)
        for name, asked in (("foreign", foreign != 0.0), ("effects", not isinstance(effects, bool))):
            if asked:
                raise InputError(f"vector_env: {name}: several rigs are used exactly as they are; leave it out, or "
                                 "give one rig to draw around")  # fmt: skip
        return VectorSlideEnvironment(n, given_rigs(several, duration), elements, options)
    if not isinstance(effects, bool) and (isinstance(effects, str) or not isinstance(effects, Sequence)):
        raise InputError(f"vector_env: effects = {effects!r}: give True, False or a list of names")
    count = min(n, DRAWN) if drawn is None else drawn
    if not 1 <= count <= MAX_SLOTS:
        raise InputError(f"vector_env: drawn = {drawn}: must be within 1 to {MAX_SLOTS}")
    base = rig if rig is not None else load_rig(installed_file("config/rig.example.yaml"))
    return VectorSlideEnvironment(n, draw_rigs(count, base, seed, duration, effects, foreign), elements, options)


def _check_kinds(given: Mapping[str, object], kind: type, what: str) -> None:
    """Check the kind of values by argument. Raises InputError."""
    for name, value in given.items():
        if isinstance(value, bool) or not isinstance(value, kind):
            raise InputError(f"vector_env: {name} = {value!r:.60}: give {what}")


def _several(rig: object, drawn: int | None) -> Sequence[Rig]:
    """Several rigs, as they are given. Raises InputError."""
    if isinstance(rig, str) or not isinstance(rig, Sequence) or not all(isinstance(each, Rig) for each in rig):
        raise InputError(f"vector_env: rig = {rig!r:.60}: give a rig as `load_rig` returns it, or a list of them")
    if not rig or drawn is not None:
        raise InputError("vector_env: rig: give at least one rig, and no `drawn` with several")
    return rig
