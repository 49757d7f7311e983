"""What is said of a run, on logs whose answer is known; and the page that shows it."""

import numpy as np
import pytest

from slider_drilling.errors import InputError
from slider_drilling.log.run_page import panels, thin, write_page, write_picture
from slider_drilling.log.run_summary import rows, summarise, target_at
from slider_drilling.log.series import JointSeries, RigLog, ScalarSeries

TIME = 0.1 * np.arange(3001)
NONE = np.full_like(TIME, np.nan)


def joint(position=NONE, velocity=NONE, effort=NONE, time=TIME):
    return JointSeries(time, time, position, velocity, effort)


def log(**series):
    return RigLog(source="run.mcap", start_ns=0, metadata={"version": "1", "notes": "<b>&"}, **series)


def test_a_tool_face_that_is_set_after_100_s():
    """90 degrees off for 100 s, then 6 degrees off; the target is 350 degrees, that is -10."""
    tool_face = np.where(TIME < 100.0, np.radians(80.0), np.radians(-4.0)) + 4 * np.pi
    target = JointSeries(*(np.array([value]) for value in (0.0, 0.0, np.radians(350.0), 0.0, 0.0)))
    hold = summarise(log(truth_bit=joint(tool_face), tool_face_target=target)).tool_face
    assert hold.source == "truth"
    assert np.degrees(hold.mean_error) == pytest.approx((100 * 90 + 200 * 6) / 300, abs=0.05)
    assert hold.on_target == pytest.approx(2 / 3, abs=1e-3)
    assert hold.set_after == pytest.approx(100.0)
    assert np.degrees(hold.error_once_set) == pytest.approx(6.0)


def test_passing_by_is_not_being_set():
    tool_face = np.radians(60.0) * np.sin(2 * np.pi * TIME / 30.0)
    hold = summarise(log(truth_bit=joint(tool_face))).tool_face
    assert hold.set_after is None and hold.error_once_set is None
    assert ("tool-face set", "not within 15 deg for 60 s") in rows(summarise(log(truth_bit=joint(tool_face))))


def test_mwd_stands_in_for_truth():
    time = np.arange(12.0, 300.0, 12.0)
    hold = summarise(log(top_drive=joint(effort=TIME), mwd_tool_face=joint(np.full_like(time, 0.1), time=time,
                     velocity=np.full_like(time, np.nan), effort=np.full_like(time, np.nan)))).tool_face
    assert hold.source == "MWD" and hold.mean_error == pytest.approx(0.1)


def test_figures_of_the_surface():
    summary = summarise(log(
        top_drive=joint(20 * np.sin(TIME), effort=np.linspace(-9000.0, 4000.0, 3001)),
        draw_works=joint(0.0025 * TIME, effort=np.full_like(TIME, 4e5)),
        standpipe_pressure=ScalarSeries(TIME, TIME, np.full_like(TIME, 1.9e7), NONE),
        truth_weight_on_bit=ScalarSeries(TIME, TIME, np.linspace(0.0, 6e4, 3001), NONE)))
    assert summary.torque_peak == 9000.0 and summary.torque_range == (-9000.0, 4000.0)
    assert summary.weight_on_bit == pytest.approx((0.0, 3e4, 6e4))
    said = dict(rows(summary))
    assert said["block lowered"] == "0.75 m, 9.0 m/h"
    assert said["standpipe pressure"] == "190.0 bar mean, 190.0 to 190.0"
    assert "tool-face error, mean (truth)" not in said


def test_target_before_its_first_message_and_after_a_change():
    target = JointSeries(*(np.array(value) for value in ([5.0, 20.0], [5.0, 20.0], [0.1, 0.2], [0.0] * 2, [0.0] * 2)))
    held = target_at(log(tool_face_target=target), np.array([0.0, 5.0, 19.9, 20.0, 99.0]))
    np.testing.assert_array_equal(held, [0.1, 0.1, 0.1, 0.2, 0.2])


def test_nothing_to_say():
    with pytest.raises(InputError, match="no surface channel"):
        summarise(log())
    with pytest.raises(InputError, match="nothing to plot"):
        panels(log())


def test_thinning_keeps_the_extremes():
    value = np.sin(np.arange(100_000) / 3000.0)
    value[54_321], value[12_345] = 9.0, -9.0
    time, thinned = thin(np.arange(100_000.0), value, 1000)
    assert len(time) <= 1000 and (np.diff(time) > 0).all()
    assert thinned[time == 54_321] == 9.0 and thinned[time == 12_345] == -9.0


def test_page_stands_alone_and_picture_is_one(tmp_path):
    record = log(top_drive=joint(20 * np.sin(TIME), effort=1e3 * np.sin(TIME)), truth_bit=joint(TIME, effort=TIME))
    summary = summarise(record)
    write_page(tmp_path / "run.html", record, summary, (("took", "1 s"),))
    write_picture(tmp_path / "run.png", record)
    page = (tmp_path / "run.html").read_text(encoding="utf-8")
    assert "Plotly.newPlot" in page and "<td>took</td><td>1 s</td>" in page
    assert 'src="http' not in page and "notes: &lt;b&gt;&amp;" in page
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.html", "run.png"]


def test_a_page_that_cannot_be_written(tmp_path):
    record = log(top_drive=joint(TIME, effort=TIME))
    with pytest.raises(InputError, match=r"nowhere/run\.png: cannot write"):
        write_picture(tmp_path / "nowhere" / "run.png", record)
