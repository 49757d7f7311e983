"""The scheduler of a cluster: any of `dask.distributed`."""

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

# s, for a first answer and for a first worker.
_ANSWER_S, _WORKER_S = 5.0, 30.0


@contextmanager
def connect(address: str, patience: float) -> Iterator[Any]:
    """A client of the scheduler, tried for patience s. Raises InputError where none answers or none works for it."""
    try:
        from distributed import Client
    except ImportError:
        raise InputError(f"--scheduler {address}: needs `pip install 'slider_drilling[cluster]'`") from None

    # A lost scheduler is told of in a line, not in a traceback for each of its connections.
    for name in ("distributed", "distributed.client", "distributed.core", "distributed.comm"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    deadline = time.monotonic() + patience
    while True:
        try:
            client = Client(address, timeout=_ANSWER_S)
            break
        except (OSError, ValueError) as error:
            if isinstance(error, ValueError):
                raise InputError(f"--scheduler {address}: not an address such as tcp://HOST:8786: {error}") from None
            if time.monotonic() > deadline:
                raise InputError(f"--scheduler {address}: no scheduler answers there; is it running?") from None
            time.sleep(1.0)
    try:
        _await_worker(client, address, max(patience, _WORKER_S))
        yield client
    finally:
        client.close(timeout=_ANSWER_S)


def _await_worker(client: Any, address: str, seconds: float) -> None:
    try:
        client.wait_for_workers(1, timeout=seconds)
    except TimeoutError:
        raise InputError(f"--scheduler {address}: it has no worker; start one with `dask worker {address}`") from None


class SchedulerLostError(Exception):
    """The scheduler is gone."""


def run_on_cluster(client: Any, jobs: Mapping[str, Job], folder: Path) -> Iterator[tuple[str, str | None]]:
    """Run jobs on the cluster; each one's key and why it has no result, or None, as they end. Raises LostError.

    A job whose worker died is given to another one, which dask does three times.
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
