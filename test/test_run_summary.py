"""What is said of a run, on logs whose answer is known; and the page that shows it."""

import re

import numpy as np
import pytest

from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.log.depth_charts import depth_charts
from slider_drilling.log.run_page import log_panels, run_page, write_run_page, write_run_picture
from slider_drilling.log.run_summary import summarise_run, summary_rows, target_at
from slider_drilling.log.series import JointSeries, ScalarSeries

TIME = 0.1 * np.arange(3001)
NONE = np.full_like(TIME, np.nan)


def joint(position=NONE, velocity=NONE, effort=NONE, time=TIME):
    return JointSeries(time, time, position, velocity, effort)


def log(**series):
    return RigLog(source="run.mcap", start_ns=0, metadata={"version": "1", "notes": "<b>&"}, **series)


def test_tool_face_is_set_after_100_s():
    """90 degrees off for 100 s, then 6 degrees off; the target is 350 degrees, that is -10."""
    tool_face = np.where(TIME < 100.0, np.radians(80.0), np.radians(-4.0)) + 4 * np.pi
    target = JointSeries(*(np.array([value]) for value in (0.0, 0.0, np.radians(350.0), 0.0, 0.0)))
    hold = summarise_run(log(truth_bit=joint(tool_face), tool_face_target=target)).tool_face
    assert hold.source == "truth"
    assert np.degrees(hold.mean_error) == pytest.approx((100 * 90 + 200 * 6) / 300, abs=0.05)
    assert hold.on_target == pytest.approx(2 / 3, abs=1e-3)
    (one,) = hold.targets
    assert one.set_after == pytest.approx(100.0) and one.lost_after is None
    assert np.degrees(one.error_once_set) == pytest.approx(6.0) and one.target == pytest.approx(np.radians(350.0))


def test_passing_the_target_does_not_set_it():
    tool_face = np.radians(60.0) * np.sin(2 * np.pi * TIME / 30.0)
    hold = summarise_run(log(truth_bit=joint(tool_face))).tool_face
    assert hold.targets[0].set_after is None and hold.targets[0].error_once_set is None
    rows = summary_rows(summarise_run(log(truth_bit=joint(tool_face))))
    assert ("toolface set", "never: not within 15 deg for 60 s") in rows
    lead = run_page(log(truth_bit=joint(tool_face)), summarise_run(log(truth_bit=joint(tool_face)))).headline
    assert lead.text == "Toolface never set: not within 15 deg for 60 s (truth)."


def test_mwd_stands_in_for_truth():
    time = np.arange(12.0, 300.0, 12.0)
    hold = summarise_run(log(top_drive=joint(effort=TIME), mwd_tool_face=joint(np.full_like(time, 0.1), time=time,
                     velocity=np.full_like(time, np.nan), effort=np.full_like(time, np.nan)))).tool_face
    assert hold.source == "MWD" and hold.mean_error == pytest.approx(0.1)


def test_figures_of_the_surface():
    summary = summarise_run(log(
        top_drive=joint(20 * np.sin(TIME), effort=np.linspace(-9000.0, 4000.0, 3001)),
        draw_works=joint(0.0025 * TIME, effort=np.full_like(TIME, 4e5)),
        standpipe_pressure=ScalarSeries(TIME, TIME, np.full_like(TIME, 1.9e7), NONE),
        truth_weight_on_bit=ScalarSeries(TIME, TIME, np.linspace(0.0, 6e4, 3001), NONE)))
    assert summary.torque_peak == 9000.0 and summary.torque_range == (-9000.0, 4000.0)
    assert summary.weight_on_bit == pytest.approx((0.0, 3e4, 6e4))
    said = dict(summary_rows(summary))
    assert said["block lowered"] == "0.750 m" and "drilled" not in said
    assert said["standpipe pressure"] == "190.0 bar mean, 190.0 to 190.0 bar"
    assert "toolface error, mean (truth)" not in said


def test_target_holds_before_and_after_change():
    target = JointSeries(*(np.array(value) for value in ([5.0, 20.0], [5.0, 20.0], [0.1, 0.2], [0.0] * 2, [0.0] * 2)))
    held = target_at(log(tool_face_target=target), np.array([0.0, 5.0, 19.9, 20.0, 99.0]))
    np.testing.assert_array_equal(held, [0.1, 0.1, 0.1, 0.2, 0.2])


def test_nothing_to_say():
    with pytest.raises(InputError, match="no surface channel"):
        summarise_run(log())
    with pytest.raises(InputError, match="nothing to plot"):
        log_panels(log())


def test_page_stands_alone_and_picture_is_one(tmp_path):
    record = log(top_drive=joint(20 * np.sin(TIME), effort=1e3 * np.sin(TIME)), truth_bit=joint(TIME, effort=TIME))
    summary = summarise_run(record)
    write_run_page(tmp_path / "run.html", record, summary, (("took", "1 s"),))
    write_run_picture(tmp_path / "run.png", record)
    html = (tmp_path / "run.html").read_text(encoding="utf-8")
    assert re.search(r"<td[^>]*>took</td><td[^>]*>1 s</td>", html)
    assert 'src="http' not in html and "<p>&lt;b&gt;&amp;</p>" in html and len(html) < 1_500_000
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.html", "run.png"]


def test_a_page_that_cannot_be_written(tmp_path):
    record = log(top_drive=joint(TIME, effort=TIME))
    with pytest.raises(InputError, match=r"nowhere/run\.png: cannot write"):
        write_run_picture(tmp_path / "nowhere" / "run.png", record)


