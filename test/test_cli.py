"""The command line: help without imports, one line for a user's mistake, exit codes."""

import importlib
import json
import marshal
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import click
import pytest
from fork_server import run_cli

from slider_drilling import __version__, cli
from slider_drilling.cli import COMMANDS, CommandEntry, LazyGroup, run_group
from slider_drilling.errors import InputError


def run(repository: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "slider_drilling", *arguments]
    return subprocess.run(command, cwd=repository, capture_output=True, text=True, timeout=120)


def group_of(body: Callable[[], object]) -> click.Group:
    group = click.Group("slider-drilling")
    group.add_command(click.Command("act", callback=body))
    return group


def outcome(capsys: pytest.CaptureFixture[str], body: Callable[[], object]) -> tuple[int, str]:
    with pytest.raises(SystemExit) as stop:
        run_group(group_of(body), ["act"])
    assert isinstance(stop.value.code, int)
    return stop.value.code, capsys.readouterr().err


def test_version(repository: Path) -> None:
    answer = run(repository, "--version")
    assert (answer.returncode, answer.stderr) == (0, "")
    assert answer.stdout.strip().endswith(__version__)


def test_help_lists_every_command_with_examples(repository: Path) -> None:
    answer = run(repository, "--help")
    assert answer.returncode == 0
    assert "Examples:" in answer.stdout
    indented = [line.split() for line in answer.stdout.splitlines() if line.startswith("  ")]
    listed = {words[0] for words in indented if words}
    assert set(COMMANDS) <= listed


def test_numpy_is_imported_with_one_thread(repository: Path, tmp_path: Path) -> None:
    probe = (
        "import os, sys\nfrom importlib.abc import MetaPathFinder\nfrom slider_drilling.cli import main\n"
        "class Seen(MetaPathFinder):\n"
        "    def find_spec(self, name, path, target=None):\n"
        "        if name == 'numpy': print('threads', os.environ.get('OPENBLAS_NUM_THREADS'), file=sys.stderr)\n"
        "sys.meta_path.insert(0, Seen())\nsys.argv = ['slider-drilling', 'diagnose', 'absent.mcap']\nmain()"
    )
    left = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    answer = subprocess.run(
        [sys.executable, "-c", probe], cwd=tmp_path, env={**left, "PYTHONPATH": str(repository)}, capture_output=True,
        text=True, timeout=120,
    )  # fmt: skip
    assert "threads 1" in answer.stderr
    assert "absent.mcap" in answer.stderr


def test_help_imports_neither_arrays_nor_ros(repository: Path) -> None:
    probe = (
        "import sys\nfrom slider_drilling.cli import group\n"
        "group.main(['--help'], standalone_mode=False)\n"
        "heavy = {'numpy', 'scipy', 'numba', 'rclpy', 'mcap', 'rich'}\n"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    answer = subprocess.run([sys.executable, "-c", probe], cwd=repository, capture_output=True, text=True, timeout=120)
    assert answer.returncode == 0
    assert answer.stderr.strip() == "[]"


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_answers_help(repository: Path, name: str) -> None:
    answer = run_cli(name, "--help", folder=repository)
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.startswith(f"Usage: slider-drilling {name}")


def test_unknown_command_is_one_line(repository: Path) -> None:
    answer = run(repository, "no-such-command")
    assert answer.returncode == 2
    assert answer.stderr.count("\n") == 1
    assert "no-such-command" in answer.stderr


@pytest.mark.parametrize("words", [("info", "run.mcap"), ("run", "--duration", "1"), ("plot", "run.mcap")])
def test_bad_source_date_epoch_is_refused(
    words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "x")
    with pytest.raises(SystemExit, match="2"):
        run_group(cli.group, list(words))
    line = "SOURCE_DATE_EPOCH = 'x': must be a whole number of seconds since 1970; correct it, or unset it\n"
    assert capsys.readouterr().err == line


def test_lazy_group_imports_a_command_when_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    module = type(sys)("lazy_example")
    module.command = click.Command("example")  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "lazy_example", module)
    group = LazyGroup("slider-drilling", table={"example": CommandEntry("lazy_example", "an example")})
    context = click.Context(group)
    assert group.list_commands(context) == ["example"]
    assert group.get_command(context, "example") is module.command
    assert group.get_command(context, "other") is None


def test_input_error_is_one_line_and_code_2(capsys: pytest.CaptureFixture[str]) -> None:
    def body() -> None:
        raise InputError("rig.yaml: well.survey = []:\n   empty; give at least two stations")

    assert outcome(capsys, body) == (2, "rig.yaml: well.survey = []: empty; give at least two stations\n")


