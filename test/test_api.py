"""`import slider_drilling as sd`: what it offers, that it is light, and that its results go out unchanged."""

from __future__ import annotations

import ast
import csv
import dataclasses
import importlib
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import slider_drilling as sd
from slider_drilling.effects import EFFECTS, Effects
from slider_drilling.units import FIELD

ELEMENTS = 40


@pytest.fixture(scope="module")
def rig() -> sd.Rig:
    return sd.load_rig()


@pytest.fixture(scope="module")
def run(rig: sd.Rig) -> sd.Run:
    return sd.simulate(rig, sd.rocking(rig, 30.0, amplitude=10.0, period=15.0), elements=ELEMENTS, seed=3)


@pytest.fixture(scope="module")
def slide(rig: sd.Rig) -> sd.Run:
    return sd.simulate(rig, "slider_drilling.control:SlideController", 40.0, target=0.5, elements=ELEMENTS)


def test_import_is_light(repository: Path) -> None:
    probe = "import sys, slider_drilling as sd; print(sorted({'numpy', 'numba', 'mcap', 'click'} & set(sys.modules)))"
    answer = subprocess.run([sys.executable, "-c", probe], cwd=repository, capture_output=True, text=True, timeout=60)
    assert (answer.stdout.strip(), answer.stderr) == ("[]", "")


def test_stub_has_every_public_name(repository: Path) -> None:
    stub = ast.parse((repository / "slider_drilling" / "__init__.pyi").read_text())
    stated = {alias.asname: node.module for node in stub.body if isinstance(node, ast.ImportFrom)
              for alias in node.names}  # fmt: skip
    assert set(stated) == set(sd.__all__) - {"__version__"}
    for name, module in stated.items():
        assert getattr(importlib.import_module(module), name) is getattr(sd, name)
        assert getattr(sd, name).__doc__, name
        assert name in dir(sd)


def test_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="simulat"):
        sd.simulat  # noqa: B018


def test_rig_loads_from_path_text_and_tree(rig: sd.Rig, repository: Path) -> None:
    path = repository / "config" / "rig.example.yaml"
    assert sd.load_rig(path) == sd.load_rig(str(path)) == sd.load_rig(path.read_text()) == rig
    import yaml

    assert sd.load_rig(yaml.safe_load(path.read_text())) == rig
    with pytest.raises(sd.InputError, match="no such rig file"):
        sd.load_rig("nowhere.yaml")


def test_with_changes_nested_keys(rig: sd.Rig) -> None:
    changed = rig.with_({"string.sections[1].length": np.float64(70.0), "string.sections[0].length": 3930},
                        mud={"density": 1100}, effects={"stribeck": {"drop": 0.3}})  # fmt: skip
    assert [section.length for section in changed.string.sections] == [3930.0, 70.0]
    assert (changed.mud.density, changed.effects.stribeck.drop) == (1100.0, 0.3)
    assert changed.mud.sound_speed == rig.mud.sound_speed
    assert rig.mud.density == 1200.0
    assert rig.with_() == rig
    assert "stribeck" in repr(changed) and "none" in repr(rig)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"mud.density": -5}, r"rig: mud\.density = -5: must be at least"),
        ({"string": {"density": -5}}, r"rig: string\.density = -5: must be "),
        ({"mud.densty": 3}, "did you mean density"),
        ({"mudd.density": 3}, "did you mean mud"),
        ({"string.sections[7].length": 1}, "the list has 2 entries"),
        ({"mud.density": "heavy"}, r"mud\.density = 'heavy'"),
        ({"mud.density.x": 1}, "needs keys and values"),
        ({"mud..density": 1}, "not a key"),
        ({"well.hole_diameter": 0.1}, "does not fit the hole"),
    ],
)
def test_invalid_changes_are_refused(rig: sd.Rig, changes: dict[str, object], said: str) -> None:
    with pytest.raises(sd.InputError, match=said):
        rig.with_(changes)


