"""What every test may ask for: the checkout, the shared recordings, one hypothesis profile."""

import gc
import hashlib
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import pytest

if "PYTEST_XDIST_WORKER" in os.environ:
    # Several workers share the cores already: threads in each would only wait for one another.
    os.environ.setdefault("NUMBA_NUM_THREADS", "1")

# In a shell's background interrupts are ignored, also by whatever is started from there: tests interrupt programs.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)

hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None, print_blob=True)
hypothesis.settings.load_profile("repeatable")


@pytest.hookimpl(hookwrapper=True)
def pytest_collection() -> Iterator[None]:
    """Keep the garbage collector from all that collection imports, which stays: a million objects at each turn."""
    gc.disable()
    yield
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give each of several workers its share of modules that wait for other processes, which fill the end otherwise."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        items.sort(key=lambda item: hashlib.sha256(item.nodeid.partition("::")[0].encode()).digest())


@pytest.fixture(scope="session")
def repository() -> Path:
    """The checkout that the tests run from."""
    return Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def shared_data(repository: Path) -> Path:
    """Recordings kept outside the repository: SLIDER_DRILLING_SHARED/data, else ../shared/data."""
    shared = Path(os.environ.get("SLIDER_DRILLING_SHARED", repository.parent / "shared"))
    if not (shared / "data").is_dir():
        pytest.skip(f"no recordings at {shared / 'data'}; set SLIDER_DRILLING_SHARED")
    return shared / "data"
