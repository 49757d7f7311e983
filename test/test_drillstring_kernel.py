"""The compiled step against the same step in plain double precision, with exponentials and no shortcut."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numba import njit

from slider_drilling.contact import friction_coefficient_of_direction
from slider_drilling.drillstring import Commands, InitialState, Modifiers, assemble, kernel, simulate, simulate_batch
from slider_drilling.drillstring.initial_state import initial_kernel_state
from slider_drilling.effects import Effects, FrictionDrift, StaticAging, Stribeck
from slider_drilling.rig import load_rig
from slider_drilling.rig.parts import GRAVITY
from slider_drilling.wellbore.mesh import build_mesh

RIG = load_rig(Path(__file__).parents[1] / "config" / "rig.example.yaml")
PUMP = RIG.hydraulics.reference_flow / RIG.mud_pump.displacement


def turning(duration: float) -> Commands:
    time = np.arange(0.0, duration + 0.05, 0.1)
    return Commands(time, 3.0 * (1.0 - np.cos(time)), 3.0 * np.sin(time), 0.05 * time, 0.05 + 0.0 * time,
                    PUMP + 0.0 * time)  # fmt: skip


def plain_torque(rig, commands: Commands, count: int, substeps: int) -> np.ndarray:
    """Surface torque by `model.md`, with no weight on bit: no seeds, polynomial, table or vectors."""
    mesh = build_mesh(rig, count)
    springs = assemble.springs(rig, mesh)
    dt = 0.1 / substeps
    e = assemble.elements([rig], mesh, dt, [Modifiers()])
    c = assemble.lanes([rig], mesh, dt)
    rows = commands.rows()
    s = initial_kernel_state([rig], mesh, e, c, assemble.friction_curve(rig.contact), dt, rows[0], [InitialState()])
    x, phi = s.position[: count + 2].copy(), s.rotation[: count + 2].copy()
    v, w, za, zt = (np.zeros(count) for _ in range(4))
    ka, kt = springs.axial, springs.torsional
    grip = rig.contact.stiffness / rig.contact.reference_load
    weight = e.axial_force[:count]
    across_weight = GRAVITY * (rig.string.density - rig.mud.density) * mesh.area * mesh.length * mesh.sine
    out = [kt[0] * (phi[0] - phi[1])]
    for a, b in pairwise(rows):
        for n in range(substeps):
            pull, twist = ka * np.diff(x), -kt * np.diff(phi)
            tension = 0.5 * (pull[:-1] + pull[1:])
            side = np.hypot(across_weight - tension * mesh.vertical_curvature * mesh.length,
                            tension * mesh.lateral_curvature * mesh.length)  # fmt: skip
            force = np.diff(pull) + weight - grip * side * za
            torque = -np.diff(twist) - mesh.outer_radius * grip * side * zt
            v = (v + dt * force / springs.mass) / (1.0 + dt * rig.string.axial_damping)
            w = (w + dt * torque / springs.inertia) / (1.0 + dt * rig.string.torsional_damping)
            da, db = dt * v, dt * w * mesh.outer_radius
            ma, mt = za + 0.5 * da, zt + 0.5 * db
            size = np.hypot(ma, mt) + 1e-15
            mu = friction_coefficient_of_direction(rig.contact, np.arccos(np.minimum(np.abs(ma) / size, 1.0)))
            u = (np.abs(ma * da) + np.abs(mt * db)) / size * grip / mu
            grown = np.where(u > 1e-9, -np.expm1(-u) / np.maximum(u, 1e-9), 1.0)
            za, zt = za * np.exp(-u) + da * grown, zt * np.exp(-u) + db * grown
            x[1:-1] += dt * v
            phi[1:-1] += dt * w
            f = (n + 1.0) / substeps
            phi[0] = hermite(a[0], a[1], b[0], b[1], f)
            x[0] = hermite(a[2], a[3], b[2], b[3], f)
        out.append(kt[0] * (phi[0] - phi[1]))
    return np.array(out)


def hermite(start: float, rate: float, end: float, end_rate: float, f: float) -> float:
    """The cubic through two values and slopes 0.1 s apart, by its basis functions."""
    basis = (2 * f**3 - 3 * f**2 + 1, 0.1 * (f**3 - 2 * f**2 + f), 3 * f**2 - 2 * f**3, 0.1 * (f**3 - f**2))
    return basis[0] * start + basis[1] * rate + basis[2] * end + basis[3] * end_rate


def test_step_equals_plain_double_precision_model():
    """Seeded roots, the polynomial of 1 / mu and the Taylor sum together: below 1e-6 of the torque's range."""
    soft = dataclasses.replace(RIG, bit=dataclasses.replace(RIG.bit, depth_of_cut_stiffness=1e-9))
    rig = dataclasses.replace(soft, well=dataclasses.replace(RIG.well, friction_intervals=()))
    compiled = simulate(rig, turning(20.0), 30, substeps=8).surface_torque
    plain = plain_torque(rig, turning(20.0), 30, 8)
    assert np.ptp(plain) > 1000.0
    assert np.max(np.abs(compiled - plain)) < 1e-6 * np.ptp(plain)


