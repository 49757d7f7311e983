"""Campaigns: results are kept, jobs crash alone, interrupts leave finished results."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from slider_drilling.campaign import code_version as code
from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import JobResult, ResultFolder
from slider_drilling.campaign.run import WorkerSettings, run_jobs
from slider_drilling.campaign.worker import job_line, run_job
from slider_drilling.campaign.worker_processes import WorkerProcesses
from slider_drilling.errors import InputError

KINDS = """
import os, signal, time
from pathlib import Path

def square(job):
    number = int(Path(job.inputs["number"]).read_text())
    Path(job.inputs["number"] + ".ran").open("a").write("x")
    time.sleep(job.options.get("sleep", 0.0))
    deed = job.options.get("deeds", {}).get(str(number))
    if deed == "raise":
        raise ValueError("no such\\n number")
    if deed == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    if deed == "spoil":
        folder = Path(job.options["folder"])
        folder.rmdir()
        folder.touch()
    if deed == "stop once" and not Path(job.inputs["number"] + ".stopped").exists():
        Path(job.inputs["number"] + ".stopped").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"square": number**2}

def own_process(job):
    return {"process": os.getpid()}

def peep(job):
    return {"seen": Path(job.options["at"]).read_text()}

def write_beside(job):
    Path(job.outputs[0]).write_text("beside")
    return {}
