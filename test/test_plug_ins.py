"""Errors in a user's controller or effect become one line with the user's file and line number."""

from __future__ import annotations

import itertools
import json
import os
import re
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path

import click
import numpy as np
import pytest
from fork_server import run_cli

from slider_drilling.cli import group
from slider_drilling.commands.options import _reserve_stdout
from slider_drilling.control.controller_loader import (
    checked_step,
    configure,
    load_controller,
    set_tool_face_target,
    settings_of,
    statuses_of,
)
from slider_drilling.control.interface import Measurements
from slider_drilling.diagnosis import user_effects
from slider_drilling.diagnosis.user_effects import CheckedUserEffect, check_user_effects, installed_effects, load_effect
from slider_drilling.drillstring import Commands
from slider_drilling.errors import InputError
from slider_drilling.rig import load_rig

RIG = load_rig(Path(__file__).parents[1] / "config" / "rig.example.yaml")
SAMPLE = Measurements(1.5, 0.0, 0.0, 100.0, 0.0, 0.0, 9e5, 1.8e7, 12.3)
RETURN = "return RigCommand(0.0, 0.0, 0.001, 12.3)"
STATUS = 'return (Status(Level.OK, "mine", "well"),)'
COUNT = itertools.count()
CONTROLLER = """\
import dataclasses
import numpy as np
from slider_drilling.control.interface import Level, Status
from slider_drilling.control.settings import setting
from slider_drilling.control.interface import RigCommand

@dataclasses.dataclass(frozen=True)
class Settings:
    gain: float = setting(1.0, "-", 0.0, 2.0, "of something")

class Mine:
    def __init__(self, rig):
        self.tool_face_target = 0.0
        self.settings = Settings()
    def step(self, measurements):
        return RigCommand(0.0, 0.0, 0.001, 12.3)
    def status(self):
        return (Status(Level.OK, "mine", "well"),)
    def configure(self, settings):
        self.settings = settings
"""
EFFECT = """\
import numpy as np
from slider_drilling.drillstring import Modifiers
from slider_drilling.gap import Effect, Parameter
from slider_drilling.diagnosis.user_effects import UnchangedPlant

class Mine(UnchangedPlant):
    effect = Effect("mine", "contact", (Parameter("mine.grip", 0.0, 0.0, 3.0, 0.05),), scan=((0.3,), (0.6,), (0.9,)))
"""


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], str]:
    """Writes a module with a unique name into the working directory; returns the name."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))

    def write(code: str) -> str:
        name = f"plug_in_{next(COUNT)}"
        (tmp_path / f"{name}.py").write_text(textwrap.dedent(code))
        return name

    return write


NOISY = """
import atexit, ctypes, os, sys
print("at import")
os.write(1, b"to the descriptor\\n")
ctypes.CDLL(None).puts(b"by C")
atexit.register(print, "at exit")
atexit.register(os.write, 1, b"at exit, to the descriptor\\n")
sys.__stdout__.write("to the first stdout\\n")
class Mine: pass
"""
PROGRAM = """
import click
from slider_drilling import cli
from slider_drilling.commands.options import json_option, print_json
from slider_drilling.user_code import import_reference

@click.group()
def group(): pass

@group.command()
@json_option
def act(as_json):
    import_reference("noisy_plug_in:Mine", "act", "")
    print_json({"answer": 1})

