"""Public recordings of real machines: where they are, and their checksums.

    python -m slider_drilling.benchmarks.machine_records [DIR]

fetches what is missing. None of the files is part of this package.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.error import URLError
from urllib.parse import quote
from urllib.request import urlopen

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import make_folder, write_atomically

FOLDER_VARIABLE = "SLIDER_DRILLING_MACHINES"
_GITHUB = "https://raw.githubusercontent.com"
_TIMEOUT = 60.0  # s
_EMPS = "forgi86/sysid-neural-continuous/93afc131780fb1d5477472935a18ac8405683890/examples/EMPS/data"
_SERVO = "Rhoban/bam/af2260462471ff45ac18af159b1327ea51d8db15/bam/data.bak/raw"
_JOINT = (
    "longshike/NNFM-A-Novel-Neural-Network-Modeling-Approach-for-Robot-Flexible-Joints-Friction/"
    "a343d3a3537addd116d6283dae55f687fbf7748f/Comparative data/Franka Robot"
)


@dataclass(frozen=True)
class RecordFile:
    """One file of a recording.

    Attributes:
        machine: Folder that it belongs in.
        name: Its name there.
        address: Where it is.
        sha256: Its checksum.
    """

    machine: str
    name: str
    address: str
    sha256: str

    def path(self, folder: Path) -> Path:
        """Its place below a folder of recordings."""
        return folder / self.machine / self.name


def _file(machine: str, name: str, source: str, sha256: str) -> RecordFile:
    return RecordFile(machine, name, f"{_GITHUB}/{quote(source)}", sha256)


def _servo(gain: int, trajectory: str, stamp: str, sha256: str) -> RecordFile:
    return _file("servo", f"xl330_kp{gain}_{trajectory}.json", f"{_SERVO}/2026-01-15_{stamp}.json", sha256)


FILES = (
    _file("emps", "DATA_EMPS.mat", f"{_EMPS}/DATA_EMPS.mat",
          "6cf6814ae14618795da0101aae2bb97ff0c6351b0501b5492751b02b07facf7e"),
    _file("emps", "DATA_EMPS_PULSES.mat", f"{_EMPS}/DATA_EMPS_PULSES.mat",
          "0eab75bb1f6b16228ee78791343a88bf9bfd9a51036ac9807d7b5fc11c0e1704"),
    _servo(200, "sin_sin", "10h28m42", "1c6386bfa3be021c8ca8a96a7cbee93914f6271a050282b1c3b7d5ef373427db"),
    _servo(200, "lift_and_drop", "10h28m49", "e2223826274fca7799a2be0cb371e4269ead88cd9077fbb68498ef93e4e0de97"),
    _servo(200, "up_and_down", "10h28m57", "c10a350d9c7222d4d3499d140edd3ac4e63fe94f3b59a675116a34db7d66152c"),
    _servo(200, "sin_time_square", "10h29m04", "7996c43314a9f60094a6119346b54ff9ff84cb6726c967f4a88a7175278f6515"),
    _servo(800, "sin_sin", "10h29m47", "61ae8eeb881be5d8c09f6c7fba4cef39f66b1ff03e0148ef3bc0e314054513f5"),
    _servo(800, "lift_and_drop", "10h29m54", "b50055742ee553a8cb849b38d04d2b9bcf7143d0acefe6539f922984b93d958a"),
    _servo(800, "up_and_down", "10h30m02", "040e065f9885833fa909683f13665f90048ce5457d94dd2a3af056c21c36210d"),
    _servo(800, "sin_time_square", "10h30m10", "01d32db99e7859f012a230aca59f1dda24219d6781472d356861b138526213e6"),
    _file("robot_joint", "case4_slow.csv", f"{_JOINT}/case4_slow.csv",
          "0ec8ec6f168d48f33a04b3b1b454a499bbbb7b4dd5be54bb4d5edabf5e4ec29c"),
    _file("robot_joint", "case4_middle.csv", f"{_JOINT}/case4_middle.csv",
          "18daae975277747d4b09fb33ce297e85cbfe4366e4fe883182130d62fa96b35a"),
    _file("robot_joint", "case4_high.csv", f"{_JOINT}/case4_high.csv",
          "d3273362f0b1ba3b46898785226450db25204dab31e55d95547dcea53d14da98"),
)  # fmt: skip


def records_folder() -> Path:
    """Where recordings are kept: the folder of the environment's variable, else one in the user's cache."""
    named = os.environ.get(FOLDER_VARIABLE)
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return Path(named) if named else cache / "slider_drilling" / "machines"


def find_records(machine: str, folder: Path) -> dict[str, Path] | None:
    """The recordings of a machine by name, None if any is missing.

    Raises:
        InputError: A file is another than the one that was published.
    """
    files = [file for file in FILES if file.machine == machine]
    if not all(file.path(folder).is_file() for file in files):
        return None
    for file in files:
        _check(file, file.path(folder).read_bytes(), str(file.path(folder)))
    return {file.name: file.path(folder) for file in files}


def fetch(files: Sequence[RecordFile], folder: Path) -> list[Path]:
    """Fetch the files that are missing below a folder, each as a whole or not at all.

    Returns:
        Paths of the files that were fetched.

    Raises:
        InputError: An address cannot be reached, or what is there has another checksum.
    """
    fetched = []
    for file in files:
        if file.path(folder).is_file():
            continue
        try:
            with urlopen(file.address, timeout=_TIMEOUT) as answer:
                content = answer.read()
        except (URLError, OSError) as error:
            raise InputError(f"{file.address}: cannot be fetched: {error}") from None
        _check(file, content, file.address)
        make_folder(file.path(folder).parent)
        write_atomically(file.path(folder), content)
        fetched.append(file.path(folder))
    return fetched


def _check(file: RecordFile, content: bytes, place: str) -> None:
    found = hashlib.sha256(content).hexdigest()
    if found != file.sha256:
        raise InputError(f"{place}: SHA-256 is {found}, not {file.sha256}: not the published {file.name}")


def main(arguments: Sequence[str]) -> int:
    """Fetch all recordings into a folder."""
    folder = Path(arguments[0]) if arguments else records_folder()
    try:
        fetched = fetch(FILES, folder)
    except InputError as error:
        print(f"Error: {error}", file=sys.stderr)
        return 2
    print(f"{len(fetched)} of {len(FILES)} files fetched, all in {folder}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
