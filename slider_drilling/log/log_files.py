"""Which files make up a log: one file, the parts of a bag, or all logs in a folder; and what reads each of them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from slider_drilling.errors import InputError
from slider_drilling.log.log_reader import LogReader
from slider_drilling.log.mcap_reader import McapReader
from slider_drilling.log.ros1_reader import ROS1_MAGIC, Ros1BagReader
from slider_drilling.log.sqlite_reader import SQLITE_MAGIC, SqliteReader
from slider_drilling.log.unpack_file import first_unpacked_bytes

METADATA = "metadata.yaml"
_BAG_INFORMATION = "rosbag2_bagfile_information"
# A name in a folder, without the ending that compression adds.
_LOG_NAME = re.compile(r".+\.(mcap|db3|bag)(\.(zstd|zst|gz|bz2|xz|lz4))?")
_LONGEST_MAGIC = 16
_SPECIAL = "is a pipe, a socket or a device"
_METADATA_ERRORS = (OSError, ValueError, yaml.YAMLError, TypeError, LookupError, RecursionError)


@dataclass(frozen=True)
class LogFiles:
    """The files of a log.

    Attributes:
        files: In the order of recording.
        notes: What is missing or was left out, one sentence each.
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()


def holds_logs(folder: Path) -> bool:
    """Whether a folder holds a log."""
    return bool(_logs_in(folder))


def _logs_in(folder: Path) -> list[Path]:
    return [file for file in folder.iterdir() if _LOG_NAME.fullmatch(file.name)]


def find_log_files(path: Path) -> LogFiles:
    """The files of a log.

    Args:
        path: A log; the folder of a bag or of the parts of a log; or the metadata.yaml of a bag.

    Raises:
        InputError: A folder holds no logs, or what is given is a pipe, a socket or a device.
    """
    folder = path.parent if path.name == METADATA and path.is_file() else path
    if not folder.is_dir():
        if _is_special(path):
            raise InputError(f"{path}: {_SPECIAL}; give a file")
        return LogFiles((path,))
    held = sorted(_logs_in(folder), key=_part_order)
    listed, notes = _listed_names(folder / METADATA)
    if not held:
        missing = f"; {METADATA} lists {', '.join(listed)}" if listed else ""
        raise InputError(f"{folder}: holds no logs (.mcap, .db3, .bag){missing}; give a log, or the folder of a bag")
    found = _parts_of_bag(folder, held, listed) if listed else LogFiles(tuple(held), notes)
    return _without_special(folder, found)


def _is_special(path: Path) -> bool:
    """Whether this is a pipe, a socket or a device: reading it could block for ever, or have no end."""
    return path.exists() and not (path.is_file() or path.is_dir())


def _without_special(folder: Path, found: LogFiles) -> LogFiles:
    """The files that are files, and a note for each other one. Raises InputError where none is left."""
    notes = [f"{file.name}: skipped: {_SPECIAL}" for file in found.files if _is_special(file)]
    files = tuple(file for file in found.files if not _is_special(file))
    if not files:
        raise InputError(f"{folder}: no file of this log can be read; {'; '.join(notes)}")
    return LogFiles(files, (*found.notes, *notes))


def logs_below(folder: Path) -> list[Path]:
    """The logs in and below a folder: files, and folders that are bags; hidden ones are left out."""
    if _listed_names(folder / METADATA)[0]:
        return [folder]
    logs: list[Path] = []
    for entry in sorted(folder.iterdir()):
        if entry.name.startswith("."):
            continue
        if entry.is_dir() and not entry.is_symlink():
            logs += logs_below(entry)
        elif _LOG_NAME.fullmatch(entry.name):
            logs.append(entry)
    return logs


def _parts_of_bag(folder: Path, held: list[Path], listed: list[str]) -> LogFiles:
    """The files that a bag lists, and those that continue them."""
    names = {file.name for file in held}
    # Where a file was compressed or unpacked by hand its name changed, but not its stem.
    stems = {_stem(file.name): file for file in held}
    found = {name: folder / name if name in names else stems.get(_stem(name)) for name in listed}
    files = [file for file in found.values() if file is not None]
    notes = [f"{name}: listed in {METADATA}, but missing: a gap" for name, at in found.items() if not at]
    own = {_stem(name) for name in listed}
    for file in held:
        if file in files or _stem(file.name) in own:
            continue
        if _continues(_stem(file.name), own):
            files.append(file)
            notes.append(f"{file.name}: not listed in {METADATA}, as after a recording that was killed; it was read")
        else:
            notes.append(f"{file.name}: not listed in {METADATA}, and named as another recording; not read")
    return LogFiles(tuple(sorted(files, key=_part_order)), tuple(notes))


def _continues(stem: str, listed: set[str]) -> bool:
    """Whether a file is a further part of the recording whose files have these stems, by its name."""
    series, number = _split_number(stem)
    # Longer numbers are dates and times: of another recording.
    return 0 < len(number) < 5 and (series in listed or series in {_split_number(name)[0] for name in listed})


def _listed_names(metadata: Path) -> tuple[list[str], tuple[str, ...]]:
    """Names of the files that a bag's metadata.yaml lists, and notes; a missing or damaged one lists none.

    A note says if metadata.yaml is there, but does not say which files make up the bag.
    """
    if not metadata.exists():
        return [], ()
    try:
        return _read_metadata(metadata), ()
    except _METADATA_ERRORS:
        return [], (f"{METADATA}: lists no files of a bag, or is damaged; every log in the folder was read",)


def _read_metadata(metadata: Path) -> list[str]:
    """Names of the files that metadata.yaml lists. Raises `_METADATA_ERRORS`."""
    if not metadata.is_file():
        raise ValueError(_SPECIAL)
    listed = yaml.safe_load(metadata.read_text(encoding="utf-8"))[_BAG_INFORMATION]["relative_file_paths"]
    if not isinstance(listed, list):
        raise TypeError
    return [Path(str(name)).name for name in listed]


def _stem(name: str) -> str:
    """`run_1` of `run_1.mcap.zstd`."""
    match = _LOG_NAME.fullmatch(name)
    return name[: match.start(1) - 1] if match else name


def _split_number(stem: str) -> tuple[str, str]:
    """What the names of a recording's parts share, and the number of the part: `run` and `1` of `run_1`."""
    series = re.sub(r"_?\d+$", "", stem)
    return series, stem[len(series) :].lstrip("_")


def _part_order(file: Path) -> tuple[str, int, str]:
    """Sorts the parts of a recording by their numbers, of which the first may have none."""
    series, number = _split_number(_stem(file.name))
    return series, int(number or 0), file.name


def open_readers(files: Sequence[Path]) -> list[LogReader]:
    """The readers of a log's files. A part that cannot be read is skipped with a note; a single file raises."""
    readers = [open_reader(file) for file in files]
    for reader in readers:
        reader.is_part = len(files) > 1
    return readers


def open_reader(path: Path) -> LogReader:
    """The reader of one file, by its first bytes; of an MCAP file where it begins as none."""
    try:
        begin = first_unpacked_bytes(path, _LONGEST_MAGIC)
    except OSError:
        return McapReader(path)  # which says why it cannot be read
    if begin.startswith(SQLITE_MAGIC):
        return SqliteReader(path)
    return Ros1BagReader(path) if begin.startswith(ROS1_MAGIC) else McapReader(path)
