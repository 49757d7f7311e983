"""The rig file of the examples."""

from __future__ import annotations

from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig.rig_file import Rig, load_rig


def example_rig() -> Rig:
    """The package's example rig: a well of 4000 m, 1600 m of it horizontal."""
    return load_rig(installed_file("config/rig.example.yaml"))