def depth(metres, weight=None):
    weighed = {} if weight is None else {"truth_weight_on_bit": ScalarSeries(TIME, TIME, weight, NONE)}
    return {"truth_depth": joint(position=metres), **weighed}


def test_drilled_length_differs_from_lowered_block():
    """The string stretches: the block goes down 1.2 m, the bit makes 0.6 m of hole in the last 200 of 300 s."""
    hole = 4000.0 + np.maximum(TIME - 100.0, 0.0) * 0.003
    summary = summarise_run(log(draw_works=joint(0.004 * TIME, effort=NONE), truth_bit=joint(0 * TIME), **depth(hole)))
    assert summary.drilled.length == pytest.approx(0.6) and summary.drilled.rate == pytest.approx(0.003, rel=1e-3)
    assert summary.drilled.on_bottom == pytest.approx(200.0, rel=1e-3) and not summary.drilled_nothing
    said = dict(summary_rows(summary))
    assert said["drilled"] == "0.600 m, 10.8 m/h while drilling (200 s)"
    assert said["bit depth"] == "4000.00 to 4000.60 m" and said["block lowered"] == "1.20 m"


def test_pulling_off_bottom_makes_no_hole():
    bit = 4000.0 + np.interp(TIME, [0, 100, 150, 200, 300], [0.0, 0.5, -5.0, 0.5, 0.8])
    found = summarise_run(log(truth_bit=joint(0 * TIME), **depth(bit))).drilled
    assert found.length == pytest.approx(0.8) and found.on_bottom == pytest.approx(200.0, abs=0.5)


def test_rounded_bit_depth_gives_the_rate():
    bit = np.floor((1000.0 + 0.002 * TIME) * 100.0) / 100.0
    found = summarise_run(log(truth_bit=joint(0 * TIME), bit_depth=joint(bit))).drilled
    assert found.source == "bit depth" and found.rate == pytest.approx(0.002, rel=0.03)


def test_toolface_without_drilling_is_not_evaluated():
    """A controller that does nothing holds toolface 0 to perfection."""
    depths = depth(np.full_like(TIME, 4000.0))
    summary = summarise_run(log(truth_bit=joint(0 * TIME), draw_works=joint(0 * TIME), **depths))
    assert summary.drilled_nothing
    said = dict(summary_rows(summary))
    assert said["drilled"] == "nothing: the bit made no new hole"
    assert said["toolface"].startswith("not evaluated") and not any("within" in name for name in said)
    shown = run_page(log(truth_bit=joint(0 * TIME), **depth(np.full_like(TIME, 4000.0))), summary)
    assert shown.headline.tone == "bad" and "Nothing was drilled" in shown.headline.text


def test_a_target_set_and_lost_again_says_when():
    """Within 15 deg from 12 s to 112 s, then 120 deg off: the mean of both would contradict "set"."""
    off = np.where((TIME >= 12.0) & (TIME < 112.0), 4.0, 120.0)
    (one,) = summarise_run(log(truth_bit=joint(np.radians(off)))).tool_face.targets
    assert (one.set_after, one.lost_after) == (pytest.approx(12.0), pytest.approx(112.0))
    assert np.degrees(one.error_once_set) == pytest.approx(4.0)
    said = dict(summary_rows(summarise_run(log(truth_bit=joint(np.radians(off))))))
    assert said["toolface set"] == "after 12 s, 4.0 deg mean error until lost after 112 s"


def test_each_target_has_its_own_row():
    target = JointSeries(*(np.array(row) for row in ([0.0, 150.0], [0.0, 150.0], [0.0, 1.0], [0.0] * 2, [0.0] * 2)))
    tool_face = np.where(TIME < 170.0, 0.0, 1.0)
    hold = summarise_run(log(truth_bit=joint(tool_face), tool_face_target=target)).tool_face
    assert [one.set_after for one in hold.targets] == [pytest.approx(0.0), pytest.approx(20.0)]
    assert {"toolface set at 0 deg", "toolface set at 57 deg"} <= set(dict(summary_rows(summarise_run(
        log(truth_bit=joint(tool_face), tool_face_target=target)))))


def test_figures_against_depth():
    hole = 4000.0 + 0.003 * TIME
    drive = joint(TIME, effort=np.full_like(TIME, 5e3))
    record = log(truth_bit=joint(0 * TIME), top_drive=drive, **depth(hole, 6e4 + 0 * TIME))
    charts = {chart.title: chart for chart in depth_charts(record)}
    assert set(charts) == {"Rate of penetration", "Weight on bit", "Surface torque"}
    (mean,) = charts["Rate of penetration"].panels[0].marks
    np.testing.assert_allclose(mean.x, 10.8, rtol=1e-6)
    assert charts["Weight on bit"].panels[0].marks[0].x == pytest.approx(60.0)
    assert charts["Weight on bit"].panels[0].inverted
    assert depth_charts(log(truth_bit=joint(0 * TIME))) == ()


def test_short_hole_gets_no_depth_section():
    for metres, expected in ((0.05, False), (0.9, True)):
        record = log(truth_bit=joint(0 * TIME), **depth(4000.0 + metres * TIME / TIME[-1], 6e4 + 0 * TIME))
        headings = [section.title for section in run_page(record, summarise_run(record)).sections]
        assert ("By depth" in headings) == expected
