"""Jobs on the workers of a `dask.distributed` scheduler."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from slider_drilling.campaign.job import Job
from slider_drilling.campaign.worker_processes import run_on_cluster_worker
from slider_drilling.errors import InputError

_CONNECT_TIMEOUT_S = 5.0  # for one attempt
_FIRST_WORKER_TIMEOUT_S = 30.0


class SchedulerLostError(Exception):
    """The connection to the scheduler is lost."""


@contextmanager
def connect(address: str, patience: float) -> Iterator[Any]:
    """Gives a client of the scheduler.

    Args:
        address: Such as tcp://HOST:8786.
        patience: How long to try, s.

    Raises:
        InputError: No scheduler answers, or it has no worker.
    """
    try:
        from distributed import Client
    except ImportError:
        raise InputError(f"--scheduler {address}: needs `pip install 'slider_drilling[cluster]'`") from None

    # A lost scheduler is reported in one line, not by a traceback for each of its connections.
    for name in ("distributed", "distributed.client", "distributed.core", "distributed.comm"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    deadline = time.monotonic() + patience
    while True:
        try:
            client = Client(address, timeout=_CONNECT_TIMEOUT_S)
            break
        except ValueError as error:
            raise InputError(f"--scheduler {address}: not an address such as tcp://HOST:8786: {error}") from None
        except OSError:
            if time.monotonic() > deadline:
                raise InputError(f"--scheduler {address}: no scheduler answers there; is it running?") from None
            time.sleep(1.0)
    try:
        _await_worker(client, address, max(patience, _FIRST_WORKER_TIMEOUT_S))
        yield client
    finally:
        client.close(timeout=_CONNECT_TIMEOUT_S)


def _await_worker(client: Any, address: str, timeout: float) -> None:
    try:
        client.wait_for_workers(1, timeout=timeout)
    except TimeoutError:
        raise InputError(f"--scheduler {address}: it has no worker; start one with `dask worker {address}`") from None


def run_on_cluster(client: Any, jobs: Mapping[str, Job], folder: Path) -> Iterator[tuple[str, str | None]]:
    """Runs jobs on the cluster; dask gives a job whose worker died to another worker, up to three times.

    Args:
        client: Of the scheduler.
        jobs: Jobs by key.
        folder: Folder of the results; the workers must see it too.

    Yields:
        The key of each job as it ends, and why it has no result or None.

    Raises:
        SchedulerLostError: The connection to the scheduler is lost.
    """
    from distributed import CancelledError, KilledWorker, as_completed
    from distributed.comm.core import CommClosedError

    keys = {client.submit(run_on_cluster_worker, job, key, str(folder), pure=False): key for key, job in jobs.items()}
    try:
        for future in as_completed(list(keys)):
            try:
                yield keys[future], future.result()
            except KilledWorker:
                yield keys[future], "every worker that took it died"
    except (CancelledError, CommClosedError, OSError):
        raise SchedulerLostError from None
    finally:
        for future in keys:
            future.release()
