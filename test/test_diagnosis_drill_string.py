"""Diagnosis of drill-string logs: from an MCAP file to diagnosis.json, on short logs and coarse meshes."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from short_well import short_rig

from slider_drilling.blind.catalogue_laws import CATALOGUE_LAWS
from slider_drilling.blind.outside_laws import OUTSIDE_LAWS
from slider_drilling.blind.plant_law import no_effect
from slider_drilling.blind.recorder import write_sealed_log
from slider_drilling.blind.sealed_plant import PlantPerturbation, simulate_sealed
from slider_drilling.diagnosis import build_model as situation
from slider_drilling.diagnosis import drill_string
from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.catalogue import catalogue
from slider_drilling.diagnosis.diagnose import diagnose, tuned_rig
from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.diagnosis.nuisance import ANISOTROPY, nuisance_parameters
from slider_drilling.diagnosis.rig_values import contact_with, depth_probes, rig_with
from slider_drilling.diagnosis.save import write_diagnosis
from slider_drilling.diagnosis.sentences import summary
from slider_drilling.diagnosis.to_json import to_json
from slider_drilling.drillstring import Commands, simulate, simulate_batch
from slider_drilling.drillstring.assemble import friction_curve
from slider_drilling.effects import Effects
from slider_drilling.errors import InputError
from slider_drilling.gap import model as engine_model
from slider_drilling.gap.model import Channel, SimulationOptions
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.log import read_log
from slider_drilling.log_checks.channel_usable import why_unusable
from slider_drilling.rig import FrictionInterval, parse_rig


def rocking(duration, period=8.0, amplitude=5.0, lowering=0.002):
    time = np.arange(0.0, duration, 0.1)
    omega = 2.0 * np.pi / period
    still = np.full_like(time, lowering)
    return Commands(
        time, amplitude * (1.0 - np.cos(omega * time)), amplitude * omega * np.sin(omega * time), lowering * time,
        still, np.full_like(time, 12.3),
    )  # fmt: skip


def write_run(path, rig, commands, actual=None):
    response = simulate(rig if actual is None else actual, commands, 60)
    write_sealed_log(path, replace(rig, effects=Effects()), commands, response, np.random.default_rng(4))
    return path


@pytest.fixture
def coarse(monkeypatch):
    monkeypatch.setattr(situation, "MESHES", (16, 24, 30))


def test_torque_bias_is_named_and_tuned_rig_replays(tmp_path, coarse):
    rig = short_rig()
    actual = rig_with(rig, {"friction_2": 1.05, "pressure_gain": 1.01, "torque_sensor_bias.bias": 700.0})
    path = write_run(tmp_path / "run.mcap", rig, rocking(80.0), actual)
    log = read_log(path)
    diagnosis = diagnose([log], log.rig(), only=["torque_sensor_bias", "torque_sensor_lag"])
    assert diagnosis.effects == ("torque_sensor_bias",)
    assert diagnosis.site == "sensor"
    tree = to_json(diagnosis)
    assert json.loads(json.dumps(tree, allow_nan=False)) == tree
    assert tree["schema"] == "slider_drilling/diagnosis/3"
    assert tree["summary"].startswith("The torque reading is 0.")
    assert tree["ranking"][0]["in_answer"]
    assert tree["gap"]["rms"]["surface_torque"]["tuned"] > tree["gap"]["rms"]["surface_torque"]["with_effect"]
    assert tree["gap"]["nominal"] > tree["gap"]["tuned"] > tree["gap"]["with_effect"]
    assert tree["ranking"][0]["parameters"]["bias"]["value"] == pytest.approx(700.0, abs=60.0)
    floor = tree["gap"]["noise_floor"]["surface_torque"]
    assert floor["declared"] == rig.sensors.surface_torque.noise
    assert floor["value"] == pytest.approx(floor["declared"], rel=0.2)
    assert tuned_rig(diagnosis).effects.torque_sensor_bias.bias == pytest.approx(700.0, abs=60.0)


def test_command_writes_all_three_files(tmp_path, coarse):
    from slider_drilling.commands.diagnose import command

    path = write_run(tmp_path / "run.mcap", short_rig(), rocking(60.0))
    outcome = CliRunner().invoke(command, [str(path), "-o", str(tmp_path / "out"), "--only", "torque_sensor_bias"])
    assert outcome.exit_code == 0, outcome.output
    tree = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert tree["verdict"] in ("none", "parameters")
    parse_rig((tmp_path / "out" / "rig.tuned.yaml").read_text(), "rig.tuned.yaml")
    page = (tmp_path / "out" / "report.html").read_text()
    assert tree["summary"].replace("'", "&#39;") in page
    assert "<script src" not in page
    assert tree["rig"] == {"name": "rig.yaml in run.mcap", "source": "attached", "path": str(path)}
    assert not [p for p in (tmp_path / "out").iterdir() if p.name.startswith(".")]


def test_log_that_never_moved_is_inconclusive(tmp_path, coarse, monkeypatch):
    monkeypatch.setattr("slider_drilling.diagnosis.diagnose.recommend_first_run", lambda *arguments: None)
    path = write_run(tmp_path / "run.mcap", short_rig(), rocking(60.0, amplitude=0.01))
    log = read_log(path)
    diagnosis = diagnose([log], log.rig())
    assert diagnosis.verdict == "inconclusive"
    assert "too little" in str(summary(diagnosis))
    assert diagnosis.gap is None
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "next_programme.yaml").write_text("of an earlier answer")
    paths = write_diagnosis(diagnosis, tmp_path / "out")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(path.name for path in paths)
    tree = json.loads(paths[0].read_text())
    assert tree["verdict"] == "inconclusive"
    assert tree["gap"]["nominal"] is None
    assert "too little" in paths[2].read_text()
    assert tuned_rig(diagnosis) == log.rig()


def test_model_can_be_built_from_torque_alone(tmp_path):
    rig = short_rig()
    log = read_log(write_run(tmp_path / "run.mcap", rig, rocking(40.0)))
    alone = replace(log, draw_works=None, standpipe_pressure=None, mud_pump=None, mwd_tool_face=None)
    prepared = build_model([alone], rig)
    assert [channel.name for channel in prepared.model.runs[0].channels] == ["surface_torque"]
    names = {parameter.name for parameter in prepared.model.nuisance}
    assert {"friction_1", "friction_2", "start_twist"} <= names
    assert not names & {"motor_gain", "pressure_gain", "bit_stiffness", "tool_face_offset"}
    assert any("off bottom" in remark for remark in prepared.remarks)
    assert not {"motor_wear", "heave"} & {effect.name for effect in prepared.model.effects}


@pytest.mark.parametrize("intervals", [(), (FrictionInterval(1000.0, 0.9),)])
def test_torque_alone_calibrates_friction_of_both_halves(intervals):
    whole = replace(short_rig(), well=replace(short_rig().well, friction_intervals=intervals))
    names = {parameter.name for parameter in nuisance_parameters(whole, ["surface_torque"])}
    assert {"friction_1", "friction_2", "torsional_stiffness"} <= names
    assert "friction_2" not in {p.name for p in nuisance_parameters(whole, ["surface_torque", "hook_load"])}
    file = intervals[0].factor if intervals else 1.0
    upper, lower = rig_with(whole, {"friction_1": 0.5, "friction_2": 2.0}).well.friction_intervals
    assert (upper.to, lower.to) == (500.0, 1000.0)
    assert (upper.factor, lower.factor) == pytest.approx((0.5 * file, 2.0 * file))
    alike = rig_with(whole, {"friction_1": 1.0, "friction_2": 1.0})
    torques = [simulate(rig, rocking(20.0), 40).surface_torque for rig in (whole, alike)]
    assert torques[1] == pytest.approx(torques[0], abs=1.0)


def test_stuck_and_saturated_channels_are_left_out():
    time = np.arange(0.0, 50.0, 0.1)
    wave = 1000.0 * np.sin(time)
    assert why_unusable(Channel("surface_torque", time, wave)) is None
    stuck = np.where(time > 10.0, 5.0, wave)
    assert "stuck" in why_unusable(Channel("surface_torque", time, stuck))
    assert "saturated" in why_unusable(Channel("surface_torque", time, np.minimum(wave, 900.0), "N m"))
    rest_first = np.where(time < 5.0, wave.min(), wave)
    assert why_unusable(Channel("surface_torque", time, rest_first, "N m")) is None


def test_every_scan_point_is_a_valid_rig():
    names = {effect.name for effect in catalogue(3000.0, 400.0)}
    assert names == set(CATALOGUE_LAWS)
    rig = short_rig()
    for effect in catalogue(1000.0, 400.0):
        for point in effect.scan:
            changed = rig_with(rig, effect.values(point))
            assert changed.effects != rig.effects
            assert getattr(changed.effects, effect.name) != getattr(Effects(), effect.name)


def test_negative_wave_is_reported_half_a_period_later():
    rig = rig_with(short_rig(), {"heave.amplitude": -0.2, "heave.period": 8.0, "heave.phase": 0.5})
    assert rig.effects.heave.amplitude == pytest.approx(0.2)
    assert np.sin(rig.effects.heave.phase) == pytest.approx(-np.sin(0.5))


def test_neutral_values_leave_the_rig_unchanged():
    rig = short_rig()
    assert rig_with(rig, {"friction_1": 1.0, "torque_sensor_bias.bias": 0.0}) == rig


def test_depth_probe_multiplies_friction_between_its_ends_only():
    rig = rig_with(short_rig(), {"probe_3": 1.5})
    factor = {interval.to: interval.factor for interval in rig.well.friction_intervals}
    assert depth_probes(1000.0)[3][1:] == (300.0, 400.0)
    assert factor[300.0] == pytest.approx(0.8)
    assert factor[400.0] == pytest.approx(1.2)
    assert factor[700.0] == pytest.approx(0.8)
    assert factor[1000.0] == pytest.approx(1.0)


def test_unknown_effect_name_is_an_input_error(tmp_path):
    log = read_log(write_run(tmp_path / "run.mcap", short_rig(), rocking(40.0)))
    with pytest.raises(InputError, match="gremlins"):
        diagnose([log], log.rig(), only=["gremlins"])


def test_corrected_problem_is_exact_and_leaves_its_origin(tmp_path):
    rig = short_rig()
    log = read_log(write_run(tmp_path / "run.mcap", rig, rocking(40.0)))
    model = replace(build_model([log], rig).model, meshes=(12, 40))
    values = {"friction_2": 1.1}
    noise = {channel.name: 1.0 for channel in model.runs[0].channels}
    problem = build_problem(model, [noise])
    before = problem.simulate([values])[0]
    exact = problem.corrected_at(values, 1).simulate([values])[0]
    torque = next(piece for piece in problem.pieces if piece.name == "surface_torque")
    (response,) = simulate_batch([rig_with(rig, values)], model.inputs[0].commands, 40, single_precision=True)
    fine = response.surface_torque
    assert exact[torque.rows] == pytest.approx(fine, abs=1e-6)
    assert np.array_equal(problem.simulate([values])[0], before)
    assert not np.allclose(before[torque.rows], fine, atol=1.0)
    part = model.truncated(0.5).simulate(0, [values], SimulationOptions(1))["surface_torque"][0]
    assert part == pytest.approx(fine[: part.size], abs=1e-4)


def test_programmes_have_the_channels_of_the_log(tmp_path):
    log = read_log(write_run(tmp_path / "run.mcap", short_rig(), rocking(40.0)))
    model = replace(build_model([log], short_rig()).model, meshes=(12, 20))
    programmes = model.programmes(60.0)
    for manoeuvre in (*programmes.fixed.values(), *(programmes.programme(start) for start in programmes.starts)):
        simulated = manoeuvre.model.simulate(0, [{}], SimulationOptions())
        assert set(simulated) == {channel.name for channel in model.runs[0].channels}
        assert all(np.isfinite(rows).all() for rows in simulated.values())


@pytest.mark.parametrize("words", ["friction over depth", "drive angle off over time", "block off over time",
                                   "flow off over time", "bit torque per weight over time", "friction over slip speed",
                                   "friction over rest", "rock over time",
                                   "asperities turned across the pipe",
                                   "friction higher turning right and lower turning left",
                                   "contact compliance before it slides"])  # fmt: skip
def test_free_forms_are_neutral_at_zero_and_change_something(tmp_path, words):
    log = read_log(write_run(tmp_path / "run.mcap", short_rig(), rocking(40.0)))
    model = replace(build_model([log], short_rig()).model, meshes=(12, 20))
    one = next(one for one in model.free_forms({}) if one.description == words)
    assert len(one.parameter_sets) == len(one.steps) == len(one.x)
    plain = model.simulate(0, [{}], SimulationOptions())
    moved = model.simulate(0, one.parameter_sets, SimulationOptions())
    changed = [np.abs(moved[name] - plain[name]).max() for name in plain]
    assert max(changed) > 0.0
    assert np.isfinite(changed).all()


def test_free_form_curve_is_its_laws_curve(tmp_path):
    """Of one coefficient each: friction that falls with speed, that grows with rest, rock that changes at a time."""
    log = read_log(write_run(tmp_path / "run.mcap", short_rig(), rocking(40.0)))
    found = {one.description: one for one in build_model([log], short_rig()).model.free_forms({})}
    x = {words: np.array(one.x)[:, None] for words, one in found.items()}
    curves = {words: np.array(one.basis) for words, one in found.items() if one.basis}
    laws = {
        "friction over slip speed": np.exp(-x["friction over slip speed"] / x["friction over slip speed"].T),
        "friction over rest": 1.0 - np.exp(-x["friction over rest"] / x["friction over rest"].T),
        "rock over time": 1.0 * (x["rock over time"] >= x["rock over time"].T),
    }
    assert set(curves) == set(laws)
    for words, law in laws.items():
        np.testing.assert_allclose(curves[words], law)
        assert np.linalg.cond(law) < 100.0
    assert (found["block off over time"].y_unit, found["drive angle off over time"].y_unit) == ("m", "rad")
    for words, one in found.items():
        assert (one.lower_bound == -1.0) == (one.y_unit == "-" and not one.parameters), words


@pytest.mark.parametrize("orientation", [0.0, 0.6, 1.5, 2.0, -0.3])
def test_disturbed_contact_is_the_files_at_zero(orientation):
    """Asperities turn by what the alternative asks for, never beyond lying along or across; give is relative."""
    file = short_rig().contact
    contact = replace(file, asperity=replace(file.asperity, orientation=orientation))
    assert contact_with(contact, {"friction_1": 1.1}) is contact
    same = contact_with(contact, {"moved.across": 0.0, "moved.give": 0.0})
    assert same.asperity.orientation == pytest.approx(orientation) and same.stiffness == contact.stiffness
    for across in (-1.0, 1.0):
        turned = contact_with(contact, {"moved.across": across}).asperity.orientation
        assert abs(np.sin(turned)) == pytest.approx(1.0 if across > 0.0 else 0.0, abs=1e-9)
        assert abs(turned - orientation) <= 0.5 * np.pi
    assert contact_with(contact, {"moved.give": 1.0}).stiffness == pytest.approx(0.5 * contact.stiffness)


@pytest.mark.parametrize("name", [*CATALOGUE_LAWS, *OUTSIDE_LAWS])
def test_sealed_laws_change_the_channels(name):
    rig = short_rig()
    commands = rocking(24.0)
    generator = np.random.default_rng(2)
    plain = simulate_sealed(rig, PlantPerturbation(), no_effect(generator, rig, 1.0), commands)
    law = {**CATALOGUE_LAWS, **OUTSIDE_LAWS}[name](generator, rig, 2.0)
    changed = simulate_sealed(rig, PlantPerturbation(), law, commands)
    assert np.isfinite(changed.surface_torque).all()
    names = ("surface_torque", "hook_load", "standpipe_pressure")
    moved = max(np.max(np.abs(getattr(changed, channel) - getattr(plain, channel))) for channel in names)
    # A formation that changes after this short run has ended shows nothing in it.
    assert moved > 1.0 or name == "formation_change"


@pytest.mark.parametrize(
    "protocol",
    [
        engine_model.HasCoupledEffects, engine_model.HasFidelities, engine_model.HasFreeForms,
        engine_model.HasObserver, engine_model.HasProgrammes,
        engine_model.HasProbes, engine_model.HasUserParameters, engine_model.CanTruncate,
    ],
)  # fmt: skip
def test_drill_string_satisfies_every_optional_protocol(protocol):
    assert isinstance(DrillString(short_rig(), (), (), (), ()), protocol)


def test_sets_that_differ_in_readings_share_a_simulation(monkeypatch, tmp_path):
    log = read_log(write_run(tmp_path / "run.mcap", short_rig(), rocking(300.0)))
    model = replace(build_model([log], short_rig()).model, meshes=(12, 20))
    simulated = []
    plain = drill_string.simulate_batch

    def counted(rigs, *given, **options):
        simulated.append(len(rigs))
        return plain(rigs, *given, **options)

    monkeypatch.setattr(drill_string, "simulate_batch", counted)
    sets = [{}, {"hook_load_offset": 1e4}, {"hook_load_gain": 1.01}, {"tool_face_offset": 0.3}, {"friction_1": 1.1}]
    channels = model.simulate(0, sets, SimulationOptions(0))
    assert sum(simulated) == 2
    assert np.allclose(channels["hook_load"][1] - channels["hook_load"][0], 1e4)
    assert np.allclose(channels["tool_face"][3] - channels["tool_face"][0], 0.3)


@pytest.mark.parametrize("exponent", [0.0, 2.0])
def test_every_anisotropy_of_the_contact_is_fast(exponent):
    """The table takes five times as long, and a search simulates hundreds of such contacts."""
    contact = contact_with(short_rig().contact, {ANISOTROPY: exponent})
    assert friction_curve(contact).polynomial.size