@pytest.mark.parametrize(("call", "said"), [
    (lambda rig: sd.simulate("rig.yaml", "a:b", 1.0), "simulate: rig: str is no rig; make one of it with load_rig"),
    (lambda rig: sd.simulate(rig, "a:b", 1.0, nominal={}), "simulate: nominal: rig: dict is no rig"),
    (lambda rig: sd.rocking("rig.yaml", 1.0, amplitude=1.0, period=8.0), "rocking: rig: str is no rig"),
    (lambda rig: sd.rocking(rig, 1.0, amplitude="a", period=8.0), "rocking: amplitude = 'a': expected a number"),
    (lambda rig: sd.rocking(rig, 1.0, amplitude=1.0, period=None), "rocking: period = None: expected a number"),
    (lambda rig: sd.rocking(rig, 1.0, amplitude=1.0, period=8.0, interval=0), "interval = 0 s: must be above 0"),
    (lambda rig: sd.with_effect(3, "stribeck"), "with_effect: rig: int is no rig"),
    (lambda rig: sd.with_effect(rig, ["stribeck"]), "effect: list is no effect; write NAME, or NAME:KEY=VALUE"),
    (lambda rig: sd.batch("rig.yaml", "a:b", 1.0), "batch: rig: str is no rig"),
    (lambda rig: sd.batch(3, "a:b", 1.0), "batch: rig: int is no rig"),
    (lambda rig: sd.batch(rig, "a:b", 1.0, vary=3), "batch: vary: int; give a dict of keys"),
    (lambda rig: sd.batch(rig, "a:b", 1.0, vary={"mud.density": 3}), "batch: vary: mud.density: 3; give a list of "),
])  # fmt: skip
def test_arguments_of_another_kind_are_refused(rig: sd.Rig, call: Any, said: str) -> None:
    with pytest.raises(sd.InputError) as refused:
        call(rig)
    assert said in str(refused.value)


@pytest.mark.parametrize("given", [None, 3, b"x", "a\0b", [1, 2], {}])
@pytest.mark.parametrize("call", [
    sd.read_log, sd.import_log, sd.activities, sd.analyse, sd.replay, sd.watch, sd.diagnose, sd.load_programme,
    lambda given: sd.new_rig(given, given),
], ids=["read_log", "import_log", "activities", "analyse", "replay", "watch", "diagnose", "load_programme", "new_rig"])
def test_what_is_no_path_is_refused(call: Any, given: Any) -> None:
    with pytest.raises(sd.InputError, match=r"^[^\n]+$"):
        call(given)


@pytest.mark.parametrize("call", [
    sd.torque_drag, sd.rocking_plan, sd.closed_loop, lambda given: sd.load_rig().with_(given),
    lambda given: sd.load_rig(given),
], ids=["torque_drag", "rocking_plan", "closed_loop", "with_", "load_rig"])
def test_a_number_is_no_rig_controller_or_change(call: Any) -> None:
    with pytest.raises(sd.InputError, match=r"^[^\n]+$"):
        call(3)


def test_whole_numbers_of_numpy_are_whole_numbers(rig: sd.Rig) -> None:
    commands = sd.rocking(rig, 2.0, amplitude=np.float32(3.0), period=np.int64(8))
    first, second = (
        sd.simulate(rig, commands, seed=kind(3), elements=kind(ELEMENTS)).log for kind in (int, np.int64)
    )
    assert first.draw_works is not None and second.draw_works is not None
    np.testing.assert_array_equal(first.draw_works.effort, second.draw_works.effort)


def test_commands_give_run_and_log(run: sd.Run) -> None:
    frame = run.to_frame()
    assert frame.attrs["units"]["surface_torque"] == "N m"
    np.testing.assert_array_equal(frame["surface_torque"], run.response.surface_torque)
    noise = (frame["measured_surface_torque"] - frame["surface_torque"]).std()
    assert noise == pytest.approx(run.rig.sensors.surface_torque.noise, rel=0.2)
    assert "surface torque" in repr(run) and len(repr(run)) < 200
    assert len(run.plot().data) > 5


def test_run_equals_plant_response(rig: sd.Rig, run: sd.Run) -> None:
    from slider_drilling.drillstring import simulate

    np.testing.assert_array_equal(run.response.tool_face, simulate(rig, run.commands, ELEMENTS).tool_face)
    assert run.commands.top_drive_angle.max() == pytest.approx(10.0 - 0.5 * 40.0 / 15.0 * 0.5, abs=0.15)


def test_seed_changes_sensors_only(rig: sd.Rig, run: sd.Run) -> None:
    again, other = (sd.simulate(rig, run.commands, elements=ELEMENTS, seed=seed) for seed in (3, 4))
    np.testing.assert_array_equal(again.log.top_drive.effort, run.log.top_drive.effort)
    assert not np.array_equal(other.log.top_drive.effort, run.log.top_drive.effort)
    np.testing.assert_array_equal(other.response.surface_torque, run.response.surface_torque)