"""


@pytest.fixture
def jobs(tmp_path, monkeypatch):
    """Returns a function that makes jobs which square the numbers in files."""
    (tmp_path / "squares_of_files.py").write_text(KINDS)
    monkeypatch.syspath_prepend(str(tmp_path))

    def make(count, **options):
        made = []
        for number in range(count):
            path = tmp_path / f"number_{number}"
            path.write_text(str(number))
            made.append(Job("squares_of_files:square", f"of {number}", {"number": str(path)}, options))
        return made

    return make


def squares(folder, keys):
    return [ResultFolder(folder).read(key).tree["square"] for key in keys]


def times_run(job):
    return len(Path(job.inputs["number"] + ".ran").read_text())


def test_jobs_with_results_are_not_run_again(tmp_path, jobs):
    work = jobs(4)
    first = run_jobs(work, tmp_path / "results")
    assert (first.completed, first.already_done, first.exit_code) == (4, 0, 0)
    assert squares(tmp_path / "results", first.keys) == [0, 1, 4, 9]
    again = run_jobs([*work, *jobs(5)], tmp_path / "results")
    assert (again.completed, again.already_done) == (1, 4)
    assert [times_run(job) for job in work] == [1, 1, 1, 1]


def test_key_depends_on_files_options_seed_and_code(tmp_path, jobs, monkeypatch):
    (job,) = jobs(1)
    key = job.key()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.write_text("0")
    assert dataclasses.replace(job, name="other", inputs={"number": str(elsewhere)}).key() == key
    elsewhere.write_text("1")
    assert dataclasses.replace(job, inputs={"number": str(elsewhere)}).key() != key
    assert dataclasses.replace(job, options={"sleep": 1}).key() != key
    assert dataclasses.replace(job, seed=1).key() != key
    assert dataclasses.replace(job, call="squares_of_files:peep").key() != key
    monkeypatch.setattr("slider_drilling.campaign.job.code_version", lambda: "another")
    assert job.key() != key


def test_code_version_ignores_the_commands(tmp_path, monkeypatch):
    package = tmp_path / "package"
    for folder in ("campaign", "commands"):
        (package / folder).mkdir(parents=True)
        (package / folder / "one.py").write_text("a = 1\n")
    monkeypatch.setattr(code, "__file__", str(package / "campaign" / "code.py"))
    version = code.code_version.__wrapped__
    before = version()
    (package / "commands" / "one.py").write_text("a = 2\n")
    assert version() == before
    (package / "campaign" / "one.py").write_text("a = 2\n")
    assert version() != before


def test_job_that_raises_or_dies_fails_alone(tmp_path, jobs):
    said = {}
    work = jobs(6, deeds={"1": "raise", "3": "die"})
    ran = run_jobs(
        work, tmp_path / "results", WorkerSettings(2), on_job_end=lambda job, key, why: said.update({job.name: why})
    )
    assert (ran.completed, len(ran.failed), ran.not_run, ran.exit_code) == (4, 2, 0, 1)
    assert said["of 1"] == "ValueError: no such number"
    assert "SIGKILL" in said["of 3"]
    results = ResultFolder(tmp_path / "results")
    assert results.error(ran.keys[1]) == said["of 1"] and results.error(ran.keys[3]) == said["of 3"]
    assert "line" in (results.folder / f"{ran.keys[1]}.error").read_text()  # the traceback is kept
    assert squares(results.folder, [ran.keys[k] for k in (0, 2, 4, 5)]) == [0, 4, 16, 25]


@pytest.mark.parametrize(("new", "processes"), [(False, 1), (True, 3)])
def test_job_that_measures_memory_has_a_process_of_its_own(tmp_path, jobs, new, processes):
    work = [dataclasses.replace(job, call="squares_of_files:own_process", new_process=new) for job in jobs(3)]
    ran = run_jobs(work, tmp_path / "results", WorkerSettings(1))
    results = [ResultFolder(tmp_path / "results").read(key).tree for key in ran.keys]
    assert len({each["process"] for each in results}) == processes


def test_failed_job_is_run_again(tmp_path, jobs):
    work = jobs(2, deeds={"1": "stop once"})
    first = run_jobs(work, tmp_path / "results")
    assert list(first.failed) == [first.keys[1]]
    second = run_jobs(work, tmp_path / "results")
    assert (second.completed, second.already_done, second.failed) == (1, 1, {})
    assert ResultFolder(tmp_path / "results").error(first.keys[1]) is None
    assert not list((tmp_path / "results").glob("*.error"))


def test_job_is_done_while_its_outputs_exist(tmp_path, jobs):
    jobs(1)
    beside = tmp_path / "beside"
    job = Job("squares_of_files:write_beside", "writes", outputs=(str(beside),))
    run_jobs([job], tmp_path / "results")
    beside.unlink()
    assert run_jobs([job], tmp_path / "results").completed == 1
    assert beside.read_text() == "beside"


@pytest.mark.parametrize("way", ["", "/../closed"])
def test_job_cannot_open_forbidden_folders(tmp_path, jobs, way):
    jobs(1)
    closed = tmp_path / "closed"
    closed.mkdir()
    (closed / "label").write_text("stribeck")
    at = f"{closed}{way}/label"
    open_to_it = Job("squares_of_files:peep", "peeps", options={"at": at})
    assert run_job(open_to_it).tree == {"seen": "stribeck"}
    kept_out = dataclasses.replace(open_to_it, forbidden_folders=(str(closed),))
    ran = run_jobs([kept_out], tmp_path / "results")
    assert "sealed for this job" in ran.failed[ran.keys[0]]
    own = dataclasses.replace(kept_out, inputs={"label": str(closed / "label")})
    assert run_job(own).tree == {"seen": "stribeck"}
    assert (closed / "label").read_text() == "stribeck"  # this process is let in again


def test_unsaved_result_ends_the_campaign_and_is_returned(tmp_path, jobs):
    folder = tmp_path / "results"
    work = jobs(3, deeds={"0": "spoil"}, folder=str(folder))
    ran = run_jobs(work, folder)
    assert ran.result(ran.keys[0]).tree == {"square": 0}
    assert ran.result(ran.keys[1]) is None
    assert (ran.completed, len(ran.unsaved), ran.not_run, ran.exit_code) == (0, 1, 2, 2)
    assert ran.summary().startswith(f"1 completed but not saved, 2 not run; {folder}/{ran.keys[0]}.json: cannot write")
    folder.unlink()
    again = run_jobs(jobs(3, folder=str(folder)), folder)
    assert (again.completed, again.exit_code, squares(folder, again.keys)) == (3, 0, [0, 1, 4])


def test_unsaved_failure_ends_the_campaign(tmp_path, jobs):
    folder = tmp_path / "results"
    folder.mkdir()
    work = jobs(2, deeds={"0": "die"})
    (folder / f"{work[0].key()}.error").mkdir()
    ran = run_jobs(work, folder)
    assert (ran.completed, ran.unsaved, ran.not_run, ran.exit_code) == (0, {}, 2, 2)
    assert "SIGKILL; and " in ran.summary() and "cannot write this file" in ran.summary()


def test_missing_input_or_folder_is_one_line(tmp_path, jobs):
    with pytest.raises(InputError, match="nowhere: cannot read this file"):
        run_jobs([Job("squares_of_files:square", "of nothing", {"number": str(tmp_path / "nowhere")})], tmp_path / "r")
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot make this folder"):
        run_jobs(jobs(1), tmp_path / "file" / "results")


def test_worker_of_other_code_refuses(tmp_path, jobs, monkeypatch):
    (job,) = jobs(1)

    def of_other_code(*arguments):
        return json.dumps({**json.loads(job_line(*arguments)), "code": "0.0.0+other"})

    monkeypatch.setattr("slider_drilling.campaign.worker_processes.job_line", of_other_code)
    processes = WorkerProcesses()
    why = processes.run(job, job.key(), tmp_path)
    processes.stop()
    assert "install the same code" in why


@pytest.mark.parametrize("change", [
    {"result": 1}, {"schema": "slider_drilling/result/0"}, {"job": {}}, {"cpu_s": "1"}, {"wall_s": None},
    {"memory_bytes": -1}, {"cpu_s": float("nan")}, {"result": None},
])  # fmt: skip
def test_file_that_is_no_result_is_refused(tmp_path, jobs, change):
    (job,) = jobs(1)
    results = ResultFolder(tmp_path)
    results.write(job.key(), job, JobResult({"square": 0}, 1.0, 1.0, 1))
    assert results.read(job.key()).tree == {"square": 0}
    path = results.path(job.key())
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(InputError, match=rf"{path.name}: not a result of this job; delete it and run again"):
        results.read(job.key())
    path.write_text("[" * 100_000)
    with pytest.raises(InputError, match="not a result of this job"):
        results.read(job.key())


def test_result_of_another_job_is_refused(tmp_path, jobs):
    first, second = jobs(2)
    results = ResultFolder(tmp_path)
    results.write(first.key(), first, JobResult({"square": 0}, 1.0, 1.0, 1))
    results.path(first.key()).rename(results.path(second.key()))
    with pytest.raises(InputError, match="not a result of this job"):
        results.read(second.key())


def test_input_that_changes_meanwhile_gives_no_result(tmp_path, jobs):
    (job,) = jobs(1)
    key = job.key()
    Path(job.inputs["number"]).write_text("1")
    with pytest.raises(InputError, match="of 0: an input changed while the job ran"):
        ResultFolder(tmp_path).write(key, job, JobResult({}, 1.0, 1.0, 1))


SHADOWS = ("queue", "json", "faulthandler", "signal", "numpy", "threading", "importlib", "click", "joblib")


@pytest.mark.parametrize("program", ["campaign", "python -m"])
def test_modules_of_the_working_directory_hide_nothing(tmp_path, jobs, repository, program):
    jobs(1)
    here = tmp_path / "here"
    here.mkdir()
    for name in SHADOWS:
        (here / f"{name}.py").write_text(f"open({str(tmp_path / 'executed')!r}, 'a').write('{name} ')\n")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(repository), str(tmp_path)])}
    if program == "campaign":
        # As in a program whose script lies elsewhere, into which `--effect` brought the working directory.
        script = tmp_path / "script.py"
        script.write_text("from slider_drilling.user_code import add_working_directory\nadd_working_directory()\n"
                          + SCRIPT.replace("range(8)", "range(1)"))
        command = [sys.executable, str(script), str(tmp_path)]
    else:
        command = [sys.executable, "-m", "slider_drilling", "closed-loop", "--list"]
    answer = subprocess.run(command, cwd=here, env=environment, capture_output=True, text=True, timeout=120)
    assert answer.returncode == 0, answer.stderr
    assert not (tmp_path / "executed").exists(), (tmp_path / "executed").read_text()


def test_key_depends_on_library_versions(monkeypatch):
    before = code.code_version.__wrapped__()
    for name in ("numpy", "scipy", "numba"):
        monkeypatch.setattr(code, "version", lambda library, name=name: "0.0.1" if library == name else "9")
        changed = code.code_version.__wrapped__()
        assert changed != before
        before = changed


SCRIPT = """
import sys
from pathlib import Path
from slider_drilling.process.shutdown import raise_on_signals
from slider_drilling.campaign.job import Job
from slider_drilling.campaign.run import WorkerSettings, run_jobs
raise_on_signals()
folder = Path(sys.argv[1])
workers = WorkerSettings(2, *sys.argv[2:3])
jobs = [Job("squares_of_files:square", f"of {n}", {"number": str(folder / f"number_{n}")}, {"sleep": 0.4})
        for n in range(8)]
