"""Signals end a command in order, keep finished work, and give an exit code that names the signal."""

from __future__ import annotations

import io
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from process_groups import ends

from slider_drilling.pages import Chart, Line, Panel
from slider_drilling.pages.png import render_png
from slider_drilling.process import shutdown as interrupts
from slider_drilling.units import SI

sys.path.insert(0, str(Path(__file__).parent / "fuzz"))
import kills
from commands import COMMANDS, make_inputs
from tally import EXPECTED

BODY = """\
import os, signal, sys
for number in signal.SIGINT, signal.SIGTERM, signal.SIGHUP:
    signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
import click
from slider_drilling import cli
from slider_drilling.process.shutdown import raise_on_signals

def act():
    raise_on_signals()
    try:
        print("begun", flush=True)
        while True:
            signal.pause()
    except KeyboardInterrupt:
        if len(sys.argv) == 1:
            raise
    print("partial answer")

cli.run_group(click.Group("g", commands={"act": click.Command("act", callback=act)}), ["act"])
"""
STUCK = """\
class Stuck:
    def __init__(self, rig):
        pass
    def step(self, measurements):
        open("in_step", "a").close()
        while True:
            pass
"""


def code_and_words(arguments: list[str], number: signal.Signals) -> tuple[int, str, str]:
    with subprocess.Popen(
        [sys.executable, "-c", BODY, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        process.send_signal(number)
        try:
            said, complained = process.communicate(timeout=60)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
        return process.returncode, said, complained.strip()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_exit_code_names_the_signal(number: signal.Signals) -> None:
    assert code_and_words([], number) == (128 + number, "", "interrupted")
    assert code_and_words(["keeps"], number) == (128 + number, "partial answer\n", "")


def test_ignored_signal_stays_ignored() -> None:
    ignoring = BODY.replace("def act():", "def act():\n    signal.signal(signal.SIGHUP, signal.SIG_IGN)")
    with subprocess.Popen(
        [sys.executable, "-c", ignoring], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None and process.stdout.readline() == "begun\n"
        process.send_signal(signal.SIGHUP)
        time.sleep(0.3)
        assert process.poll() is None
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
        assert process.returncode == 143


def test_signal_in_a_finaliser_is_not_lost() -> None:
    losing = BODY.replace("        while True:\n", "        Lost()\n        while True:\n").replace(
        "def act():", "class Lost:\n    def __del__(self):\n        os.kill(os.getpid(), signal.SIGTERM)\n        "
        "for _ in range(1000):\n            pass\n\ndef act():"
    )  # fmt: skip
    answer = subprocess.run([sys.executable, "-c", losing], capture_output=True, text=True, timeout=60)
    assert (answer.returncode, answer.stdout, answer.stderr.strip()) == (143, "begun\n", "interrupted")


CLASS = """\
        class Named:
            def __set_name__(self, owner, name):
                os.kill(os.getpid(), signal.SIGTERM)
                for _ in range(1000):
                    pass
        class Made:
            it = Named()
"""


@pytest.mark.parametrize("within", [CLASS, CLASS.replace("signal.SIGTERM)", "0); 1 / 0")])
def test_wrapped_signal_is_recognised(within: str) -> None:
    code = BODY.replace("        while True:\n            signal.pause()\n", within)
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    if "1 / 0" in within:
        assert answer.returncode == 1 and "ZeroDivisionError" in answer.stderr
    else:
        assert (answer.returncode, answer.stderr.strip()) == (143, "interrupted")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signal_waits_until_picture_is_drawn(
    number: signal.Signals, monkeypatch: pytest.MonkeyPatch, own_handlers: None
) -> None:
    drawn = []

    def draw(canvas: FigureCanvasAgg, held: io.BytesIO) -> None:
        os.kill(os.getpid(), number)
        drawn.append(original(canvas, held))

    original = FigureCanvasAgg.print_png
    monkeypatch.setattr(FigureCanvasAgg, "print_png", draw)
    interrupts.raise_on_signals()
    line = Line("a", np.arange(3.0), np.arange(3.0))
    with pytest.raises(interrupts.TerminationSignal, match=number.name):
        render_png((Chart("title", "time, s", (Panel("angle, rad", (line,)),)),), SI)
    assert drawn and interrupts.signal_exit_code() == 128 + number
    with pytest.raises(interrupts.TerminationSignal):
        os.kill(os.getpid(), number)  # no more put off


@pytest.fixture
def own_handlers() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    hook = sys.unraisablehook
    for number in before:
        signal.signal(number, signal.SIG_DFL)  # under nohup one of them is ignored
    yield
    interrupts.raise_on_signals()  # forgets those that came
    sys.unraisablehook = hook
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("closed", [1, 2])
def test_closed_output_gives_no_traceback(repository: Path, closed: int) -> None:
    command = f"exec {sys.executable} -m slider_drilling study --list {closed}>&-"
    answer = subprocess.run(command, shell=True, cwd=repository, capture_output=True, text=True, timeout=120)
    assert answer.returncode == 0
    assert "Traceback" not in answer.stderr


def test_full_disk_behind_stdout_is_one_line(repository: Path) -> None:
    command = f"exec {sys.executable} -m slider_drilling study --list > /dev/full"
    answer = subprocess.run(command, shell=True, cwd=repository, capture_output=True, text=True, timeout=120)
    assert (answer.returncode, answer.stderr.count("\n")) == (2, 1)
    assert "No space left on device" in answer.stderr


def test_stuck_controller_ends_with_its_workers(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(STUCK)
    arguments = ["closed-loop", "--only", "hold, 2.6", "--elements", "20", "--controller", "mine:Stuck", "-o", "out"]
    process = subprocess.Popen(
        [sys.executable, "-m", "slider_drilling", *arguments],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        deadline = time.monotonic() + 120.0
        while not (tmp_path / "in_step").exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        assert (tmp_path / "in_step").exists()
        process.send_signal(signal.SIGTERM)
        assert process.wait(60.0) == 143
        assert ends(process.pid, 10.0), "a process was left behind"
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The inputs of commands, and what is there before."""
    here = tmp_path_factory.mktemp("desk")
    make_inputs(here)
    (here / "before").mkdir()
    (here / "before" / "imported.mcap").write_bytes((here / "run.mcap").read_bytes())
    return here


@pytest.mark.parametrize("number", kills.SIGNALS)
def test_killed_import_leaves_a_whole_log(number: signal.Signals, desk: Path) -> None:
    after = random.Random(f"a small kill {number}").uniform(0.2, 1.5)
    assert kills.killed(COMMANDS["import"], number, after, desk / "before", desk) in EXPECTED
