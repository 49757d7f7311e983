"""Contact parameters from measured friction: recovery, what cannot be recovered, input that is refused."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.cli import group
from slider_drilling.contact import PAPER
from slider_drilling.contact.identify import identify, predict
from slider_drilling.contact.measured_friction import FrictionOverTime, FrictionOverVelocity, read_measured
from slider_drilling.errors import InputError

LOAD = 55.0
NOISE = 0.02
TRUE_A, TRUE_B, TRUE_KT = 10.45e-6, 15.65e-6, 42_700.0


def vibrated(across=False, seed=1):
    """Sandstone under steel, fed at 3 mm/s and shaken along the feed at 100 Hz: none, 50 um, 100 um; 2 % noise."""
    t = np.arange(0.0, 0.6, 1.0 / 5000.0)
    amplitude = np.select([t < 0.2, t < 0.4], [0.0, 5e-5], 1e-4)
    x = 0.003 * t + amplitude * np.sin(2.0 * math.pi * 100.0 * t)
    y = 2e-4 * np.sin(2.0 * math.pi * 7.0 * t) if across else 0.0 * t
    blank = FrictionOverTime(t, x, y, np.full_like(t, LOAD), 0.0 * t, np.zeros(t.size if across else 0))
    truth = predict(blank, PAPER)
    noisy = truth + NOISE * np.abs(truth).max() * np.random.default_rng(seed).standard_normal(truth.size)
    return replace(blank, friction=noisy[: t.size], tangential_friction=noisy[t.size :]), truth


def test_longitudinal_vibration_gives_stiffness_and_minor_axis():
    data, truth = vibrated()
    found = identify(data, generations=15)
    stiffness, minor = found.estimates["stiffness"], found.estimates["minor_axis"]
    assert stiffness.value == pytest.approx(TRUE_KT, rel=0.01)
    assert minor.value == pytest.approx(TRUE_A, rel=0.01)
    for estimate, true in ((stiffness, TRUE_KT), (minor, TRUE_A)):
        low, high = estimate.interval
        assert low < true < high
        assert high / low < 1.03
    assert np.abs(found.predicted - truth).max() < 0.10 * np.abs(truth).max()
    assert found.largest_error < 0.10
    assert found.residual_rms == pytest.approx(NOISE * np.abs(truth).max(), rel=0.05)


def test_longitudinal_vibration_leaves_major_axis_undetermined():
    found = identify(vibrated()[0], generations=5, particles=8)
    assert found.estimates["major_axis"].interval is None
    assert not found.estimates["major_axis"].determined
    assert any("does not determine h/(chi b) or b" in sentence for sentence in found.degeneracies)
    assert any("a, b, h and chi enter only as" in sentence for sentence in found.degeneracies)


def test_motion_across_gives_major_axis():
    found = identify(vibrated(across=True)[0], generations=15)
    for name, true in (("stiffness", TRUE_KT), ("minor_axis", TRUE_A), ("major_axis", TRUE_B)):
        low, high = found.estimates[name].interval
        assert found.estimates[name].value == pytest.approx(true, rel=0.02)
        assert low < true < high


def test_other_height_gives_same_ratios():
    data, _ = vibrated()
    taller = replace(PAPER, asperity=replace(PAPER.asperity, height=2.0 * PAPER.asperity.height))
    found, held = identify(data, generations=15), identify(data, generations=15, base=taller)
    assert held.estimates["minor_axis"].value == pytest.approx(2.0 * found.estimates["minor_axis"].value, rel=1e-4)
    assert held.residual_rms == pytest.approx(found.residual_rms, rel=1e-6)


def test_shear_factor_and_slope_are_reported_inseparable():
    found = identify(vibrated()[0], free=["shear_factor"], generations=15)
    hardly = [sentence for sentence in found.degeneracies if "separable (correlation" in sentence]
    unknown = [name for name in ("shear_factor", "axial_slope") if not found.estimates[name].determined]
    assert hardly or unknown
    assert found.estimates["stiffness"].value == pytest.approx(TRUE_KT, rel=0.01)


def test_dahl_exponent_is_identified():
    data, _ = vibrated()
    curved = replace(PAPER, dahl_exponent=1.7)
    truth = predict(data, curved)
    noisy = truth + NOISE * truth.max() * np.random.default_rng(3).standard_normal(truth.size)
    found = identify(replace(data, friction=noisy), free=["dahl_exponent"], generations=25)
    assert found.estimates["dahl_exponent"].value == pytest.approx(1.7, rel=0.05)


def velocity_table(seed=2):
    speed = np.tile(np.linspace(0.0, 0.05, 8), 2)
    direction = np.repeat([0.0, 0.3 * math.pi], 8)
    n = speed.size
    blank = FrictionOverVelocity(np.full(n, 0.003), speed, np.full(n, 100.0), direction, np.full(n, LOAD), np.zeros(n))
    truth = predict(blank, PAPER)
    return replace(blank, friction=truth * (1.0 + 0.01 * np.random.default_rng(seed).standard_normal(n)))


def test_friction_over_velocity_gives_parameters():
    found = identify(velocity_table(), generations=6, particles=10)
    assert found.estimates["stiffness"].value == pytest.approx(TRUE_KT, rel=0.05)
    assert found.estimates["minor_axis"].value == pytest.approx(TRUE_A, rel=0.02)
    assert found.largest_error < 0.10


def test_same_seed_gives_same_bits():
    data, _ = vibrated()
    first, second = (identify(data, generations=4, particles=8, seed=5) for _ in range(2))
    assert first.estimates == second.estimates


def test_longitudinal_friction_falls_with_vibration_speed():
    friction = predict(replace(velocity_table(), direction=np.zeros(16)), PAPER)[:8]
    assert friction[0] == pytest.approx(0.33916875 * LOAD, rel=1e-4)
    assert np.all(np.diff(friction) < 0.0)


def write(path, header, rows):
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


HEADER = "time_s,axial_m,normal_force_n,friction_n"


@pytest.mark.parametrize(
    ("header", "rows", "message"),
    [
        (HEADER, ["0,0,55,0", "1,0,55,nan", "2,0,55,"], "line 3, 4: friction_n is missing"),
        (HEADER, ["0,0,55,0", "1,0"], "line 3: normal_force_n is missing"),
        (HEADER, ["0,0,55,0", "0,0,55,0"], "line 3: time_s must increase"),
        (HEADER, ["0,0,55,0", "1,0,-5,0"], "line 3: normal_force_n must be positive"),
        ("time_s,axial_m", ["0,0"], "normal_force_n, friction_n missing"),
        (HEADER + ",colour", ["0,0,55,0,1"], "colour: not a column"),
        ("feed_m_per_s,frequency_hz", ["1,1"], "vibration_m_per_s, normal_force_n, friction_n missing"),
        (HEADER, [], "needs a header line"),
    ],
)
def test_invalid_table_names_its_rows(tmp_path, header, rows, message):
    with pytest.raises(InputError, match=message):
        read_measured(write(tmp_path / "data.csv", header, rows))


def test_too_little_data_or_unknown_parameter_is_refused():
    data, _ = vibrated()
    with pytest.raises(InputError, match="--free height"):
        identify(data, free=["height"])
    short = FrictionOverTime(*(series[:3] for series in (data.time, data.axial, data.tangential, data.normal_force,
                                                    data.friction)), np.zeros(0))  # fmt: skip
    with pytest.raises(InputError, match="3 rows are too few"):
        identify(short)


def test_command_writes_the_identification(tmp_path):
    data, _ = vibrated()
    rows = [f"{t:.6f},{x:.9g},55,{f:.9g}" for t, x, f in zip(data.time, data.axial, data.friction, strict=True)]
    table = write(tmp_path / "data.csv", HEADER, rows)
    out = tmp_path / "out"
    result = CliRunner().invoke(group, ["identify", str(table), "-o", str(out), "--generations", "10"])
    assert result.exit_code == 0, result.output
    found = json.loads((out / "identify.json").read_text())
    assert found["estimates"]["stiffness"]["value"] == pytest.approx(TRUE_KT, rel=0.01)
    assert found["estimates"]["major_axis"]["interval"] is None
    assert found["degeneracies"]
    assert sorted(path.name for path in out.iterdir()) == [f"identify.{s}" for s in ("csv", "html", "json", "png")]
