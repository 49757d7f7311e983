"""Controllers and effects that raise or return anything, anywhere."""

from __future__ import annotations

import importlib
import random
import sys
import tempfile
from pathlib import Path

import numpy as np
from tally import Tally

from slider_drilling.control.controller_loader import (
    checked_step,
    configure,
    load_controller,
    set_tool_face_target,
    settings_of,
    statuses_of,
)
from slider_drilling.diagnosis.user_effects import check_user_effects, load_effect
from slider_drilling.drillstring import Commands, VirtualRig
from slider_drilling.rig import load_rig

RIG = load_rig(Path(__file__).parents[2] / "config" / "rig.example.yaml")
ANY = [
    "None",
    "3",
    "'x'",
    "float('nan')",
    "float('inf')",
    "10**400",
    "np.float32(0.5)",
    "np.zeros(3)",
    "[]",
    "{}",
    "()",
    "True",
    "object()",
    "np.nan * np.ones(200)",
    "(lambda: 0)",
    "b'x'",
    "1j",
    "type",
    "np.ones((200, 2))",
    "-1e300",
]
DO = [
    "raise ValueError('a\\nb')",
    "raise SystemExit(3)",
    "raise KeyError",
    "1 / 0",
    "import no_such_module_of_mine",
    "raise RecursionError",
    "raise StopIteration",
    "assert False",
    "raise MemoryError",
    "raise OSError(28, 'full')",
    "class E(Exception):\n            def __str__(self): raise ValueError\n        raise E",
    "undefined_name",
]
CONTROLLER = """\
import dataclasses
import numpy as np
from slider_drilling.control.interface import Level, Status
from slider_drilling.control.settings import setting
from slider_drilling.control.interface import RigCommand
{top}
@dataclasses.dataclass(frozen=True)
class Settings:
    gain: float = setting(1.0, "-", 0.0, 2.0, "of something")
class Mine:
    def __init__(self, rig):
        {init}
        self.tool_face_target = 0.0
        self.settings = {settings}
    def step(self, measurements):
        {step}
        return {command}
    def status(self):
        {status}
        return {statuses}
    def configure(self, settings):
        {configure}
"""
EFFECT = """\
import numpy as np
from slider_drilling.drillstring import Commands, Modifiers
from slider_drilling.gap import Effect, Parameter
{top}
class Mine:
    effect = {effect}
    def __init__(self):
        {init}
        pass
    def commands(self, commands, values):
        {commands}
        return {given}
    def modifiers(self, measured_depth, values):
        {modifiers}
        return {modified}
    def channels(self, times, channels, values):
        {channels}
        return {shown}
"""
COMMAND = "RigCommand(0.0, 0.0, 0.001, 12.0)"
MINE = "Effect({name}, 'contact', (Parameter({parameter}, 0.0, 0.0, 3.0, 0.05),), scan=((0.3,), (0.6,), (0.9,)))"


def fuzz(cases: int, seed: int) -> int:
    """Run the cases; returns 1 if one neither ran nor was refused in one line."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder:
        sys.path.insert(0, folder)
        plant = VirtualRig(RIG, elements=20)
        for number in range(cases):
            draw = random.Random(f"plug-in {seed} {number}")
            name = f"plug_in_{seed}_{number}"
            used, code = draw.choice(((_controller, _write_controller(draw)), (_effect, _write_effect(draw))))
            (Path(folder) / f"{name}.py").write_text(code)
            importlib.invalidate_caches()
            tally.run(lambda used=used, name=name: used(name, plant), f"seed {seed} case {number}")
            sys.modules.pop(name, None)
    return tally.report("plug-ins")


def _controller(name: str, plant: VirtualRig) -> str:
    controller = load_controller(f"{name}:Mine", RIG)
    set_tool_face_target(controller, 0.3)
    plant.step(checked_step(controller, plant.measurements))
    statuses_of(controller)
    settings = settings_of(controller)
    if settings is not None:
        configure(controller, settings)
    return "ran"


def _effect(name: str, plant: VirtualRig) -> str:
    time = np.arange(0.0, 20.0, 0.1)
    commands = Commands(time, *(np.zeros_like(time) for _ in range(5)))
    check_user_effects([load_effect(f"{name}:Mine")], ["stribeck", "stribeck.drop", "friction_1"], RIG, commands)
    return "ran"


def _write_controller(draw: random.Random) -> str:
    parts = {
        "top": "",
        "init": "",
        "settings": "Settings()",
        "step": "",
        "command": COMMAND,
        "status": "",
        "statuses": "(Status(Level.OK, 'a', 'b'),)",
        "configure": "pass",
    }
    for name in draw.sample(list(parts), draw.choice((1, 1, 2))):
        values = [
            f"RigCommand({draw.choice(ANY)}, 0.0, 0.0, {draw.choice(ANY)})",
            f"(Status({draw.choice(ANY)}, 'a', 'b'),)",
            f"(Status(Level.OK, 'a', 'b', {draw.choice(ANY)}),)",
            f"Settings({draw.choice(ANY)})",
            *ANY,
        ]
        parts[name] = draw.choice(values if name in ("settings", "command", "statuses") else DO)
    return CONTROLLER.format(**parts)


def _write_effect(draw: random.Random) -> str:
    parts = {
        "top": "",
        "effect": MINE.format(name="'mine'", parameter="'mine.grip'"),
        "init": "",
        "commands": "",
        "given": "commands",
        "modifiers": "",
        "modified": "Modifiers()",
        "channels": "",
        "shown": "channels",
    }
    for name in draw.sample(list(parts), draw.choice((1, 1, 2))):
        values = [
            *ANY,
            f"Modifiers({draw.choice(ANY)}, {draw.choice(ANY)})",
            f"{{'hook_load': {draw.choice(ANY)}}}",
            f"Commands(*[{draw.choice(ANY)}] * 6)",
            MINE.format(name="'stribeck'", parameter="'friction_1'"),
            MINE.format(name=draw.choice(ANY), parameter=draw.choice(ANY)),
        ]
        parts[name] = draw.choice(values if name in ("effect", "given", "modified", "shown") else DO)
    return EFFECT.format(**parts)