def test_saved_log_equals_log(slide: sd.Run, tmp_path: Path) -> None:
    path = slide.save(tmp_path / "slide.mcap")
    log = sd.read_log(path)
    assert log.rig() == slide.rig
    np.testing.assert_allclose(log.top_drive.effort, slide.log.top_drive.effort)
    np.testing.assert_allclose(log.mwd_tool_face.time, slide.log.mwd_tool_face.time, atol=1e-9)
    np.testing.assert_allclose(log.mwd_tool_face.arrival, slide.log.mwd_tool_face.arrival, atol=1e-9)
    assert log.tool_face_target.position.tolist() == [0.5]
    assert list(log.to_frame().columns) == [
        "top_drive_angle", "top_drive_speed", "surface_torque", "block_position", "block_speed", "hook_load",
        "standpipe_pressure", "pump_speed", "mwd_tool_face", "tool_face_target", "tool_face", "tool_face_rate",
        "bit_torque", "weight_on_bit", "bit_depth", "rate_of_penetration"]  # fmt: skip
    assert "top_drive" in repr(log) and len(repr(log)) < 300


def test_csv_and_parquet_equal_frame(slide: sd.Run, tmp_path: Path) -> None:
    import pandas

    frame = slide.to_frame()
    with open(slide.to_csv(tmp_path / "slide.csv"), newline="") as file:
        heads, *rows = list(csv.reader(file))
    assert heads[:2] == ["time [s]", "top_drive_angle [rad]"]
    assert len(rows) == len(frame)
    column = heads.index("hook_load [N]")
    np.testing.assert_allclose([float(row[column]) for row in rows], frame["hook_load"], rtol=1e-9)
    pytest.importorskip("pyarrow")
    pandas.testing.assert_frame_equal(pandas.read_parquet(slide.to_parquet(tmp_path / "slide.parquet")), frame)


