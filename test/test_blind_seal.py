"""Sealed logs: reproducible, of their target size, with labels that a diagnosis cannot read."""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.blind import check
from slider_drilling.blind.cases import Case, CasePlan, draw_cases
from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS
from slider_drilling.blind.label import read_label, read_labels
from slider_drilling.blind.manoeuvres import MANOEUVRES
from slider_drilling.blind.plant_law import combine, no_effect
from slider_drilling.blind.recorder import RecorderModel, random_recorder_model, write_sealed_log
from slider_drilling.blind.reported_diagnosis import diagnose_job
from slider_drilling.blind.seal import make
from slider_drilling.blind.sealed_plant import PlantPerturbation, random_perturbation, simulate_sealed
from slider_drilling.blind.wells import WELLS
from slider_drilling.campaign.run import WorkerSettings, run_jobs
from slider_drilling.campaign.worker import run_job
from slider_drilling.cli import group
from slider_drilling.diagnosis import build_model as situation
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import read_log
from slider_drilling.rig import load_rig


@pytest.fixture(scope="module")
def base():
    return load_rig(installed_file("config/rig.short.yaml"))


def case(name, size=3.0, **keywords):
    return Case((name,), size, keywords.pop("well", "own"), keywords.pop("manoeuvre", "varied"), 5, 60.0, **keywords)


def run(what, jobs, folder):
    return run_jobs(jobs, folder, WorkerSettings(1))


def test_same_case_gives_same_file_and_label(tmp_path, base):
    one = make(case("torque_sensor_bias"), base, tmp_path / "one.mcap")
    two = make(case("torque_sensor_bias"), base, tmp_path / "two.mcap")
    assert (tmp_path / "one.mcap").read_bytes() == (tmp_path / "two.mcap").read_bytes()
    assert dataclasses.replace(two, log=one.log) == one


@pytest.mark.parametrize(("name", "size"), [("torque_sensor_bias", 4.0), ("motor_wear", 0.5), ("washout", 1.5)])
def test_sealed_effect_reaches_its_target_size(tmp_path, base, name, size):
    label = make(case(name, size), base, tmp_path / "log.mcap")
    assert label.sizes[0] == pytest.approx(size, rel=0.101)
    assert label.size == size


def test_log_does_not_reveal_its_content(tmp_path, base):
    make(case("torque_sensor_bias"), base, tmp_path / "log.mcap")
    log = read_log(tmp_path / "log.mcap")
    assert log.rig() == base  # the file's own rig, none of the nuisance
    content = (tmp_path / "log.mcap").read_bytes()
    assert b"bias: 0" not in content and b"torque_sensor_bias" not in content and b"truth" not in content


def test_perturbation_differs_from_the_rig_file():
    hidden = [random_perturbation(np.random.default_rng(seed)) for seed in range(30)]
    assert len({one.elements for one in hidden}) > 20 and min(one.elements for one in hidden) > 160
    assert all(one.finer_step > 1.1 for one in hidden)
    for name in hidden[0].nuisance:
        assert len({one.nuisance[name] for one in hidden}) == 30
    recorders = [random_recorder_model(np.random.default_rng(seed)) for seed in range(30)]
    assert any(one.slow_noise_share > 0.2 for one in recorders) and any(one.lost_share > 0.0 for one in recorders)
    assert {step for one in recorders for step in one.resolution} == {0.0, 0.25, 0.5, 1.0}


def test_noise_has_declared_size_correlation_and_resolution(tmp_path, base):
    commands = MANOEUVRES["steady"](np.random.default_rng(1), base, 120.0)
    response = simulate_sealed(
        base, PlantPerturbation(elements=40), no_effect(np.random.default_rng(1), base, 1.0), commands
    )
    recorder = RecorderModel(slow_noise_share=0.5, slow_noise_time=1.0, resolution=(0.5, 0.0, 0.0))
    write_sealed_log(tmp_path / "log.mcap", base, commands, response, np.random.default_rng(2), recorder)
    log = read_log(tmp_path / "log.mcap")
    hook = log.draw_works.effort - response.hook_load
    assert np.std(hook) == pytest.approx(base.sensors.hook_load.noise, rel=0.1)
    # Half of the variance forgets over a second: a tenth of one later this much of it is left.
    assert np.corrcoef(hook[1:], hook[:-1])[0, 1] == pytest.approx(0.5 * np.exp(-0.1), abs=0.08)
    step = 0.5 * base.sensors.surface_torque.noise
    assert np.allclose(log.top_drive.effort / step, np.round(log.top_drive.effort / step))
    assert len(log.top_drive.time) == commands.time.size


