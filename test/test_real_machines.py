"""Public recordings of real machines: fetched whole and checked, read with one clear line for what is wrong."""

from __future__ import annotations

import hashlib
from dataclasses import replace

import numpy as np
import pytest
from scipy.io import savemat

from slider_drilling.benchmarks import real_machines
from slider_drilling.benchmarks.machine_records import FILES, RecordFile, fetch, find_records, records_folder
from slider_drilling.benchmarks.real_machines import MACHINES, diagnose_machine, example_module, machine_results
from slider_drilling.errors import InputError
from slider_drilling.gap import SimulationOptions


@pytest.fixture
def recording(tmp_path):
    """A file that is published at an address on this machine."""
    source = tmp_path / "published.bin"
    source.write_bytes(b"a record")
    return RecordFile("axis", "a.bin", source.as_uri(), hashlib.sha256(b"a record").hexdigest())


def test_missing_recordings_are_fetched_once(recording, tmp_path):
    assert fetch([recording], tmp_path) == [tmp_path / "axis" / "a.bin"]
    assert (tmp_path / "axis" / "a.bin").read_bytes() == b"a record"
    assert fetch([recording], tmp_path) == []


def test_other_content_is_refused(recording, tmp_path):
    with pytest.raises(InputError, match=r"SHA-256 is .* not the published a\.bin"):
        fetch([replace(recording, sha256="0" * 64)], tmp_path)
    assert not (tmp_path / "axis").exists()
    with pytest.raises(InputError, match="cannot be fetched"):
        fetch([replace(recording, address=(tmp_path / "none").as_uri())], tmp_path)


def test_changed_recordings_are_refused(tmp_path):
    for file in FILES:
        path = file.path(tmp_path)
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"something else")
    with pytest.raises(InputError, match="not the published"):
        find_records("emps", tmp_path)


def test_every_machine_has_its_recordings():
    for machine in MACHINES:
        names = {file.name for file in FILES if file.machine == machine.name}
        assert set(machine.fitted) | set(machine.unseen) == names
        assert not set(machine.fitted) & set(machine.unseen)
        example = example_module(machine.name)
        assert callable(getattr(example, machine.reader)) and callable(example.closed)
        assert len(getattr(example, machine.model)(()).effects) >= 8


def test_absent_recordings_give_no_figure(monkeypatch, tmp_path):
    monkeypatch.setenv("SLIDER_DRILLING_MACHINES", str(tmp_path))
    rows = machine_results()
    assert [row.value for row in rows] == [None] * len(MACHINES)
    assert all("machine_records fetches them" in row.note for row in rows)
    monkeypatch.setattr(real_machines, "example_module", lambda name: (_ for _ in ()).throw(FileNotFoundError(name)))
    monkeypatch.setattr(real_machines, "find_records", lambda machine, folder: {})
    assert all("no example" in row.note for row in machine_results())


def axis(tmp_path, **values):
    """A record of the machine axis that its own model made, and the example."""
    emps = example_module("emps")
    time = np.arange(0.0, 6.0, emps.PERIOD)
    made = {"t": time, "qm": 0.1 * np.sin(3.0 * time), "vir": np.zeros_like(time), "gtau": 35.0}
    path = tmp_path / "made.mat"
    savemat(path, made)
    motion = emps.read_record(path).motion
    force = emps._force(motion, emps.NOMINAL | {name.replace("__", "."): value for name, value in values.items()})
    savemat(path, made | {"vir": force / 35.0})
    return emps, emps.read_record(path)


def test_axis_effects_are_neutral_at_nominal_only(tmp_path):
    emps, record = axis(tmp_path)
    model = emps.Axis((record,))
    plain = model.simulate(0, [{}], SimulationOptions())["force"][0]
    assert plain == pytest.approx(record.compared, abs=1e-9)
    assert len(model.effects) == 9
    for effect in model.effects:
        assert {parameter.name for parameter in effect.parameters} <= set(emps.NOMINAL)
        for point in effect.scan:
            moved = model.simulate(0, [effect.values(point)], SimulationOptions())["force"][0]
            assert np.max(np.abs(moved - plain)) > 1e-3, (effect.name, point)
    for parameter in model.nuisance:
        assert emps.NOMINAL[parameter.name] == parameter.nominal


def test_axis_force_matches_closed_form(tmp_path):
    """Forward and backward at one speed the force differs by twice the dry and the viscous friction."""
    emps, record = axis(tmp_path, viscous_asymmetry__share=0.2)
    motion = replace(record.motion, speed=np.sign(record.motion.speed) * 0.1, acceleration=np.zeros(record.force.size))
    force = emps._force(motion, emps.NOMINAL | {"viscous_asymmetry.share": 0.2})
    forward, backward = force[motion.speed > 0.0].mean(), force[motion.speed < 0.0].mean()
    assert forward - backward == pytest.approx(2.0 * 20.3935 + 2.0 * 0.1 * 203.5034)
    assert 0.5 * (forward + backward) == pytest.approx(-3.1648 + 0.2 * 0.1 * 203.5034)
    assert emps.closed([record], {}, {"viscous_asymmetry.share": 0.2}) > 0.99


def test_axis_records_with_mistakes_are_refused(tmp_path):
    emps = example_module("emps")
    path = tmp_path / "a.mat"
    path.write_text("no MATLAB file")
    with pytest.raises(InputError, match="cannot be read as a MATLAB file"):
        emps.read_record(path)
    savemat(path, {"t": np.arange(2000) * 0.002, "qm": np.zeros(2000), "vir": np.zeros(2000), "gtau": 1.0})
    with pytest.raises(InputError, match=r"every 0\.001 s"):
        emps.read_record(path)
    savemat(path, {"t": np.arange(2000) * 0.001, "qm": np.zeros(2000)})
    with pytest.raises(InputError, match="has no variable vir"):
        emps.read_record(path)
    assert emps.main([str(path)]) == 2


def test_joint_tables_with_mistakes_are_refused(tmp_path):
    joint = example_module("robot_joint")
    path = tmp_path / "a.csv"
    path.write_text("time,q7\n0,1\n")
    with pytest.raises(InputError, match="has no column dq7"):
        joint.read_record(path)
    head = "time,q7,dq7,q7_tau_J_compensate\n"
    path.write_text(head + "".join(f"{0.01 * k},0,x,0\n" for k in range(9)))
    with pytest.raises(InputError, match="dq7: could not convert"):
        joint.read_record(path)
    path.write_text(head + "0,0,0,0\n" * 9)
    with pytest.raises(InputError, match="time does not ascend"):
        joint.read_record(path)
    assert joint.main([str(path)]) == 2


@pytest.mark.slow
def test_real_axis_has_asymmetric_viscous_friction():
    found = diagnose_machine(MACHINES[0], records_folder())
    if found is None:
        pytest.skip(f"no recordings in {records_folder()}; python -m slider_drilling.benchmarks.machine_records")
    assert found.answer.effects[0] == "viscous_asymmetry"
    assert found.closed_unseen is not None and found.closed_unseen > 0.6
    assert found.answer.gap_calibrated <= found.answer.gap_nominal
