"""A package that pip has installed, not from a checkout: its programs, its files, and what it leaves behind."""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

from slider_drilling.nodes.run_node import NODES

pytest.importorskip("wheel", reason="no wheel: pip install '.[test]'")

SOURCES = ("slider_drilling", "config", "launch", "resource", "setup.py", "setup.cfg", "pyproject.toml", "package.xml",
           "README.md", "LICENSE")  # fmt: skip


@pytest.fixture(scope="module")
def installed(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fresh environment with the package and, on its path, what this one has of other packages."""
    folder = tmp_path_factory.mktemp("installation")
    for name in SOURCES:
        source = repository / name
        if source.is_dir():
            shutil.copytree(source, folder / "checkout" / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            (folder / "checkout").mkdir(exist_ok=True)
            shutil.copy(source, folder / "checkout")
    run(sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", str(folder / "wheels"),
        str(folder / "checkout"))  # fmt: skip
    environment = folder / "environment"
    venv.create(environment, symlinks=True, with_pip=False)
    (wheel,) = (folder / "wheels").glob("*.whl")
    pip(environment, "install", "-q", "--no-deps", "--no-index", str(wheel))
    return environment


def run(*command: str, **variables: str) -> str:
    """What a command prints. Fails with all that it said if it fails."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | variables
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, cwd="/")
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def pip(environment: Path, *arguments: str) -> None:
    run(sys.executable, "-m", "pip", "--python", str(environment / "bin" / "python"), *arguments)


def others() -> dict[str, str]:
    """Where the fresh environment finds the other packages."""
    return {"PYTHONPATH": sysconfig.get_path("purelib")}


@pytest.mark.slow
def test_installed_programs_are_where_ros2_looks(installed):
    programs = installed / "lib" / "slider_drilling"
    assert {path.name for path in programs.iterdir() if os.access(path, os.X_OK)} == set(NODES)
    assert f"{installed}/bin/python" in (installed / "bin" / "recorder").read_text().splitlines()[0]
    assert "usage: ros2 run slider_drilling recorder" in run(str(programs / "recorder"), "--help", **others())
    assert (installed / "share/ament_index/resource_index/packages/slider_drilling").is_file()
    for name in ("rocking", "real_rig", "replay", "two_rigs"):
        assert (installed / "share/slider_drilling/launch" / f"{name}.launch.py").is_file()


@pytest.mark.slow
def test_uninstalled_package_leaves_no_compiled_code(installed, tmp_path):
    compiles = "from slider_drilling.contact import dahl; print(dahl.signed_power(2.0, 1.0), dahl.__file__)"
    python = str(installed / "bin" / "python")
    printed = run(python, "-c", compiles, XDG_CACHE_HOME=str(tmp_path), **others())
    assert str(installed) in printed and list(tmp_path.rglob("*.nbi"))
    pip(installed, "uninstall", "-q", "-y", "slider_drilling")
    assert not list(installed.rglob("*slider_drilling*"))