def test_missing_pandas_is_reported_in_one_line(slide: sd.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(sd.InputError, match=r"slider_drilling\[frames\]"):
        slide.to_frame()


def test_batch_runs_every_combination(rig: sd.Rig, run: sd.Run) -> None:
    batch = sd.batch(rig, run.commands, elements=ELEMENTS,
                     vary={"well.friction_intervals[1].factor": [0.8, 1.2], "bit.aggressiveness": [0.4, 0.6]})
    assert len(batch) == 4
    assert batch.labels[1] == {"well.friction_intervals[1].factor": 0.8, "bit.aggressiveness": 0.6}
    assert batch[1].rig.bit.aggressiveness == 0.6
    peaks = [np.abs(one.response.surface_torque).max() for one in batch]
    assert min(peaks[2:]) > max(peaks[:2])
    assert set(batch.to_frame().reset_index()["run"]) == {0, 1, 2, 3}
    assert len(batch.plot("hook_load").data) == 4
    with pytest.raises(sd.InputError, match="channel = 'torque'"):
        batch.plot("torque")


def test_batch_of_different_wells_equals_single_runs(rig: sd.Rig, run: sd.Run) -> None:
    short = sd.load_rig("short")
    batch = sd.batch([rig, short, rig], run.commands, elements=ELEMENTS)
    alone = sd.simulate(short, run.commands, elements=ELEMENTS)
    np.testing.assert_allclose(batch[1].response.surface_torque, alone.response.surface_torque)
    np.testing.assert_array_equal(batch[0].response.tool_face, batch[2].response.tool_face)


def test_batch_builds_controller_per_run(rig: sd.Rig) -> None:
    from slider_drilling.control import FixedRocking

    batch = sd.batch([rig, rig], FixedRocking, 5.0, elements=ELEMENTS)
    np.testing.assert_array_equal(batch[0].response.surface_torque, batch[1].response.surface_torque)
    with pytest.raises(sd.InputError, match="class"):
        sd.batch([rig, rig], FixedRocking(rig), 5.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(("drive", "duration", "said"), [
    ("nowhere:Mine", 5.0, "cannot be imported"),
    ("slider_drilling.control:SlideController", None, "duration is missing"),
    (object(), 5.0, "drives nothing"),
])  # fmt: skip
def test_invalid_drive_is_refused(rig: sd.Rig, drive: object, duration: float | None, said: str) -> None:
    with pytest.raises(sd.InputError, match=said):
        sd.simulate(rig, drive, duration)  # type: ignore[arg-type]


def test_replay_of_own_run_leaves_noise(run: sd.Run) -> None:
    replayed = sd.replay(run, elements=ELEMENTS)
    assert 0.8 < replayed.rms_over_noise["surface_torque"] < 1.2
    frame = replayed.to_frame()
    residual = frame["measured_hook_load"] - frame["simulated_hook_load"]
    assert np.sqrt(np.mean(residual**2)) == pytest.approx(replayed.rms["hook_load"])
    assert len(replayed.plot().data) == 2


def test_replay_shows_missing_effect(rig: sd.Rig, run: sd.Run) -> None:
    planted = sd.simulate(sd.with_effect(rig, "torque_sensor_bias"), run.commands, elements=ELEMENTS, nominal=rig)
    assert planted.log.rig() == rig
    assert sd.replay(planted, elements=ELEMENTS).rms["surface_torque"] == pytest.approx(np.hypot(500, 150), rel=0.05)


@pytest.mark.parametrize("name", EFFECTS)
def test_every_usual_size_changes_response(rig: sd.Rig, name: str) -> None:
    assert getattr(sd.with_effect(rig, name).effects, name) != getattr(Effects(), name)


@pytest.mark.parametrize(("effect", "said"), [
    ("stribek", "no such effect; one of stribeck"),
    ("stribeck=0.4", "'stribeck=0.4': give its values by their keys, as in stribeck:KEY=VALUE"),
    ("stribeck:drop", "not KEY=VALUE"),
    ("stribeck:drop=much", "expected a number"),
    ("stribeck:dropp=0.3", "did you mean drop"),
    ("stribeck:drop=-2", "must be above -1"),
])  # fmt: skip
def test_invalid_effects_are_refused(rig: sd.Rig, effect: str, said: str) -> None:
    with pytest.raises(sd.InputError, match=said):
        sd.with_effect(rig, effect)


def test_study_gives_claims_and_files(tmp_path: Path) -> None:
    studied = sd.study("wear_modes")
    assert "claims hold" in repr(studied)
    assert set(studied.to_frame().reset_index()["figure"]) <= {chart.title for chart in studied.study.figures}
    assert studied.plot().data
    with pytest.raises(sd.InputError, match="no such study"):
        sd.study("nothing")


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"duration": float("nan")}, r"simulate: duration = nan s: must be finite"),
        ({"duration": float("inf")}, r"simulate: duration = inf s: must be finite"),
        ({"duration": 1e9}, r"simulate: duration = 1e\+09 s: makes 1e\+10 samples at 10 Hz"),
        ({"duration": 1e-3}, r"simulate: duration = 0.001 s: makes 0.01 samples"),
        ({"duration": None}, r"simulate: duration is missing"),
        ({"target": float("nan")}, r"simulate: target = nan: must be a finite number of rad"),
        ({"start": sd.InitialState(twist=float("inf"))}, r"simulate: start\.twist = inf: must be a finite"),
        ({"seed": -1}, r"simulate: seed = -1: must be a whole number"),
        ({"elements": 3}, r"simulate: elements = 3: must be within 10 to 5000"),
        ({"rig": sd.load_rig().with_({"effects.friction_drift.rate": -0.01}), "duration": 120.0},
         r"effects\.friction_drift\.rate = -0\.01: leaves no friction after 100 s, and the run takes 120 s"),
    ],
)  # fmt: skip
def test_invalid_run_arguments_are_refused(rig: sd.Rig, changed: dict[str, object], said: str) -> None:
    asked = {"rig": rig, "duration": 10.0, "elements": ELEMENTS, **changed}
    with pytest.raises(sd.InputError, match=said):
        sd.simulate(asked.pop("rig"), "slider_drilling.control:SlideController", **asked)


@pytest.mark.parametrize("kind", [sd.PlanTestOptions, sd.PlanOptions, sd.TwinSettings])
def test_an_option_of_another_kind_is_refused(kind: Any) -> None:
    for name in kind.__dataclass_fields__:
        with pytest.raises(sd.InputError, match=rf"^\w+: {name} = 'a': expected [^\n]*$"):
            kind(**{name: "a"})


@pytest.mark.parametrize(("call", "argument", "value"), [
    (lambda run, **given: sd.diagnose(run, **given), "until", "a"),
    (lambda run, **given: sd.diagnose(run, **given), "seed", 0.5),
    (lambda run, **given: sd.diagnose(run, **given), "since", "b"),
    (lambda run, **given: sd.analyse(run, **given), "elements", "a"),
    (lambda run, **given: sd.replay(run, **given), "elements", [1]),
    (lambda run, **given: sd.watch(run, **given), "settings", "a"),
    (lambda run, **given: sd.torque_drag(run.rig, **given), "frictions", ["a"]),
    (lambda run, **given: sd.rocking_plan(run.rig, **given), "depths", "a"),
    (lambda run, **given: sd.rocking_plan(run.rig, **given), "options", "a"),
    (lambda run, **given: sd.plan_test(run.rig, **given), "options", {"minutes": 5.0}),
    (lambda run, **given: sd.closed_loop(**given), "workers", "a"),
    (lambda run, **given: sd.closed_loop(**given), "settings", "a"),
])  # fmt: skip
def test_an_argument_of_another_kind_is_refused(run: sd.Run, call: Any, argument: str, value: object) -> None:
    with pytest.raises(sd.InputError, match=rf"^\w+: {argument} = [^\n]*$"):
        call(run, **{argument: value})


