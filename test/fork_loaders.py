"""What the servers of `fork_server` import before they fork: that of nodes, and that of commands without ROS."""

import importlib
import os
from pathlib import Path

CONFIG = Path(__file__).resolve().parents[1] / "config"
NODES = ("friction_simulator", "rocking_controller", "recorder", "log_player", "twin")


def load_nodes() -> None:
    """The nodes, their libraries, and the compiled code that they run."""
    from slider_drilling.nodes import environment

    environment.prepare()
    from slider_drilling.nodes import run_node

    for name in NODES:
        importlib.import_module(run_node.NODES[name][0])
    _simulate()


def load_commands() -> None:
    """The commands, their libraries, and the compiled code that they run."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the program does, before numpy is imported
    from slider_drilling.cli import COMMANDS

    for row in COMMANDS.values():
        importlib.import_module(row.module)
    for name in ("matplotlib.figure", "matplotlib.backends.backend_agg", "slider_drilling.log", "slider_drilling.gap"):
        importlib.import_module(name)
    _simulate()


def _simulate() -> None:
    """Load the compiled code of rig and controller."""
    from slider_drilling.control import SlideController
    from slider_drilling.drillstring import VirtualRig
    from slider_drilling.rig import load_rig

    rig = load_rig(CONFIG / "rig.example.yaml")
    virtual, controller = VirtualRig(rig, elements=20), SlideController(rig)
    for _ in range(3):
        virtual.step(controller.step(virtual.measurements))
