"""Compilation of the loops: one import of numba, widest vectors, announcements, number of threads."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from threading import Thread

import pytest
from numba.core import config

from slider_drilling.process.jit_cache import announce_compilation, available_threads, njit, vector_bits

PACKAGE = Path(__file__).parents[1] / "slider_drilling"


def test_njit_comes_from_jit_cache_only():
    takes = re.compile(r"^\s*(from numba import|import numba)", re.MULTILINE)
    assert [path.name for path in PACKAGE.rglob("*.py") if takes.search(path.read_text())] == ["jit_cache.py"]


def test_loops_are_compiled_for_the_widest_vectors():
    asks = "import slider_drilling.drillstring; from numba.core.registry import cpu_target as t;"
    asks += "print('-prefer-256-bit' in t.target_context.codegen().magic_tuple()[2])"
    command = [sys.executable, "-c", asks]
    answer = subprocess.run(command, capture_output=True, text=True, check=True, cwd=PACKAGE.parent)
    assert answer.stdout.strip() == str(vector_bits() == 512)


@pytest.mark.parametrize(
    ("variable", "said"),
    [
        ("NUMBA_NUM_THREADS=0", "NUMBA_NUM_THREADS=0: numba does not start: .* must be > 0; unset it"),
        ("NUMBA_NUM_THREADS=x", "NUMBA_NUM_THREADS=x: numba does not start: .* could not be parsed; unset it"),
        ("NUMBA_DISABLE_JIT=1", "NUMBA_DISABLE_JIT = 1: the loops run compiled only; unset it"),
    ],
)
def test_bad_numba_variable_is_named(variable, said):
    asks = "from slider_drilling.errors import InputError\ntry: import slider_drilling.process.jit_cache\n"
    asks += "except InputError as error: print(error)"
    name, _, value = variable.partition("=")
    answer = subprocess.run([sys.executable, "-c", asks], capture_output=True, text=True, check=True,
                            cwd=PACKAGE.parent, env={**os.environ, name: value})  # fmt: skip
    assert re.fullmatch(said + "\n", answer.stdout) and answer.stderr == ""


@pytest.fixture
def own_stderr(capsys):
    """What is said on the stderr that this test captures: the console is made once a process."""
    from slider_drilling.console import streams as console

    console.stderr.cache_clear()
    yield capsys
    console.stderr.cache_clear()


def test_compilation_is_announced_once(own_stderr):
    @njit
    def twice(x):
        return 2 * x

    with announce_compilation(twice, "a doubling"):
        assert twice(2) == 4
    first = own_stderr.readouterr()
    with announce_compilation(twice, "a doubling"):
        assert twice(3) == 6
    second = own_stderr.readouterr()
    assert "compiling a doubling for this processor" in first.err
    assert re.search(r"compiled in \d+ s", first.err)
    assert (first.out, second.out, second.err) == ("", "", "")


def test_only_the_compiling_thread_announces(own_stderr):
    @njit
    def thrice(x):
        return 3 * x

    def compile_it():
        with announce_compilation(thrice, "a tripling"):
            thrice(2)

    with announce_compilation(thrice, "a tripling"):
        other = Thread(target=compile_it)
        other.start()
        other.join()
    warned = own_stderr.readouterr().err
    assert warned.count("compiling a tripling") == warned.count("compiled in") == 1


def test_threads_are_all_cores_of_the_process():
    code = "import os; cores = sorted(os.sched_getaffinity(0))[:{count}]; os.sched_setaffinity(0, cores);"
    code += "from slider_drilling.process.jit_cache import available_threads; print(len(cores), available_threads())"
    variables = {name: value for name, value in os.environ.items() if name != "NUMBA_NUM_THREADS"}
    for count in ("1", ""):
        command = [sys.executable, "-c", code.format(count=count)]
        output = subprocess.run(command, capture_output=True, text=True, check=True, cwd=PACKAGE.parent, env=variables)
        cores, threads = map(int, output.stdout.split())
        assert threads == cores


@pytest.mark.parametrize("count", [1, 3, 64])
def test_numba_num_threads_limits_threads(count, monkeypatch):
    monkeypatch.setattr(config, "NUMBA_NUM_THREADS", count)
    assert available_threads() == count
