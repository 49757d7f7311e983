"""The documented example of a user's own effect, run as it is printed."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.diagnosis.user_effects import combined_modifiers, load_effect
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import load_rig

PAGE = Path(__file__).parents[1] / "docs" / "how_to" / "user_effects.md"


@pytest.fixture
def clay(tmp_path, monkeypatch):
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(), re.S).group(1)
    (tmp_path / "clay.py").write_text(code)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    return load_effect("clay:SwellingClay")


def test_documented_example_acts_below_its_top(clay):
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(), re.S).group(1)
    assert len([line for line in code.splitlines() if line.strip()]) <= 20
    rig = load_rig(installed_file("config/rig.example.yaml"))
    values = {"swelling_clay.grip": 0.5, "swelling_clay.top": 2000.0}
    factor = combined_modifiers([clay], rig, 50, values).friction_factor
    assert factor[0] == 1.0
    assert factor[-1] == pytest.approx(1.5)
    assert np.all(np.diff(factor) >= 0.0)


@pytest.mark.parametrize("reference", ["clay", "no_such_module_here:Effect", "slider_drilling.rig:Nothing"])
def test_effect_that_fails_to_load_is_an_input_error(reference):
    with pytest.raises(InputError, match="--effect"):
        load_effect(reference)


@pytest.mark.parametrize("name", ["queue", "numpy", "click"])
def test_module_that_another_hides_is_refused(tmp_path, monkeypatch, name):
    (tmp_path / f"{name}.py").write_text("open('executed', 'w')\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    with pytest.raises(InputError, match=rf"--effect {name}:Clay: {name}\.py is hidden by the module {name} of /"):
        load_effect(f"{name}:Clay")
    assert not (tmp_path / "executed").exists()


def test_working_directory_is_searched_last(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    with pytest.raises(InputError):
        load_effect("no_such_module_here:Effect")
    assert sys.path[-1] == str(tmp_path) and str(tmp_path) not in sys.path[:-1]