def test_samples_are_lost_singly_and_in_outages(tmp_path, base):
    commands = MANOEUVRES["rotary"](np.random.default_rng(1), base, 120.0)
    response = simulate_sealed(
        base, PlantPerturbation(elements=40), no_effect(np.random.default_rng(1), base, 1.0), commands
    )
    recorder = RecorderModel(outages=6.0, lost_share=0.02, mwd_lost_share=0.5)
    write_sealed_log(tmp_path / "log.mcap", base, commands, response, np.random.default_rng(2), recorder)
    log = read_log(tmp_path / "log.mcap")
    assert 0.8 * commands.time.size < len(log.top_drive.time) < commands.time.size
    assert np.max(np.diff(log.standpipe_pressure.time)) > 0.35
    assert 0 < len(log.mwd_tool_face.time) < 9


@pytest.mark.parametrize("well", list(WELLS))
@pytest.mark.parametrize("manoeuvre", list(MANOEUVRES))
def test_every_well_and_manoeuvre_drills(base, well, manoeuvre):
    generator = np.random.default_rng(3)
    rig = WELLS[well](generator, base)
    commands = MANOEUVRES[manoeuvre](generator, rig, 60.0)
    assert commands.time[-1] == pytest.approx(59.9)
    assert np.all(np.diff(commands.block_position) >= 0.0)
    assert np.ptp(commands.top_drive_angle) > 5.0
    response = simulate_sealed(rig, PlantPerturbation(elements=30), no_effect(generator, rig, 1.0), commands)
    assert np.isfinite(response.surface_torque).all() and response.weight_on_bit.max() > 0.0


def test_combined_laws_do_what_each_does(base):
    generator = np.random.default_rng(3)
    commands = MANOEUVRES["varied"](generator, base, 60.0)
    hidden = PlantPerturbation(elements=30)
    bias, heave = (
        CATALOGUE_LAWS[name](np.random.default_rng(1), base, 1.0) for name in ("torque_sensor_bias", "heave")
    )
    plain = simulate_sealed(base, hidden, no_effect(generator, base, 1.0), commands)
    together = simulate_sealed(base, hidden, combine(bias, heave), commands)
    alone = simulate_sealed(base, hidden, heave, commands)
    assert np.array_equal(together.hook_load, alone.hook_load)
    assert np.std(alone.hook_load - plain.hook_load) > 1e3
    assert np.allclose(together.surface_torque - alone.surface_torque, 500.0 * (1.0 + commands.time / 4000.0))


def test_twins_repeat_the_run_with_other_noise(tmp_path, base):
    one = case("torque_sensor_bias")
    make(one, base, tmp_path / "alone.mcap")
    make(one, base, tmp_path / "log.mcap", [tmp_path / "first.mcap", tmp_path / "second.mcap"])
    assert (tmp_path / "alone.mcap").read_bytes() == (tmp_path / "log.mcap").read_bytes()
    logs = [read_log(tmp_path / f"{name}.mcap") for name in ("log", "first", "second")]
    for other in logs[1:]:
        assert other.rig() == logs[0].rig()
        shared, mine, its = np.intersect1d(logs[0].top_drive.time, other.top_drive.time, return_indices=True)
        assert shared.size > 0.8 * logs[0].top_drive.time.size
        assert np.array_equal(logs[0].top_drive.position[mine], other.top_drive.position[its])
        apart = logs[0].top_drive.effort[mine] - other.top_drive.effort[its]
        noise = base.sensors.surface_torque.noise
        assert np.std(apart) == pytest.approx(np.sqrt(2.0) * noise, rel=0.3)
    first, second = (log.top_drive.effort[:50] for log in logs[1:])
    assert not np.array_equal(first, second)


@pytest.mark.slow
def test_logs_and_labels_are_made_apart_once(tmp_path, base):
    rig = installed_file("config/rig.short.yaml")
    cases = draw_cases(CasePlan(effects=("none", "torque_sensor_bias"), wells=("own",), duration=60.0), 2)
    assert check.seal(cases, rig, tmp_path, run).exit_code == 0
    logs = sorted(path.name for path in (tmp_path / "logs").rglob("*.mcap"))
    assert logs == sorted(f"{one.file_stem()}.mcap" for one in cases)
    twins = {path.stem for path in (tmp_path / "twins").iterdir()}
    assert twins == {f"{one.file_stem()}_{number}" for one in cases if one.kind == "single" for number in (1, 2, 3)}
    labels = read_labels(tmp_path / "labels")
    assert {labels[one.file_stem()].effects for one in cases} == {
        one.effects if one.kind != "none" else () for one in cases
    }
    assert check.seal(cases, rig, tmp_path, run).already_done == 2
    asked = check.seal(cases, rig, tmp_path, run, repeats=5)
    assert asked.completed == 2
    twins = {path.stem for path in (tmp_path / "twins").iterdir()}
    assert twins == {f"{one.file_stem()}_{number}" for one in cases if one.kind == "single" for number in range(1, 6)}
    assert (tmp_path / "labels").stat().st_mode & 0o077 == 0


