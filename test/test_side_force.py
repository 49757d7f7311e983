"""The side force of a whole element, against finer elements and closed forms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slider_drilling.benchmarks.meshes import TURN, static_loads_of, stationed
from slider_drilling.drillstring import Commands, simulate_batch
from slider_drilling.rig import Rig, load_rig
from slider_drilling.wellbore.mesh import build_mesh
from slider_drilling.wellbore.side_force import SideForceGeometry, side_force_geometry
from slider_drilling.wellbore.well_path import WellPath

RIG = load_rig(Path(__file__).parents[1] / "config" / "rig.example.yaml")


def with_survey(survey) -> Rig:
    return replace(RIG, well=replace(RIG.well, survey=tuple(survey)))


@pytest.mark.parametrize("survey", [TURN, stationed(TURN), stationed(RIG.well.survey)],
                         ids=["turn and drop", "with stations", "horizontal with stations"])  # fmt: skip
def test_few_elements_press_like_many(survey):
    rig = with_survey(survey)
    fine = static_loads_of(rig, 2000)
    torque, lowered, raised = static_loads_of(rig, 32) / fine - 1.0
    assert abs(torque) < 1e-3
    assert abs(lowered) < 1e-2
    assert abs(raised) < 1e-3


def test_rotating_torque_converges_on_coarse_mesh():
    rig = with_survey(TURN)
    time = np.arange(0.0, 40.0, 0.1)
    commands = Commands(time, 5.0 * time, 0.0 * time + 5.0, 0.0 * time, 0.0 * time, 0.0 * time)
    coarse, fine = (simulate_batch([rig], commands, count)[0].surface_torque[-100:].mean() for count in (32, 200))
    assert coarse == pytest.approx(fine, rel=2e-3)


def test_constant_curvature_uses_the_middle():
    course = WellPath.from_survey(((0.0, 20.0, 30.0), (1000.0, 50.0, 60.0)))
    edges = np.linspace(0.0, 1000.0, 41)
    middle = SideForceGeometry.between(course, edges)
    whole = side_force_geometry(course, edges, np.ones(40), np.diff(course.interpolate(edges)[1][:, 2]))
    np.testing.assert_allclose(whole.sine, middle.sine, rtol=1e-4)
    np.testing.assert_allclose(whole.vertical_curvature, middle.vertical_curvature, rtol=2e-3)
    np.testing.assert_allclose(np.abs(whole.lateral_curvature), np.abs(middle.lateral_curvature), rtol=2e-3)


def test_pipe_changing_sides_at_station_presses_on_both():
    # 100 m at 60 degrees, then a build that lifts the pipe that hangs on 2000 m more to the high side.
    course = WellPath.from_survey(((0.0, 60.0, 0.0), (50.0, 60.0, 0.0), (100.0, 64.0, 0.0), (4100.0, 64.0, 0.0)))
    edges = np.array([0.0, 100.0, 4100.0])
    falls = np.diff(course.interpolate(edges)[1][:, 2])
    whole = side_force_geometry(course, edges, np.ones(2), falls)
    tension = falls[1] + 0.5 * falls[0]
    curvature = np.radians(4.0) / 50.0
    straight, bent = np.sin(np.radians(60.0)), tension * curvature - np.sin(np.radians(62.0))
    assert bent > 0.0
    assert whole.side_force_per_weight(np.array([tension, 0.0]))[0] == pytest.approx(0.5 * (straight + bent), rel=0.1)
    mean = abs(np.mean([np.sin(np.radians(60.0)), np.sin(np.radians(62.0))]) - 0.5 * tension * curvature)
    assert mean < 0.5 * whole.side_force_per_weight(np.array([tension, 0.0]))[0], (
        "its mean curvature would press on neither"
    )


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(1.0, 600.0), st.floats(0.0, 120.0), st.floats(-360.0, 360.0)), min_size=1, max_size=12
    ),
    st.integers(2, 60),
)
def test_side_force_is_always_finite(legs, elements):
    depth = np.concatenate([[0.0], np.cumsum([leg[0] for leg in legs])])
    rows = [(0.0, 0.0, 0.0), *((float(d), i, a) for d, (_, i, a) in zip(depth[1:], legs, strict=True))]
    rig = with_survey([*rows, (float(depth[-1]) + 6000.0, legs[-1][1], legs[-1][2])])
    mesh = build_mesh(rig, elements)
    for column in (mesh.sine, mesh.vertical_curvature, mesh.lateral_curvature):
        assert np.isfinite(column).all()
    assert (mesh.sine >= 0.0).all()
    assert (mesh.sine <= 1.0 + 1e-12).all()


def test_rig_of_lists_has_same_mesh():
    rows = [list(row) for row in RIG.well.survey]
    rig = replace(
        RIG, well=replace(RIG.well, survey=rows), string=replace(RIG.string, sections=list(RIG.string.sections))
    )
    assert build_mesh(rig, 40) is build_mesh(RIG, 40)


def test_mesh_is_shared_and_read_only():
    again = replace(RIG, mud=replace(RIG.mud, density=RIG.mud.density * 1.1))
    assert build_mesh(RIG, 40) is build_mesh(again, 40)
    with pytest.raises(ValueError, match="read-only"):
        build_mesh(RIG, 40).sine[0] = 0.0
