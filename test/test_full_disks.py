"""Full disks: a command reports them in one line and still prints its answer."""

from __future__ import annotations

import json
import resource
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from fork_server import run_cli

from slider_drilling.cli import group
from slider_drilling.errors import InputError

sys.path.insert(0, str(Path(__file__).parent / "fuzz"))
from commands import COMMANDS, make_inputs
from output_checks import contents

CAMPAIGN = "closed-loop --campaign"
QUICK = ("plot", "replay", "torque-drag", "identify", "import", "recover", "analyse", "study")
ANSWERS = {"plot": "toolface error", "replay": "surface torque", "torque-drag": "slack off", "identify": "stiffness",
           "analyse": "friction", "study": "holds", CAMPAIGN: "mean toolface error"}  # fmt: skip


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    here = tmp_path_factory.mktemp("desk")
    make_inputs(here)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(here)
        # Compiled, and imported, where there is room.
        import joblib  # noqa: F401

        group.main(COMMANDS["identify"].format(out=here / "identified").split(), standalone_mode=False)
    return here


@contextmanager
def room_for(size: int) -> Iterator[None]:
    """No file of this process may grow beyond ``size`` bytes: the system refuses to write more, as on a full disk."""
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    with pytest.MonkeyPatch.context() as patch:
        # Python would write the beginning of a compiled module and keep it, and no later test could import that one.
        patch.setattr(sys, "dont_write_bytecode", True)
        patch.setenv("PYTHONDONTWRITEBYTECODE", "1")
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
            signal.signal(signal.SIGXFSZ, before)


# A campaign's locks are files of 32 bytes in shared memory.
@pytest.mark.parametrize(
    ("name", "room"), [*((name, 0) for name in QUICK), ("torque-drag", 3000), ("plot", 3000), (CAMPAIGN, 40)]
)
def test_command_reports_full_disk_and_answers(
    name: str,
    room: int,
    desk: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(desk)
    words = COMMANDS[name].replace("study all", "study wear_modes").format(out=tmp_path).split()
    stems = ("run", "replayed", "torque_drag", "identify", "imported", "analysis")
    kept = [tmp_path / f"{stem}{suffix}" for stem in stems for suffix in (".html", ".mcap", ".json")]
    for path in kept:
        path.write_bytes(b"of before")
    as_json = room == 0 and name in ANSWERS
    with room_for(room), pytest.raises(InputError, match="File too large"):
        group.main([*words, *["--json"] * as_json], standalone_mode=False)
    said = capsys.readouterr().out
    if as_json:
        assert json.loads(said)["wrote"] == []
    elif name in ANSWERS:
        assert ANSWERS[name] in said
    left = contents(tmp_path)
    whole = {path for path, content in left.items() if path in kept and content == b"of before"}
    # What fitted into the room was replaced as a whole, the rest is as it was, and nothing is half there.
    assert all(path in left for path in kept)
    for path in set(left) - whole:
        assert not path.name.endswith(".part") and len(left[path]) <= room
        if path.suffix == ".json":
            json.loads(left[path])


def test_files_are_written_with_closed_stdout(desk: Path, tmp_path: Path) -> None:
    with open("/dev/full", "wb") as full:
        answer = run_cli(*COMMANDS["torque-drag"].format(out=tmp_path).split(), folder=desk, output=full.fileno())
    errors = [line for line in answer.stderr.splitlines() if not line.startswith("note: ")]
    assert (answer.returncode, len(errors)) == (2, 1)
    assert {path.name for path in contents(tmp_path)} == {
        "torque_drag.html", "torque_drag.png", "torque_drag.csv", "torque_drag.rig.yaml",
    }  # fmt: skip
