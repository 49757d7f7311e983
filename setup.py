"""Installs the package for pip and for colcon alike; what is not here is in setup.cfg."""

from glob import glob
from pathlib import Path

from setuptools import setup

PACKAGE = "slider_drilling"
SHARE = f"share/{PACKAGE}"


def files_below(folder: str) -> list[tuple[str, list[str]]]:
    """Every file below the folder, grouped as data_files wants them: by folder of destination."""
    found = sorted(path for path in glob(f"{folder}/**", recursive=True) if Path(path).is_file())
    folders = sorted({str(Path(path).parent) for path in found})
    return [(f"{SHARE}/{here}", [path for path in found if str(Path(path).parent) == here]) for here in folders]


setup(
    # Not in setup.cfg, whose reader makes an object of it that colcon cannot parse.
    python_requires=">=3.10",
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (SHARE, ["package.xml"]),
        *files_below("config"),
        *files_below("launch"),
    ],
)