@pytest.mark.slow
def test_diagnosis_cannot_open_the_labels(
    tmp_path, base, monkeypatch
):
    monkeypatch.setattr(situation, "MESHES", (16, 24, 30))
    rig = installed_file("config/rig.short.yaml")
    sealed = Case(("torque_sensor_bias",), 4.0, "own", "steady", 2, 40.0)
    check.seal([sealed], rig, tmp_path, run)
    log, labels = tmp_path / "logs" / f"{sealed.file_stem()}.mcap", tmp_path / "labels"
    job = diagnose_job(log, 0, ("torque_sensor_bias",), (str(labels),))
    with_labels = run_job(job).tree
    kept_out = dataclasses.replace(job, call="pathlib:Path", inputs={})
    monkeypatch.setattr(type(job), "function", lambda self: lambda job: {"peeked": (labels / "x").read_text()})
    with pytest.raises(PermissionError, match="sealed for this job"):
        run_job(kept_out)
    monkeypatch.undo()
    monkeypatch.setattr(situation, "MESHES", (16, 24, 30))
    shutil.rmtree(labels)
    without = run_job(job).tree
    for tree in (with_labels, without):
        tree.pop("runtime_s")
    assert json.dumps(with_labels) == json.dumps(without)
    assert with_labels["effects"] == ["torque_sensor_bias"]


def test_command_seals_scores_and_refuses_wrong_options(tmp_path):
    runner = CliRunner()
    sealed = ["blind-check", "--cases", "1", "--effects", "none", "--duration", "60", "-o", str(tmp_path)]
    assert runner.invoke(group, [*sealed, "--seal-only"]).exit_code == 0
    (path,) = (tmp_path / "labels").glob("*.json")
    assert read_label(path).kind == "none"
    answers = tmp_path / "answers"
    answers.mkdir()
    gap = {"closed": None, "closed_interval": None}
    tree = {"schema": "slider_drilling/diagnosis/3", "verdict": "parameters", "site": None, "effects": [], "gap": gap,
            "ranking": []}  # fmt: skip
    (answers / path.name).write_text(json.dumps(tree))
    scored = ["blind-check", "--logs", str(tmp_path), "--answers", str(answers), "-o", str(tmp_path / "scored")]
    result = runner.invoke(group, scored)
    assert result.exit_code == 0 and "correct: none" in result.output
    written = json.loads((tmp_path / "scored" / "blind.json").read_text())
    assert written["totals"]["correct"]["none"]["count"] == 1 and written["cases"][0]["outcome"] == "correct"
    assert "Blind check" in (tmp_path / "scored" / "blind.html").read_text()
    for wrong in (["--sizes", "a"], ["--effects", "stribek"], ["--only", "stribek"], ["--answers", str(answers)]):
        refused = runner.invoke(group, ["blind-check", *wrong, "-o", str(tmp_path / "no")])
        assert type(refused.exception).__name__ == "InputError", wrong


def test_folder_without_sealed_logs_is_refused(tmp_path):
    result = CliRunner().invoke(group, ["blind-check", "--logs", str(tmp_path), "-o", str(tmp_path / "out")])
    assert "holds no sealed logs" in str(result.exception)
    assert Path(tmp_path / "out").is_dir()


@pytest.mark.parametrize(("given", "ignored"), [
    (("--rounds", "1"), ("--only", "heave")), (("--rounds", "1"), ("--no-oracle",)),
    (("--seal-only",), ("--only", "heave")), ((), ("--evidence-only",)), ((), ("--minutes", "5")),
    (("--logs", "."), ("--cases", "3")), (("--logs", ".", "--answers", "."), ("--only", "heave")),
])  # fmt: skip
def test_option_that_a_blind_check_would_ignore_is_refused(tmp_path, monkeypatch, given, ignored):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(group, ["blind-check", *given, *ignored, "-o", "out"])
    assert type(result.exception).__name__ == "InputError" and "has no meaning" in str(result.exception)
    assert str(result.exception).startswith("--") and ignored[0].removeprefix("--no-") in str(result.exception)
    assert not (tmp_path / "out").exists()
