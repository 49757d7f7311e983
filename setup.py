"""Installs the package for pip and for colcon alike; what is not here is in setup.cfg."""

import sys
from configparser import ConfigParser
from glob import glob
from pathlib import Path

from setuptools import setup

PACKAGE = "slider_drilling"
SHARE = f"share/{PACKAGE}"
PROGRAMS = f"lib/{PACKAGE}"  # where `ros2 run` and `ros2 launch` look for a package's programs
LAUNCHERS = Path("build/launchers")
LAUNCHER = """#!/bin/sh
# The program that pip made for this environment.
exec "$(dirname -- "$0")/../../bin/{name}" "$@"
"""


def files_below(folder: str) -> list[tuple[str, list[str]]]:
    """Every file below the folder, grouped as data_files wants them: by folder of destination."""
    found = sorted(path for path in glob(f"{folder}/**", recursive=True) if Path(path).is_file())
    folders = sorted({str(Path(path).parent) for path in found})
    return [(f"{SHARE}/{here}", [path for path in found if str(Path(path).parent) == here]) for here in folders]


def launchers() -> list[tuple[str, list[str]]]:
    """A launcher for each node, for a wheel; colcon puts the programs themselves there, see setup.cfg."""
    if "bdist_wheel" not in sys.argv:
        return []
    config = ConfigParser()
    config.read("setup.cfg")
    rows = config["options.entry_points"]["console_scripts"].split("\n")
    names = [row.partition("=")[0].strip() for row in rows if f"{PACKAGE}.nodes." in row]
    LAUNCHERS.mkdir(parents=True, exist_ok=True)
    for name in names:
        (LAUNCHERS / name).write_text(LAUNCHER.format(name=name))
        (LAUNCHERS / name).chmod(0o755)
    return [(PROGRAMS, [str(LAUNCHERS / name) for name in names])]


setup(
    # Not in setup.cfg, whose reader makes an object of it that colcon cannot parse.
    python_requires=">=3.10",
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (SHARE, ["package.xml"]),
        *files_below("config"),
        *files_below("launch"),
        *launchers(),
    ],
)