@njit
def reciprocal(x):
    return kernel.fast_reciprocal(x, np.float64)


@njit
def reciprocal_single(x):
    return kernel.fast_reciprocal(np.float32(x), np.float32)


@pytest.mark.parametrize(("call", "exact", "bound"), [
    (kernel.fast_sqrt, np.sqrt, 1.2e-7),
    (kernel.fast_inverse_sqrt, lambda x: 1.0 / np.sqrt(x), 1.8e-7),
    (reciprocal, lambda x: 1.0 / x, 2e-14),
    (reciprocal_single, lambda x: 1.0 / x, 1.8e-7),
])  # fmt: skip
def test_fast_arithmetic_keeps_stated_error(call, exact, bound):
    @njit(error_model="numpy")
    def all_of(values):
        out = np.empty_like(values)
        for i in range(len(values)):
            out[i] = call(values[i])
        return out

    x = np.logspace(-20, 20, 200_001)
    assert np.max(np.abs(all_of(x) / exact(x) - 1.0)) < bound


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("lanes", [2, 3, 8, 17, 33])
@pytest.mark.parametrize("effects", [Effects(), Effects(stribeck=Stribeck(0.4), static_aging=StaticAging(0.3))])
def test_lane_equals_single_run(lanes, effects, single):
    """Bit for bit, whatever part of a vector the lane falls in."""
    shares = np.linspace(0.4, 0.6, lanes)
    bits = [dataclasses.replace(RIG.bit, aggressiveness=share) for share in shares]
    rigs = [dataclasses.replace(RIG, effects=effects, bit=bit) for bit in bits]
    batch = simulate_batch(rigs, turning(3.0), elements=13, single_precision=single)
    for k in (0, lanes // 2, lanes - 1):
        (alone,) = simulate_batch([rigs[k]], turning(3.0), elements=13, single_precision=single)
        assert np.array_equal(alone.surface_torque, batch[k].surface_torque)
        assert np.array_equal(alone.tool_face, batch[k].tool_face)


def test_effect_in_one_lane_leaves_others_unchanged():
    """One lane with Stribeck friction takes all through `vary_with_speed`, which is neutral for the others."""
    with_stribeck = dataclasses.replace(RIG, effects=Effects(stribeck=Stribeck(0.4)))
    both = simulate_batch([RIG, with_stribeck], turning(3.0), elements=13)
    alone = simulate(RIG, turning(3.0), elements=13)
    assert np.array_equal(both[0].surface_torque, alone.surface_torque)
    assert np.max(np.abs(both[1].surface_torque - alone.surface_torque)) > 1.0


LIMITS = {"surface_torque": 0.5, "hook_load": 50.0, "standpipe_pressure": 1e3, "tool_face": 1e-2}


@pytest.mark.parametrize("effects", [
    Effects(), Effects(static_aging=StaticAging(0.3), friction_drift=FrictionDrift(1e-3)),
])  # fmt: skip
@pytest.mark.parametrize(("elements", "exponent"), [(32, 1.0), (100, 1.0), (32, 1.5)])
def test_single_precision_error_is_below_sensor_noise(effects, elements, exponent):
    """Of 60 s of turning and letting down, with positions of tens of metres and weights of a meganewton."""
    contact = dataclasses.replace(RIG.contact, dahl_exponent=exponent)
    rig = dataclasses.replace(RIG, effects=effects, contact=contact)
    commands = turning(60.0)
    (double,), (single,) = (
        simulate_batch([rig], commands, elements, single_precision=which) for which in (False, True)
    )
    for channel, limit in LIMITS.items():
        there, here = getattr(double, channel), getattr(single, channel)
        assert 0.0 < np.sqrt(np.mean((there - here) ** 2)) < limit, channel


@pytest.mark.parametrize("single", [False, True])
def test_frictionless_contact_stays_finite_at_any_speed(single):
    free = dataclasses.replace(RIG, well=dataclasses.replace(RIG.well, friction_intervals=()))
    (response,) = simulate_batch(
        [free], turning(5.0), elements=20, modifiers=[Modifiers(friction_factor=0.0)], single_precision=single
    )
    assert np.all(np.isfinite(response.surface_torque))
    assert math.isfinite(response.tool_face[-1])


def test_stiffness_of_the_contact_leaves_the_friction_law_as_it_is():
    """A fit that varies it computes the law once."""
    contact = RIG.contact
    other = dataclasses.replace(contact, stiffness=2.0 * contact.stiffness)
    first, second = assemble.friction_curve(contact), assemble.friction_curve(other)
    assert second.table is first.table and second.polynomial is first.polynomial
    assert second.stiffness_per_load == pytest.approx(2.0 * first.stiffness_per_load)
