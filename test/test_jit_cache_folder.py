"""The folder of compiled code: one per version of the sources, where this user can write."""

from __future__ import annotations

import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from slider_drilling.contact.dahl import signed_power
from slider_drilling.errors import InputError
from slider_drilling.process import jit_cache_folder, jit_cache_lock
from slider_drilling.process.jit_cache_folder import cache_folder, source_hash, versioned_cache_folder

LIBRARIES = ("numba 1", "numpy 2")


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package of a compiling module, a module that it imports, and one that has nothing to do with it."""
    folder = tmp_path / "sources" / "plant"
    folder.mkdir(parents=True)
    for name, text in {
        "__init__.py": "",
        "loop.py": "from plant.process.jit_cache import njit\nfrom plant import layout\n",
        "layout.py": "SIZE = 1\n",
        "page.py": "TITLE = ''\n",
    }.items():
        (folder / name).write_text(text)
    return folder


@pytest.mark.parametrize(
    ("file", "changes"), [("loop.py", True), ("layout.py", True), ("page.py", False), ("process/new.py", False)]
)
def test_hash_follows_imported_sources(file: str, changes: bool, package: Path) -> None:
    before = source_hash(package / "loop.py", LIBRARIES, package)
    (package / file).parent.mkdir(exist_ok=True)
    (package / file).write_text((package / file).read_text() + "#" if (package / file).is_file() else "X = 1\n")
    assert (source_hash(package / "loop.py", LIBRARIES, package) != before) == changes


def test_hash_follows_moved_modules_and_libraries(package: Path) -> None:
    loop = package / "loop.py"
    hashes = {source_hash(loop, LIBRARIES, package), source_hash(loop, ("numba 1", "numpy 3"), package)}
    (package / "layout.py").rename(package / "arrays.py")
    (package / "loop.py").write_text((package / "loop.py").read_text().replace("layout", "arrays"))
    assert len(hashes | {source_hash(package / "loop.py", LIBRARIES, package)}) == 3


def test_unused_versions_are_removed(package: Path, tmp_path: Path) -> None:
    recent, old, foreign = (tmp_path / "base" / name for name in ("sources-1", "sources-0", "mine"))
    for folder in (recent, old, foreign):
        folder.mkdir(parents=True)
    for folder in (old, foreign):
        os.utime(folder, (0.0, 0.0))
    used = Path(versioned_cache_folder(str(tmp_path / "base"), package / "loop.py", LIBRARIES))
    assert {used, recent, foreign} == set((tmp_path / "base").iterdir())


COMPILE = "from slider_drilling.contact.dahl import signed_power; assert signed_power(2.0, 1.0) == 2.0"
# The classes that numba reads back with an index; this module has moved since.
MOVED = b"cslider_drilling.drillstring.layout\nShape\n."


def test_caches_of_older_versions_do_no_harm(repository: Path, tmp_path: Path) -> None:
    """Beside the source, where they were written before, and in the folder of another version."""
    sources, caches = tmp_path / "sources", tmp_path / "caches"
    shutil.copytree(
        repository / "slider_drilling", sources / "slider_drilling", ignore=shutil.ignore_patterns("__pycache__")
    )
    environment = {**os.environ, "PYTHONPATH": str(sources), "XDG_CACHE_HOME": str(caches)}
    environment.pop("NUMBA_CACHE_DIR", None)

    def compile_once() -> Path:
        subprocess.run([sys.executable, "-c", COMPILE], check=True, env=environment, cwd=tmp_path)
        (newest, *_) = sorted(caches.rglob("*.nbi"), key=lambda path: path.stat().st_mtime, reverse=True)
        return newest

    index = compile_once()
    broken = pickle.dumps(numba.__version__) + MOVED
    index.write_bytes(broken)
    beside = sources / "slider_drilling" / "contact" / "__pycache__"
    beside.mkdir(exist_ok=True)
    (beside / index.name).write_bytes(broken)
    with (sources / "slider_drilling" / "contact" / "dahl.py").open("a") as module:
        module.write("# a newer version\n")
    assert compile_once() != index and index.read_bytes() == broken


def test_unwritable_given_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"NUMBA_CACHE_DIR = .*file/deeper: cannot be written: Not a directory; name"):
        cache_folder(str(tmp_path / "file" / "deeper"))
    assert cache_folder(str(tmp_path / "new")) == str(tmp_path / "new")
    assert os.listdir(tmp_path / "new") == []


def test_without_a_home_one_temporary_folder_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    monkeypatch.setattr(jit_cache_folder.tempfile, "gettempdir", lambda: str(tmp_path))
    first = cache_folder("")
    assert (Path(first).parent, Path(first).stat().st_mode & 0o777) == (tmp_path, 0o700)
    assert cache_folder("") == first
    Path(first).chmod(0o777)
    with pytest.raises(InputError, match="not this user's own folder"):
        cache_folder("")


def test_of_programs_that_start_together_one_compiles(repository: Path, tmp_path: Path) -> None:
    program = (
        "from slider_drilling.contact.dahl import signed_power as compiled\n"
        "compiled(2.0, 1.0); print(sum(compiled.stats.cache_misses.values()))"
    )
    environment = {**os.environ, "PYTHONPATH": str(repository), "NUMBA_CACHE_DIR": str(tmp_path)}
    together = [
        subprocess.Popen([sys.executable, "-c", program], env=environment, stdout=subprocess.PIPE) for _ in range(4)
    ]
    assert sum(int(each.communicate()[0]) for each in together) == 1


def test_stopped_compilation_delays_others_by_a_minute_at_most(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit_cache_lock, "_LONGEST_WAIT_S", 0.2)
    monkeypatch.setattr(numba.core.config, "CACHE_DIR", str(tmp_path))
    caches = [jit_cache_lock.LockedFunctionCache(signed_power.py_func) for _ in range(2)]
    signature = numba.float64(numba.float64, numba.float64)
    for cache in caches:
        assert cache.load_overload(signature, signed_power.targetctx) is None
