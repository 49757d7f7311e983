"""What every test may ask for: the checkout, the shared recordings, one hypothesis profile."""

import os
from pathlib import Path

import hypothesis
import pytest

if "PYTEST_XDIST_WORKER" in os.environ:
    # Several workers share the cores already: threads in each would only wait for one another.
    os.environ.setdefault("NUMBA_NUM_THREADS", "1")

hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None, print_blob=True)
hypothesis.settings.load_profile("repeatable")

# What takes longest is begun first, so that no worker is left with it at the end. Of the first two one compiles the
# step of the string and the other what a diagnosis needs: neither waits for the same code to be compiled twice.
BEGUN_FIRST = (
    "test_closed_loop_campaign.py", "gap/test_toy.py", "nodes/test_nodes_that_notice.py", "test_blind_small.py",
    "test_analysis.py", "nodes/test_programs.py", "nodes/test_run_command.py", "nodes/test_at_home_in_the_graph.py",
    "test_notebooks.py", "test_campaign_cluster.py", "test_rig_ranges.py", "test_blind_seal.py", "test_closed_loop.py",
    "test_full_disks.py", "test_diagnosis_drill_string.py", "test_cli.py", "test_signals.py",
    "test_slide_controller.py", "nodes/test_session.py", "nodes/test_opcua_bridge.py", "test_log_recover.py",
    "test_blind_plan.py", "nodes/test_place.py", "gap/test_missed_steps.py", "test_contact_dahl.py", "test_tools.py",
)  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files in the order in which workers are to take them."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        here = Path(__file__).parent
        ranks = {here / name: rank for rank, name in enumerate(BEGUN_FIRST)}
        items.sort(key=lambda item: ranks.get(item.path, len(ranks)))


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