def test_commands_longer_than_friction_drift_are_refused(rig: sd.Rig) -> None:
    drifting = rig.with_({"effects.friction_drift.rate": -0.01})
    commands = sd.rocking(rig, 120.0, amplitude=10.0, period=15.0)
    for ran in (sd.simulate, sd.batch):
        with pytest.raises(sd.InputError, match="leaves no friction after 100 s"):
            ran(drifting, commands, elements=ELEMENTS)
    still = sd.Commands(*np.zeros((6, 1)))
    with pytest.raises(sd.InputError, match=r"simulate: commands: 1 sample"):
        sd.simulate(rig, still, elements=ELEMENTS)
    with pytest.raises(sd.InputError, match="rocking: centre = nan"):
        sd.rocking(rig, 10.0, amplitude=1.0, period=5.0, centre=float("nan"))


def test_tables_follow_units(slide: sd.Run, tmp_path: Path) -> None:
    si, field, degrees = slide.to_frame(), slide.to_frame(FIELD), slide.to_frame(degrees=True)
    assert field.attrs["units"]["surface_torque"] == "ft lbf" and field.attrs["units"]["mwd_tool_face"] == "deg"
    assert field["surface_torque"].max() == pytest.approx(si["surface_torque"].max() / 1.3558179483314004)
    assert degrees["top_drive_angle"].max() == pytest.approx(np.degrees(si["top_drive_angle"].max()))
    assert degrees["surface_torque"].max() == si["surface_torque"].max()
    with slide.to_csv(tmp_path / "run.csv", FIELD).open() as lines:
        assert "hook_load [lbf]" in next(csv.reader(lines))


def test_saved_pages_are_small(slide: sd.Run, tmp_path: Path) -> None:
    for path in (slide.save_page(tmp_path / "run.html", FIELD),
                 sd.replay(slide, elements=ELEMENTS).save_page(tmp_path / "replay.html", FIELD)):  # fmt: skip
        assert path.stat().st_size < 1_000_000
        assert "ft lbf" in path.read_text()


def test_target_may_be_in_degrees(rig: sd.Rig) -> None:
    run = sd.simulate(rig, "slider_drilling.control:SlideController", 1.0, target="45 deg", elements=ELEMENTS)
    assert run.log.tool_face_target.position[0] == pytest.approx(np.pi / 4.0)
    with pytest.raises(sd.InputError, match="simulate: target: unit = 'ft'"):
        sd.simulate(rig, "slider_drilling.control:SlideController", 1.0, target="45 ft", elements=ELEMENTS)


def test_table_becomes_log(tmp_path: Path) -> None:
    rows = "".join(f"{k},{k % 7}.0,{10 - 0.01 * k},{200 + k % 3}\n" for k in range(60))
    (tmp_path / "edr.csv").write_text(f"Time (s),RPM (rpm),BPOS (ft),HKLD (klbf)\n{rows}")
    log = sd.import_log(tmp_path / "edr.csv")
    assert log.draw_works.effort[0] == pytest.approx(200e3 * 4.4482216152605)


def test_closed_loop_scores_scenarios(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from slider_drilling.slide_scenarios import SCENARIOS

    short = dataclasses.replace(next(each for each in SCENARIOS if each.name == "hold, 2.6 km"), duration=30.0)
    monkeypatch.setattr("slider_drilling.api.closed_loop.SCENARIOS", (short,))
    result = sd.closed_loop(only="hold, 2.6 km", elements=20, workers=1)
    frame = result.to_frame()
    assert len(result.rows) == 1 and "mean_abs_error_deg" in frame.columns and len(frame) >= 3
    assert result.tree["scenarios"][0]["name"] == "hold, 2.6 km"
    assert result.save_page(tmp_path / "loop.html").stat().st_size < 1_000_000
    with pytest.raises(sd.InputError, match="no scenario starts with this"):
        sd.closed_loop(only="nothing")
