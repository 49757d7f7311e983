"""Sections with their own weight, tool joints and stiffness."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from slider_drilling.api.rigs import load_rig
from slider_drilling.drillstring import Commands, Plant
from slider_drilling.drillstring.assemble import springs
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig, check_rig
from slider_drilling.wellbore.mesh import build_mesh, buoyed_weight, torsional_impedance
from slider_drilling.wellbore.static_loads import static_loads


def with_section(index: int = 0, **keys: Any) -> Rig:
    rig = load_rig()
    sections = list(rig.string.sections)
    sections[index] = dataclasses.replace(sections[index], **keys)
    return check_rig(dataclasses.replace(rig, string=dataclasses.replace(rig.string, sections=tuple(sections))))


def plain_weight(rig: Rig, index: int = 0) -> float:
    """Weight in air of a section by its diameters, N/m."""
    section = rig.string.sections[index]
    return 9.81 * rig.string.density * math.pi / 4.0 * (section.outer_diameter**2 - section.inner_diameter**2)


def test_weight_of_plain_pipe_changes_nothing() -> None:
    rig = load_rig()
    given = with_section(weight_per_length=plain_weight(rig))
    for axial, turn in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0)):
        ours, plain = static_loads(given, axial, turn), static_loads(rig, axial, turn)
        np.testing.assert_allclose(ours.tension, plain.tension, rtol=1e-9, atol=1e-3)
        np.testing.assert_allclose(ours.torque, plain.torque, rtol=1e-9, atol=1e-6)
    assert given.string.twist_speed == pytest.approx(rig.string.twist_speed, rel=1e-12)


def test_given_weight_hangs_on_the_hook() -> None:
    rig = with_section(weight_per_length=320.0)
    mesh = build_mesh(rig, 200)
    own = mesh.bottom <= 3940.0 + 1e-6
    buoyancy = 1.0 - rig.mud.density / rig.string.density
    assert buoyed_weight(rig, mesh)[own].sum() == pytest.approx(320.0 * buoyancy * 3940.0, rel=1e-12)
    assert springs(rig, mesh).mass[own].sum() == pytest.approx(320.0 * 3940.0 / 9.81, rel=1e-12)


def test_weight_factor_scales_weight_and_inertia() -> None:
    rig = load_rig()
    heavier = rig.with_({"string.weight_factor": 1.1})
    mesh = build_mesh(rig, 50)
    np.testing.assert_allclose(buoyed_weight(heavier, mesh), 1.1 * buoyed_weight(rig, mesh))
    np.testing.assert_allclose(springs(heavier, mesh).inertia, 1.1 * springs(rig, mesh).inertia)


def test_tool_joints_are_the_lever_of_friction() -> None:
    rig = load_rig()
    wider = with_section(tool_joint_outer_diameter=0.168)
    plain, ours = static_loads(rig, 0.0, 1.0), static_loads(wider, 0.0, 1.0)
    assert ours.hook_load == plain.hook_load
    foot = plain.torque[np.searchsorted(plain.measured_depth, 3940.0)]
    assert (ours.surface_torque - foot) / (plain.surface_torque - foot) == pytest.approx(0.168 / 0.127, rel=1e-3)


def test_contact_radius_factor_scales_friction_torque() -> None:
    rig = load_rig()
    wider = rig.with_({"string.contact_radius_factor": 1.2})
    plain, ours = static_loads(rig, 0.0, 1.0), static_loads(wider, 0.0, 1.0)
    assert ours.hook_load == plain.hook_load
    assert ours.surface_torque == pytest.approx(1.2 * plain.surface_torque)
    time, still = np.arange(0.0, 60.0, 0.1), np.zeros(600)
    turning = Commands(time, 3.0 * time, still + 3.0, still - 5.0, still, still)
    torque = [Plant(one, 60, 0.1).advance(turning).surface_torque[-1] for one in (rig, wider)]
    # The mud's damping has its own lever.
    assert torque[1] == pytest.approx(1.2 * torque[0], rel=5e-3)


def test_tool_joints_and_body_are_in_series() -> None:
    share = 0.055
    rig = load_rig()
    jointed = with_section(
        tool_joint_outer_diameter=0.168, tool_joint_inner_diameter=0.083, tool_joint_fraction=share
    )
    body, joint = 0.127**4 - 0.1086**4, 0.168**4 - 0.083**4
    mesh, plain = build_mesh(jointed, 50), build_mesh(rig, 50)
    assert plain.polar_moment[0] / mesh.polar_moment[0] == pytest.approx((1 - share) + share * body / joint)
    mass = springs(jointed, mesh).inertia[0] / springs(rig, plain).inertia[0]
    assert mass == pytest.approx((1 - share) + share * joint / body)
    slower = math.sqrt(mass * plain.polar_moment[0] / mesh.polar_moment[0])
    expected = 1.0 / (1.0 + (slower - 1.0) * 3940.0 / 4000.0)
    assert jointed.string.twist_speed / rig.string.twist_speed == pytest.approx(expected, rel=1e-9)
    assert torsional_impedance(jointed, mesh) > torsional_impedance(rig, plain)


def test_stiffness_factor_softens_a_section() -> None:
    rig, soft = load_rig(), with_section(stiffness_factor=0.34)
    mesh, plain = build_mesh(soft, 50), build_mesh(rig, 50)
    np.testing.assert_allclose(mesh.area[:-1], 0.34 * plain.area[:-1])
    np.testing.assert_allclose(mesh.polar_moment[:-1], 0.34 * plain.polar_moment[:-1])
    assert soft.string.axial_stiffness == pytest.approx(0.34 * rig.string.axial_stiffness, rel=0.02)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"tool_joint_outer_diameter": 0.12}, "tool_joint_outer_diameter = 0.12: smaller than the body"),
        ({"tool_joint_outer_diameter": 0.22}, "tool_joint_outer_diameter = 0.22: does not fit the hole"),
        ({"tool_joint_fraction": 0.05}, "tool_joint_outer_diameter: missing"),
        ({"tool_joint_outer_diameter": 0.16, "tool_joint_inner_diameter": 0.16}, "leaves a wall of less than"),
        ({"weight_per_length": 21.9e3}, "weight_per_length = 21900.0: must be at most 20000 N/m"),
    ],
)
def test_impossible_tool_joints_are_refused(keys: dict[str, float], said: str) -> None:
    with pytest.raises(InputError) as error:
        with_section(**keys)
    assert said in str(error.value)
