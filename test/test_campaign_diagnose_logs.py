"""Many logs, each diagnosed by itself: folders, names, table, page, and a log that cannot be read."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.blind.manoeuvres import MANOEUVRES
from slider_drilling.blind.recorder import write_sealed_log
from slider_drilling.campaign.diagnose_logs import (
    DiagnoseOptions,
    cells,
    find_logs,
    folder_names,
    log_job,
    log_row,
    logs_page,
    report_files,
    row_of_result,
    write_report_files,
)
from slider_drilling.campaign.results import JobResult, ResultFolder
from slider_drilling.cli import group
from slider_drilling.drillstring import simulate
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.pages import page_html
from slider_drilling.rig import load_rig
from slider_drilling.units import SI


def write_idle(path, seed):
    """Writes a log of a rig that stands still, whose diagnosis takes no time."""
    rig = load_rig(installed_file("config/rig.short.yaml"))
    commands = MANOEUVRES["steady"](np.random.default_rng(seed), rig, 60.0)
    still = np.zeros_like(commands.time)
    commands = replace(commands, top_drive_angle=still, top_drive_speed=still)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_sealed_log(path, rig, commands, simulate(rig, commands, 30), np.random.default_rng(seed))
    return path


def test_folders_are_searched_and_names_are_unique(tmp_path):
    for name in ("a/run.mcap", "b/run.mcap", "b/other.mcap", "b/.run.mcap.part.mcap", "b/notes.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    found = find_logs([tmp_path, tmp_path / "single.mcap"])
    assert [path.name for path in found] == ["run.mcap", "other.mcap", "run.mcap", "single.mcap"]
    assert folder_names(found) == ["run", "other", "b_run", "single"]
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="empty: holds no logs"):
        find_logs([tmp_path / "empty"])


def test_result_depends_on_rig_file_and_user_effect(tmp_path, monkeypatch):
    log, rig = tmp_path / "run.mcap", tmp_path / "rig.yaml"
    log.write_bytes(b"log")
    rig.write_text("rig")
    effect = tmp_path / "my_effect_of_logs.py"
    effect.write_text(
        "from slider_drilling.diagnosis.user_effects import UserEffect\n"
        "from slider_drilling.gap.model import Effect, Parameter\n"
        "class Mine(UserEffect):\n"
        "    size = Parameter('mine.size', 0.0, 0.0, 1.0, 0.1)\n"
        "    effect = Effect('mine', 'contact', (size,), ((0.2,), (0.5,), (0.8,)))\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    reference = "my_effect_of_logs:Mine"
    options = DiagnoseOptions(rig, effects=(reference,))
    key = log_job(log, options).key()
    assert log_job(log, DiagnoseOptions(rig)).key() != key
    effect.write_text(effect.read_text() + "# edited\n")
    edited = log_job(log, options).key()
    rig.write_text("other rig")
    assert len({key, edited, log_job(log, options).key()}) == 3


def test_result_depends_on_every_file_of_a_package(tmp_path, monkeypatch):
    log = tmp_path / "run.mcap"
    log.write_bytes(b"log")
    package = tmp_path / "clay_of_mine"
    (package / "laws").mkdir(parents=True)
    (package / "__init__.py").write_text(
        "from beside_clay import size\n"
        "from slider_drilling.diagnosis.user_effects import UserEffect\n"
        "from slider_drilling.gap.model import Effect, Parameter\n"
        "class Mine(UserEffect):\n"
        "    size = Parameter('mine.size', 0.0, 0.0, size, 0.1)\n"
        "    effect = Effect('mine', 'contact', (size,), ((0.2,), (0.5,), (0.8,)))\n"
    )
    (package / "laws" / "__init__.py").write_text("")
    (package / "laws" / "late.py").write_text("k = 1\n")
    (tmp_path / "beside_clay.py").write_text("size = 1.0\n")
    (tmp_path / "unrelated.py").write_text("a = 1\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    options = DiagnoseOptions(effects=("clay_of_mine:Mine",))
    keys = [log_job(log, options).key()]
    for edited in ("clay_of_mine/__init__.py", "clay_of_mine/laws/late.py", "beside_clay.py"):
        (tmp_path / edited).write_text((tmp_path / edited).read_text() + "# edited\n")
        keys.append(log_job(log, options).key())
    assert len(set(keys)) == 4
    (tmp_path / "unrelated.py").write_text("a = 2\n")
    assert log_job(log, options).key() == keys[-1]


def result(**files):
    return JobResult({"files": {"diagnosis.json": "{}", "rig.tuned.yaml": "", "report.html": "", **files}}, 1.0, 1.0, 1)


@pytest.mark.parametrize("name", ["../x", "/tmp/x", "a/b", "..", "", "more.html", ".bashrc"])
def test_result_with_another_file_name_is_refused(tmp_path, name):
    with pytest.raises(ValueError):
        report_files(result(**{name: "x"}))
    with pytest.raises(ValueError):
        report_files(JobResult({"files": {name: "x"}}, 1.0, 1.0, 1))
    with pytest.raises(ValueError):
        report_files(result(**{"report.html": 5}))


@pytest.mark.parametrize("text", ["{}", "[]", "5", "not json", '{"gap": 1}', "null"])
def test_damaged_diagnosis_in_a_result_is_one_line(tmp_path, text):
    log = tmp_path / "run.mcap"
    log.write_bytes(b"log")
    job = log_job(log, DiagnoseOptions())
    folder = ResultFolder(tmp_path)
    folder.write(job.key(), job, result(**{"diagnosis.json": text}))
    with pytest.raises(InputError, match=rf"{job.key()}\.json: not a result of this job; delete it and run again"):
        folder.parse(job.key(), partial(row_of_result, log, "run"))


def test_planted_folder_link_is_not_followed(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    out = tmp_path / "out"
    out.mkdir()
    (out / "run").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match=r"out/run: is a link to .*elsewhere"):
        write_report_files(report_files(result()), out, "run")
    assert not list((tmp_path / "elsewhere").iterdir())


def test_report_that_cannot_be_replaced_ends_before_the_work(tmp_path):
    for seed, name in enumerate(("monday", "tuesday")):
        write_idle(tmp_path / "logs" / f"{name}.mcap", seed)
    out = tmp_path / "out"
    out.mkdir()
    (out / "monday").write_text("mine")
    with pytest.raises(InputError, match="out/monday"):
        CliRunner().invoke(
            group, ["diagnose", str(tmp_path / "logs"), "-o", str(out)], standalone_mode=False, catch_exceptions=False
        )
    assert sorted(path.name for path in out.iterdir()) == ["monday"]


@pytest.mark.slow
def test_unreadable_log_fails_alone(tmp_path):
    logs = tmp_path / "logs"
    write_idle(logs / "monday.mcap", 1)
    write_idle(logs / "tuesday.mcap", 2)
    (logs / "wednesday.mcap").write_bytes(b"no log at all")
    out = tmp_path / "out"
    arguments = ["diagnose", str(logs), "-o", str(out), "--jobs", "1"]
    result = CliRunner().invoke(group, arguments, standalone_mode=False)
    assert result.return_value == 1, result.output
    tree = json.loads((out / "diagnoses.json").read_text())
    assert [row["verdict"] for row in tree["logs"]] == ["inconclusive", "inconclusive", "failed"]
    assert "wednesday.mcap" in tree["logs"][2]["failure"]
    page = (out / "diagnoses.html").read_text()
    for name in ("monday", "tuesday"):
        assert f'href="{name}/report.html"' in page
        assert (out / name / "report.html").is_file() and (out / name / "rig.tuned.yaml").is_file()
        found = json.loads((out / name / "diagnosis.json").read_text())
        assert found["verdict"] == "inconclusive" and found["next_manoeuvre"]["description"], "a test is asked for"
    assert "wednesday/report.html" not in page
    before = sorted(path.stat().st_mtime_ns for path in (out / "results").glob("*.json"))
    assert CliRunner().invoke(group, arguments, standalone_mode=False).return_value == 1
    assert sorted(path.stat().st_mtime_ns for path in (out / "results").glob("*.json")) == before


@pytest.mark.parametrize("more", [[], ["--together"], ["--baseline"], ["--since"]])
def test_name_that_no_effect_has_ends_before_the_work(tmp_path, monkeypatch, more):
    logs = [str(write_idle(tmp_path / name, seed)) for seed, name in enumerate(("a.mcap", "b.mcap"))]
    after = {"--baseline": [logs[0], "--baseline", logs[1]], "--since": [logs[0], "--since", "auto"]}
    begins = ("diagnosis.diagnose.check_log", "diagnosis.diagnose_change.fit_baseline", "api.what_changed.find_since")
    for work in begins:
        monkeypatch.setattr(f"slider_drilling.{work}", lambda *_: pytest.fail("it had begun"))
    arguments = after.get(more[0] if more else "", [*logs, *more])
    result = CliRunner().invoke(group, ["diagnose", *arguments, "--only", "nonsense", "-o", str(tmp_path / "out")])
    assert isinstance(result.exception, InputError)
    assert "only nonsense: not a" in str(result.exception)
    assert not list(tmp_path.glob("out/*"))


def test_logs_are_fitted_together_on_request_only(tmp_path, monkeypatch):
    monkeypatch.setattr("slider_drilling.diagnosis.diagnose.recommend_first_run", lambda *arguments: None)
    logs = [str(write_idle(tmp_path / f"{name}.mcap", seed)) for seed, name in enumerate(("one", "two"))]
    result = CliRunner().invoke(group, ["diagnose", *logs, "--together", "-o", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    assert len(json.loads((tmp_path / "out" / "diagnosis.json").read_text())["log"]) == 2
    assert not (tmp_path / "out" / "diagnoses.json").exists()


def test_worst_channel_is_largest_in_noise_units(tmp_path):
    floor = {"value": 150.0}
    errors = {"unit": "N m", "nominal": 600.0, "tuned": 300.0, "with_effect": None}
    gap = {"closed": 0.9, "closed_interval": [0.8, 0.95], "noise_floor": {"torque": floor, "hook_load": {"value": 4e3}},
           "rms": {"torque": errors, "hook_load": {**errors, "unit": "N", "nominal": 5e3}}}  # fmt: skip
    entry = {"effect": "heave", "in_answer": True, "group": ["stribeck"]}
    tree = {"verdict": "effect", "effects": ["heave"], "site": "draw_works", "gap": gap, "ranking": [entry]}
    row = log_row(tmp_path / "<b>run</b>.mcap", "run", tree)
    shown = cells(row)
    assert shown[1:] == ("effect", "heave", "stribeck", "draw_works", "0.90 [0.80, 0.95]", "torque",
                         "600 N m, 4.0 times its noise", "")  # fmt: skip
    assert "&lt;b&gt;run" in page_html(logs_page([row]), SI) and "<b>run" not in page_html(logs_page([row]), SI)