ran = run_jobs(jobs, folder / "results", workers, lambda job, key, why: print(job.name, why, flush=True))
print(ran.summary())
sys.exit(ran.exit_code)
"""


def campaign(tmp_path, *arguments):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    return subprocess.Popen([sys.executable, "-c", SCRIPT, str(tmp_path), *arguments], stdout=subprocess.PIPE,
                            text=True, env=environment)  # fmt: skip


def processes_of(tmp_path):
    """Process ids of the workers that run jobs of this folder."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            environment = (entry / "environ").read_bytes()
            if b"campaign.worker" in (entry / "cmdline").read_bytes() and str(tmp_path).encode() in environment:
                found.append(int(entry.name))
        except OSError:
            continue
    return found


def await_none(tmp_path):
    deadline = time.monotonic() + 20.0
    while processes_of(tmp_path):
        assert time.monotonic() < deadline, "worker processes are left behind"
        time.sleep(0.05)


@pytest.mark.parametrize(("number", "exit_code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signal_keeps_finished_results(
    tmp_path, jobs, number, exit_code
):
    jobs(8)
    process = campaign(tmp_path)
    assert process.stdout.readline() and process.stdout.readline()
    process.send_signal(number)
    out, _ = process.communicate(timeout=30)
    assert process.returncode == exit_code
    assert "run the same command to continue" in out
    await_none(tmp_path)
    done = len(list((tmp_path / "results").glob("*.json")))
    assert 2 <= done < 8
    assert not list((tmp_path / "results").glob("*.error"))  # what was cut short has not failed
    process = campaign(tmp_path)
    out, _ = process.communicate(timeout=60)
    assert (process.returncode, out.splitlines()[-1]) == (0, f"{8 - done} completed, {done} done before")


def test_workers_end_with_a_killed_campaign(tmp_path, jobs):
    jobs(8)
    process = campaign(tmp_path)
    assert process.stdout.readline()
    assert processes_of(tmp_path)
    process.kill()
    process.communicate()
    await_none(tmp_path)
