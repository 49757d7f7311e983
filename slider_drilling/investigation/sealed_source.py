"""A rig of foreign structure with a sealed effect, to try an investigation on."""

from __future__ import annotations

from pathlib import Path

from slider_drilling.blind.cases import MIN_SIZE_OF_TWO, Case
from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS
from slider_drilling.blind.sealed_plant import INTERVAL_S
from slider_drilling.blind.sealed_rig import SealedRig, draw_sealed_rig, write_first_log
from slider_drilling.errors import InputError
from slider_drilling.investigation.loop import ROUTINE_S, Recorder
from slider_drilling.programmes import load_programme, open_loop_commands
from slider_drilling.rig import Rig


def sealed_rig(rig: Rig, effects: tuple[str, ...], size: float, seed: int) -> SealedRig:
    """A sealed rig with the file's own well.

    Args:
        rig: The rig file.
        effects: One or two names of the catalogue; one drawn by the seed if empty.
        size: In noise floors of the routine log.
        seed: Of everything that is drawn.

    Raises:
        InputError: A name is unknown or given twice, or two effects are too small.
    """
    names = tuple(CATALOGUE_LAWS)
    for name in effects:
        if name not in names:
            raise InputError(f"sealed effect {name}: unknown; use {', '.join(names)}")
    if len(set(effects)) < len(effects):
        raise InputError(f"sealed effect {effects[0]}: given twice; give two different ones, or one")
    if len(effects) > 1 and size < MIN_SIZE_OF_TWO:
        raise InputError(f"size {size:g}: two sealed effects need at least {MIN_SIZE_OF_TWO:g} noise floors each")
    chosen = effects or (names[seed % len(names)],)
    return draw_sealed_rig(Case(chosen, size, "own", "steady", seed, ROUTINE_S, plant="foreign"), rig)


def sealed_recorder(sealed: SealedRig) -> Recorder:
    """Runs programmes on a sealed rig; the first log is its routine."""

    def record(number: int, programme: Path, log: Path) -> bool:
        if number == 1:
            write_first_log(sealed, log)
        else:
            commands = open_loop_commands(load_programme(programme), sealed.rig, INTERVAL_S)
            sealed.record_later_run(log, commands, number - 1)
        return True

    return record


def opened(sealed: SealedRig) -> tuple[tuple[str, float], ...]:
    """What was hidden in a sealed rig, see `Investigation.sealed`."""
    return tuple((law.name, size) for law, size in zip(sealed.laws, sealed.sizes, strict=True))


def folder_recorder(number: int, programme: Path, log: Path) -> bool:
    """Somebody else runs the programmes: the log is there or it is not."""
    return log.is_file()
