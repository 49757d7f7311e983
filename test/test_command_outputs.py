"""What commands write: never over what they read, never through links, and only where it can be written."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest
from fork_server import run_cli

from slider_drilling.cli import group
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import (
    check_distinct,
    check_outputs,
    commit_part_file,
    create_part_file,
    make_subfolder,
    write_atomically,
)

EXAMPLE = Path(__file__).parents[1] / "config" / "rig.example.yaml"


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A folder with one of each input, its content as it must stay."""
    monkeypatch.chdir(tmp_path)
    for name in ("run.mcap", "table.csv", "mapping.yaml", "identify.csv", "rig.tuned.yaml", "analysis.json"):
        Path(name).write_text(f"content of {name}")
    Path("rig.yaml").write_text(EXAMPLE.read_text())
    os.symlink("run.mcap", "linked.mcap")
    os.link("run.mcap", "hard.mcap")
    Path("folder").mkdir()
    before = {path: path.read_bytes() for path in Path().iterdir() if path.is_file()}
    yield
    assert {path: path.read_bytes() for path in before} == before
    assert Path("linked.mcap").is_symlink()
    assert not list(Path().glob("**/.*.part"))


@pytest.mark.parametrize(
    "arguments",
    [
        "replay run.mcap -o run.mcap",
        "replay run.mcap -o ./folder/../run.mcap",
        "replay run.mcap -o linked.mcap",
        "replay linked.mcap -o run.mcap",
        "replay run.mcap -o hard.mcap",
        "replay run.mcap --rig rig.yaml -o rig.yaml",
        "import table.csv --mapping mapping.yaml -o table.csv",
        "import table.csv --mapping mapping.yaml -o mapping.yaml",
        "import table.csv --mapping mapping.yaml --rig rig.yaml -o rig.yaml",
        "diagnose run.mcap --rig rig.tuned.yaml -o .",
        "diagnose run.mcap --topics next_programme.yaml -o .",
        "identify identify.csv -o .",
        "analyse analysis.json -o .",
    ],
)
def test_output_that_is_an_input_is_refused_first(arguments: str) -> None:
    with pytest.raises(InputError, match="in use already; choose another name"):
        group.main(arguments.split(), standalone_mode=False)


@pytest.mark.parametrize(
    "arguments",
    ["replay run.mcap -o absent/a.mcap", "import table.csv --mapping mapping.yaml -o folder",
     "diagnose run.mcap -o run.mcap/deeper", "analyse run.mcap -o run.mcap", "identify table.csv -o table.csv",
     "closed-loop --only hold -o run.mcap", "study rocking -o run.mcap", "blind-check -o run.mcap"],
)  # fmt: skip
def test_unwritable_output_is_refused_first(arguments: str) -> None:
    with pytest.raises(InputError, match=r"cannot (write this file|make this folder)"):
        group.main(arguments.split(), standalone_mode=False)


@pytest.mark.parametrize("arguments", [
    "diagnose none.mcap -o new/deep", "analyse none.mcap -o new", "torque-drag --survey none.csv -o new",
    "rocking-plan --rig none.yaml -o new", "plan-test --rig none.yaml -o new", "activities none.mcap -o new",
    "closed-loop --controller none:None --only hold -o new", "diagnose none.mcap none_2.mcap -o new",
])  # fmt: skip
def test_a_refused_command_leaves_no_folder(tmp_path: Path, arguments: str) -> None:
    before = sorted(tmp_path.iterdir())
    refused = run_cli(*arguments.split(), folder=tmp_path)
    assert refused.returncode == 2, refused.stderr
    assert sorted(tmp_path.iterdir()) == before


def test_same_log_twice_is_refused() -> None:
    Path("copy.mcap").write_bytes(Path("run.mcap").read_bytes())
    for other in ("run.mcap", "linked.mcap", "copy.mcap"):
        with pytest.raises(InputError, match=rf"{other}: the same as run.mcap; give each log once"):
            group.main(["diagnose", "run.mcap", other, "-o", "out"], standalone_mode=False)
    check_distinct([Path("run.mcap"), Path("table.csv"), Path("absent")])


def test_planted_link_is_not_written_through() -> None:
    Path("target").write_text("before")
    os.mkfifo("target-pipe")
    for name in ("target", "nowhere-yet", "target-pipe", "/dev/null"):
        os.symlink(name, "link")
        for write in (lambda: write_atomically(Path("link"), b"after"), lambda: check_outputs([Path("link")])):
            with pytest.raises(InputError, match=f"link: is a link to {name}; name that file itself, or delete"):
                write()
        Path("link").unlink()
    assert Path("target").read_text() == "before" and not Path("nowhere-yet").exists()
    os.symlink(".", "linked-folder")
    with pytest.raises(InputError, match="linked-folder: is a link to"):
        make_subfolder(Path(), "linked-folder")


def test_link_planted_meanwhile_is_replaced() -> None:
    Path("target").write_text("before")
    descriptor, part = create_part_file(Path("late"))
    os.close(descriptor)
    os.symlink("target", "late")
    commit_part_file(part, Path("late"))
    assert Path("target").read_text() == "before" and not Path("late").is_symlink()


def test_pipe_and_device_are_not_replaced() -> None:
    os.mkfifo("pipe")
    reader = os.open("pipe", os.O_RDONLY | os.O_NONBLOCK)
    check_outputs([Path("pipe"), Path("/dev/null")])
    write_atomically(Path("pipe"), b"through")
    write_atomically(Path("/dev/null"), b"gone")
    assert os.read(reader, 100) == b"through"
    os.close(reader)
    assert stat.S_ISFIFO(os.stat("pipe").st_mode)
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    for path in ("pipe", "/dev/null"):
        with pytest.raises(InputError, match="it is a device or a pipe; name a file"):
            create_part_file(Path(path))


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anything")
def test_read_only_file_is_not_replaced() -> None:
    Path("kept").write_text("before")
    Path("kept").chmod(0o444)
    with pytest.raises(InputError, match="kept: cannot write this file: it is read-only"):
        write_atomically(Path("kept"), b"after")
    assert Path("kept").read_text() == "before"


def test_two_outputs_of_same_name_are_refused() -> None:
    with pytest.raises(InputError, match="in use already"):
        check_outputs([Path("a"), Path("folder/../a")])


def test_impossible_file_name_is_reported_in_one_line() -> None:
    for name in ("a" * 300, "nul\x00byte"):
        with pytest.raises(InputError, match="cannot write this file"):
            check_outputs([Path(name)])
        with pytest.raises(InputError, match="cannot write this file"):
            write_atomically(Path(name), b"")


def test_longest_file_name_is_written() -> None:
    name = "µ" * 120
    write_atomically(Path(name), b"x")
    assert Path(name).read_bytes() == b"x"