def test_full_disk_names_the_file(capsys: pytest.CaptureFixture[str]) -> None:
    def body() -> None:
        with open("/dev/full", "w") as full:
            full.write("x")

    code, said = outcome(capsys, body)
    assert code == 2
    assert said.count("\n") == 1
    assert "No space left on device" in said


def test_full_disk_is_named_while_stdout_is_kept_for_json(repository: Path) -> None:
    with open("/dev/full", "wb") as full:
        answer = run_cli("closed-loop", "--list", "--json", folder=repository, output=full.fileno())
    assert (answer.returncode, answer.stderr) == (2, "slider-drilling: No space left on device\n")


def test_cut_off_module_is_no_interrupt(capsys: pytest.CaptureFixture[str]) -> None:
    def body() -> None:
        marshal.loads(marshal.dumps((1, 2))[:-1])

    code, said = outcome(capsys, body)
    assert code == 2 and said.strip().count("\n") == 0
    assert "compiled Python modules are cut off" in said and "__pycache__" in said


def test_interrupt_is_code_130(capsys: pytest.CaptureFixture[str]) -> None:
    def body() -> None:
        os.kill(os.getpid(), signal.SIGINT)
        signal.pause()

    # A suite that a shell runs in the background is born with interrupts ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        code, said = outcome(capsys, body)
    finally:
        signal.signal(signal.SIGINT, before)
    assert (code, said.strip()) == (130, "interrupted")


def test_programming_error_keeps_its_traceback() -> None:
    def body() -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_group(group_of(body), ["act"])


def test_closed_pipe_is_silent(repository: Path) -> None:
    command = [
        sys.executable,
        "-c",
        "from slider_drilling.cli import *\n"
        "import sys\n"
        "run_group(click.Group('g', commands={'act': click.Command('act', callback=lambda: "
        "[print('x' * 1000) for _ in range(1000)])}), ['act'])",
    ]
    with subprocess.Popen(command, cwd=repository, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.read(10)
        process.stdout.close()
        said = process.stderr.read()
        assert process.wait(timeout=60) == 1
    assert said == b""


def test_table_rows_have_help() -> None:
    assert all(row.help and len(row.help) < 90 for row in cli.COMMANDS.values())


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_script_names_the_program(repository: Path, shell: str) -> None:
    answer = run_cli("completion", shell, folder=repository)
    assert answer.returncode == 0
    assert "_SLIDER_DRILLING_COMPLETE" in answer.stdout


@pytest.mark.parametrize(("words", "expected"), [
    ("slider-drilling r", {"run", "replay"}),
    ("slider-drilling run --effect torque_s", {"torque_sensor_gain", "torque_sensor_lag", "torque_sensor_bias"}),
    ("slider-drilling study wear", {"wear_modes"}),
    ("slider-drilling run --liv", {"--live", "--live-host", "--live-port", "--live-token-file"}),
])  # fmt: skip
def test_shell_completes(repository: Path, words: str, expected: set[str]) -> None:
    environment = {**os.environ, "_SLIDER_DRILLING_COMPLETE": "bash_complete", "COMP_WORDS": words,
                   "COMP_CWORD": str(len(words.split()) - 1)}
    answer = subprocess.run([sys.executable, "-m", "slider_drilling"], cwd=repository, env=environment,
                            capture_output=True, text=True, timeout=120)
    found = {line.partition(",")[2] for line in answer.stdout.splitlines()}
    assert expected <= found if words.endswith(" r") else found == expected


def test_every_answering_command_has_json() -> None:
    for name in set(COMMANDS) - {"completion"}:
        command = importlib.import_module(COMMANDS[name].module).command
        for one in command.commands.values() if isinstance(command, click.Group) else (command,):
            assert any("--json" in parameter.opts for parameter in one.params), name


@pytest.mark.parametrize(("words", "key"), [
    (("torque-drag", "--elements", "20", "--friction", "0.2"), "at_total_depth"),
    (("study", "wear_modes", "-o", "studies"), "studies"),
])  # fmt: skip
def test_json_is_all_of_stdout(tmp_path: Path, words: tuple[str, ...], key: str) -> None:
    answer = run_cli(*words, "--json", folder=tmp_path)
    assert answer.returncode == 0, answer.stderr
    tree = json.loads(answer.stdout)
    assert tree[key]
    assert tree["wrote"] and all((tmp_path / path).is_file() for path in tree["wrote"])


@pytest.mark.parametrize("words", [("torque-drag", "--elements", "20"), ("closed-loop", "--list"), ("study", "--list")])
def test_piped_output_fits_eighty_columns(tmp_path: Path, words: tuple[str, ...]) -> None:
    answer = run_cli(*words, folder=tmp_path)
    assert answer.returncode == 0, answer.stderr
    assert max(map(len, answer.stdout.splitlines())) <= 80