cli.group = group
cli.main()
"""


def test_plug_in_that_prints_leaves_json(tmp_path: Path, repository: Path) -> None:
    (tmp_path / "noisy_plug_in.py").write_text(NOISY)
    answer = subprocess.run([sys.executable, "-c", PROGRAM, "act", "--json"], cwd=tmp_path, capture_output=True,
                            text=True, timeout=120, env={**os.environ, "PYTHONPATH": str(repository)})  # fmt: skip
    assert answer.returncode == 0, answer.stderr
    assert json.loads(answer.stdout) == {"answer": 1}
    for said in ("at import", "to the descriptor", "by C", "at exit"):
        assert said in answer.stderr


@pytest.mark.parametrize("name", sorted(group.list_commands(click.Context(group))))
def test_every_json_option_reserves_stdout(name: str) -> None:
    found = group.get_command(click.Context(group), name)
    assert found is not None
    options = [option for option in found.params if "--json" in option.opts]
    assert all(option.callback is _reserve_stdout and option.is_eager for option in options)


def test_controller_that_prints_leaves_json_of_a_closed_loop(tmp_path: Path) -> None:
    (tmp_path / "noisy_controller.py").write_text(CONTROLLER + 'print("at import")\n')
    slide = ("--slide", "0", "--duration", "300", "--elements", "10", "--jobs", "1")
    done = run_cli("closed-loop", *slide, "--controller", "noisy_controller:Mine", "--json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["scenarios"] and "at import" in done.stderr


def use(name: str) -> None:
    """All that a run does with a controller."""
    controller = load_controller(f"{name}:Mine", RIG)
    set_tool_face_target(controller, 0.5)
    checked_step(controller, SAMPLE)
    statuses_of(controller)
    settings = settings_of(controller)
    if settings is not None:
        configure(controller, settings)


def one_line(act: Callable[[], object], said: str) -> None:
    with pytest.raises(InputError) as error:
        act()
    assert re.search(said, str(error.value)), str(error.value)
    assert len(str(error.value)) < 600


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("import dataclasses", "1 / 0", r"ZeroDivisionError: division by zero at plug_in_\d+\.py:1$"),
        ("import dataclasses", "import no_such_module_x", r"ModuleNotFoundError.*at plug_in_\d+\.py:1$"),
        ("import dataclasses", "import sys; sys.exit(3)", r"SystemExit: 3 at plug_in_\d+\.py:1$"),
        ("import dataclasses", "def", r"SyntaxError: .* at plug_in_\d+\.py:1$"),
        ("class Mine:", "class Other:", "has no attribute 'Mine'"),
        ("self.tool_face_target = 0.0", "rig.no_such", r"Mine\(rig\) raised AttributeError.*plug_in_\d+\.py:13$"),
        ("def __init__(self, rig)", "def __init__(self)", r"Mine\(rig\) raised TypeError"),
        ("def step(self", "def walk(self", "has no method step"),
        (RETURN, "return None", "step returned NoneType, not a RigCommand"),
        (RETURN, "return measurements.nothing", r"step at 1.5 s raised.*py:16$"),
        (RETURN, "return RigCommand(float('nan'), 0.0, 0.0, 0.0)", "top_drive_angle = nan"),
        (RETURN, "return RigCommand(0.0, 10**400, 0.0, 0.0)", "top_drive_speed = 1000"),
        (RETURN, "return RigCommand(0.0, '1', 0.0, 0.0)", "top_drive_speed = '1'"),
        (RETURN, "return RigCommand(0.0, 0.0, np.zeros(3), 0.0)", "block_speed = array"),
        (RETURN, "return RigCommand(0.0, 0.0, True, 0.0)", "block_speed = True"),
        (RETURN, "raise SystemExit", "step at 1.5 s raised SystemExit"),
        (RETURN, "return np.linalg.inv(np.zeros((2, 2)))", r"LinAlgError.*plug_in_\d+\.py:16$"),
        (RETURN, "return self.step(measurements)", "RecursionError"),
        (STATUS, "return None", "status returned NoneType"),
        (STATUS, "return ('well',)", "status returned 'well', which is not a Status"),
        (STATUS, "return (Status(0, 'a', 'b'),)", "which is not a Status"),
        (STATUS, "return (Status(Level.OK, 'a', 'b', ((1, 2),)),)", "not a Status"),
        (STATUS, "raise ValueError('x\\ny')", r"status raised ValueError: x y at.*18$"),
        ("self.settings = Settings()", "self.settings = {'gain': 1.0}", "settings are dict, not a dataclass"),
        ("self.settings = Settings()", "self.settings = Settings(5.0)", "gain = 5.0: must be within"),
        ("        self.settings = settings", "        raise KeyError('gain')", r"configure raised KeyError.*20$"),
    ],
)  # fmt: skip
def test_wrong_controller_is_a_one_line_error(write: Callable[[str], str], right: str, wrong: str, said: str) -> None:
    assert CONTROLLER.count(right) == 1
    name = write(CONTROLLER.replace(right, wrong))
    one_line(lambda: use(name), said)


@pytest.mark.parametrize("name", ["tool_face_target", "settings", "status"])
def test_raising_property_is_a_one_line_error(write: Callable[[str], str], name: str) -> None:
    body = f"    @property\n    def {name}(self):\n        raise RuntimeError('no')\n    @{name}.setter\n    def {name}(self, value):\n        raise RuntimeError('no')\n"  # noqa: E501
    module = write(CONTROLLER.replace("    def configure", body + "    def configure").replace(
        "        self.tool_face_target = 0.0\n        self.settings = Settings()\n", "        pass\n"))  # fmt: skip
    one_line(lambda: use(module), rf"{name} raised RuntimeError: no at {module}\.py:\d+$")


def test_any_real_number_is_a_valid_command(write: Callable[[str], str]) -> None:
    name = write(CONTROLLER.replace("(0.0, 0.0, 0.001, 12.3)", "(np.float32(0.5), np.int64(1), 0, np.float64(2.0))"))
    command = checked_step(load_controller(f"{name}:Mine", RIG), SAMPLE)
    assert command.top_drive_angle == 0.5 and type(command.top_drive_angle) is float
    assert (command.top_drive_speed, command.block_speed, command.pump_speed) == (1.0, 0.0, 2.0)


def test_valid_controller_is_used(write: Callable[[str], str]) -> None:
    use(write(CONTROLLER))


def test_target_must_be_a_number() -> None:
    controller = load_controller("slider_drilling.control:SlideController", RIG)
    with pytest.raises(InputError, match="tool_face_target = nan: must be a finite number"):
        set_tool_face_target(controller, float("nan"))


@pytest.mark.parametrize("name", ["", ":", "a:", ":B", "a b:C", "a:1", "../a:B", "a:B:C", "os:path", "math:pi", "a\n:"])
def test_wrong_controller_name_is_a_one_line_error(name: str) -> None:
    one_line(lambda: load_controller(name, RIG), "controller = ")


def commands() -> Commands:
    time = np.arange(0.0, 20.0, 0.1)
    return Commands(time, *(np.zeros_like(time) for _ in range(5)))


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("effect = 3", "`effect` is 3, not a slider_drilling.gap.Effect"),
        ("effect = None", "`effect` is None"),
        ("effect = np.ones((3, 3))", r"`effect` is array\(\[\[1"),
        ("effect = Effect(np.ones(3), 'bit', effect.parameters, effect.scan)", "for a name, which must be text"),
        ("def __init__(self): raise OSError('gone')", r"Mine\(\) raised OSError: gone at plug_in_\d+\.py:8"),
        ("def modifiers(self, depth, values): return None", "modifiers returned NoneType, not Modifiers"),
        ("def modifiers(self, depth, values): return Modifiers(np.ones(3))", r"factor has shape \(3,\), must have"),
        ("def modifiers(self, depth, values): return Modifiers(depth * np.nan)", "friction_factor holds nan"),
        ("def modifiers(self, depth, values): return Modifiers(10**400)", "factor is 1000.*not an array of numbers"),
        ("def modifiers(self, depth, values): return Modifiers(-1.0)", "friction cannot be negative"),
        ("def modifiers(self, depth, values): return Modifiers(values['x'])", r"raised KeyError: 'x' at.*py:8"),
        ("def modifiers(self): return 3", "modifiers raised TypeError"),
        ("def commands(self, commands, values): return 3", "commands returned int, not Commands"),
        ("def commands(self, commands, values): return 1 / 0", r"commands raised ZeroDivisionError.*plug_in_\d+\.py:8"),
        ("def channels(self, times, channels, values): return []", "channels returned list, not a mapping"),
        ("def channels(self, times, channels, values): return {'x': 1}", "channels returned 'x'; this log has"),
        ("def channels(self, times, channels, values): return {'hook_load': [1.0]}", r"hook_load has shape \(1,\)"),
        ("effect = Effect('stribeck', 'contact', effect.parameters, effect.scan)", "name stribeck is already taken"),
        ("effect = Effect('m', 'bit', (Parameter('friction_1', 0.0, 0.0, 3.0, 1.0),), effect.scan)", "_1 is already"),
    ],
)  # fmt: skip
def test_wrong_effect_is_a_one_line_error_before_fitting(write: Callable[[str], str], body: str, said: str) -> None:
    code = EFFECT + f"    {body}\n"
    name = write(code)

    def act() -> None:
        check_user_effects([load_effect(f"{name}:Mine")], ["stribeck", "friction_1"], RIG, commands())

    one_line(act, said)


@pytest.mark.parametrize("code", ["1 / 0", "raise SystemExit", "class Mine(", "import nothing_of_this_name"])
def test_import_error_of_an_effect_is_one_line(write: Callable[[str], str], code: str) -> None:
    name = write(f"\n{code}\n")
    one_line(lambda: load_effect(f"{name}:Mine"), rf"--effect {name}:Mine: cannot be imported: .* at {name}\.py:2$")


def test_wrong_effect_fails_before_the_log_is_read(write: Callable[[str], str], tmp_path: Path) -> None:
    name = write("1 / 0")
    with pytest.raises(InputError, match="ZeroDivisionError"):
        group.main(["diagnose", "no-such.mcap", "--effect", f"{name}:Mine"], standalone_mode=False)


def test_valid_effect_is_accepted_once(write: Callable[[str], str]) -> None:
    name = write(EFFECT)
    effect = load_effect(f"{name}:Mine")
    assert isinstance(effect, CheckedUserEffect)
    check_user_effects([effect], ["stribeck"], RIG, commands())
    twice = [effect, effect]
    one_line(lambda: check_user_effects(twice, [], RIG, commands()), "name mine is already taken; choose another")


def test_entry_point_that_fails_to_load_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    class Point:
        name, value = "broken", "somewhere:Else"

        def load(self) -> object:
            raise ImportError("gone")

    monkeypatch.setattr(user_effects, "entry_points", lambda group: [Point()])
    one_line(installed_effects, r"effect of entry point broken \(somewhere:Else\): loading it raised ImportError: gone")


def test_wrong_controller_ends_a_closed_loop_in_one_line(write: Callable[[str], str]) -> None:
    name = write(CONTROLLER.replace(RETURN, "raise ValueError('mine')"))
    with pytest.raises(InputError, match=rf"step at 0 s raised ValueError: mine at {name}\.py:16"):
        group.main(["closed-loop", "--only", "hold, 2.6", "--controller", f"{name}:Mine", "--elements", "20",
                    "--jobs", "1"], standalone_mode=False)  # fmt: skip
