"""Campaigns on a real scheduler with two workers, of which one is killed; the scheduler is lost and comes back."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from slider_drilling.campaign.job import Job
from slider_drilling.campaign.run import WorkerSettings, run_jobs
from slider_drilling.errors import InputError

if importlib.util.find_spec("distributed") is None:  # not imported, which would take every worker half a second
    pytest.skip("the extra `cluster` is not installed", allow_module_level=True)

KINDS = """
import time
from pathlib import Path

def square(job):
    begun = Path(job.inputs["number"] + ".begun")
    begun.open("a").write("x")
    time.sleep(job.options["sleep"])
    return {"square": int(Path(job.inputs["number"]).read_text())**2}
"""


class Cluster:
    """`dask scheduler` and two `dask worker` on the loopback."""

    def __init__(self, folder):
        self.folder = folder
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.started = []

    def start(self, *arguments):
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(self.folder), *sys.path])}
        process = subprocess.Popen([sys.executable, "-m", "dask", *arguments], env=environment,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   start_new_session=True)  # fmt: skip
        self.started.append(process)
        return process

    def scheduler(self):
        process = self.start("scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--no-dashboard")
        deadline = time.monotonic() + 60.0
        while True:
            try:
                socket.create_connection(("127.0.0.1", self.port), 1.0).close()
                return process
            except OSError:
                assert time.monotonic() < deadline, "the scheduler does not start"
                time.sleep(0.1)

    def worker(self, name):
        place = ("--local-directory", str(self.folder / name), "--no-dashboard", "--host", "127.0.0.1")
        return self.start("worker", self.address, "--nthreads", "1", "--name", name, *place)


@pytest.fixture
def cluster(tmp_path, monkeypatch):
    (tmp_path / "squares_on_a_cluster.py").write_text(KINDS)
    monkeypatch.syspath_prepend(str(tmp_path))
    cluster = Cluster(tmp_path)
    yield cluster
    # Asked to end, a worker says farewell to a scheduler that is gone, for up to 20 s; what it holds is in tmp_path.
    for process in cluster.started:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def make_jobs(folder, count, sleep):
    jobs = []
    for number in range(count):
        path = folder / f"number_{number}"
        path.write_text(str(number))
        name = "squares_on_a_cluster:square"
        jobs.append(Job(name, f"of {number}", {"number": str(path)}, {"sleep": sleep}))
    return jobs


def children_of(process):
    found = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            pid, parent = status.parent.name, status.read_text().rpartition(")")[2].split()[1]
        except OSError:
            continue
        found += [int(pid)] if int(parent) == process.pid else []
    assert found, "no worker to kill"
    return found


@pytest.mark.slow
def test_all_jobs_survive_lost_worker_and_scheduler(cluster, tmp_path):
    scheduler = cluster.scheduler()
    nannies = [cluster.worker("a"), cluster.worker("b")]
    jobs = make_jobs(tmp_path, 12, 0.5)
    ended = []

    def said(job, key, why):
        nonlocal scheduler
        ended.append(job.name)
        if len(ended) == 3:
            for pid in children_of(nannies[0]):
                os.kill(pid, signal.SIGKILL)
        if len(ended) == 6:
            scheduler.kill()
            scheduler.wait()
            # A worker that lost its scheduler ends: whoever runs the cluster starts both again.
            scheduler = cluster.scheduler()
            cluster.worker("c")
            cluster.worker("d")

    ran = run_jobs(jobs, tmp_path / "results", WorkerSettings(scheduler=cluster.address, patience=60.0), said)
    assert (ran.completed, ran.failed, ran.exit_code) == (12, {}, 0)
    assert sorted(ended) == sorted(job.name for job in jobs)
    results = [json.loads((tmp_path / "results" / f"{key}.json").read_text())["result"] for key in ran.keys]
    assert results == [{"square": number**2} for number in range(12)]
    begun = [len(Path(job.inputs["number"] + ".begun").read_text()) for job in jobs]
    # Two workers: what was under way when one died, and when the scheduler did, is all that ran twice.
    assert sum(begun) <= 12 + 1 + 4


@pytest.mark.slow
def test_campaign_without_scheduler_continues_from_its_files(cluster, tmp_path):
    scheduler, nanny = cluster.scheduler(), cluster.worker("a")
    jobs = make_jobs(tmp_path, 6, 0.5)

    def all_go(job, key, why):
        # The worker too: it would go on with what it has been given, and that would count.
        if scheduler.poll() is None:
            for pid in (*children_of(nanny), nanny.pid, scheduler.pid):
                os.kill(pid, signal.SIGKILL)
            scheduler.wait()

    ran = run_jobs(jobs, tmp_path / "results", WorkerSettings(scheduler=cluster.address, patience=0.5), all_go)
    assert ran.stop_code == 3 and "no scheduler answers" in ran.stop_reason and ran.completed >= 1
    assert "run the same command to continue" in ran.summary()
    here = run_jobs(jobs, tmp_path / "results", WorkerSettings(2))
    assert here.exit_code == 0 and here.already_done >= ran.completed and here.already_done + here.completed == 6


@pytest.mark.slow
def test_missing_scheduler_is_one_line(tmp_path, cluster):
    jobs = make_jobs(tmp_path, 1, 0.0)
    with pytest.raises(InputError, match=f"--scheduler {cluster.address}: no scheduler answers"):
        run_jobs(jobs, tmp_path / "results", WorkerSettings(scheduler=cluster.address, patience=0.5))
    with pytest.raises(InputError, match="--scheduler nowhere: not an address"):
        run_jobs(jobs, tmp_path / "results", WorkerSettings(scheduler="nowhere"))
