"""Finds the files installed beside the package: rig files, node parameters, launch files."""

from __future__ import annotations

from pathlib import Path

from slider_drilling.errors import InputError

PACKAGE = "slider_drilling"


def installed_file(name: str) -> Path:
    """The path of an installed file.

    Searches the folders above the package for `share/slider_drilling` (pip and colcon installs) and for the checkout
    that holds the package (editable installs).

    Args:
        name: Such as `config/rig.example.yaml`.

    Raises:
        InputError: The installation lacks the file.
    """
    package = Path(__file__).resolve().parent
    for above in package.parents:
        if (above / "package.xml").is_file() and (above / name).is_file():
            return above / name
        installed = above / "share" / PACKAGE / name
        if installed.is_file():
            return installed
    raise InputError(f"{name}: not installed beside {package}; install the package again")
