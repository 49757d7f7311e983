"""The foreign plant: the model's physics where its structure is the model's, closed forms where it is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from slider_drilling.blind.foreign.instruments import as_read
from slider_drilling.blind.foreign.plant import ForeignPlant, slow_changes
from slider_drilling.blind.foreign.structure import FrictionState, Structure, draw_structure
from slider_drilling.blind.manoeuvres import varied
from slider_drilling.blind.outside_laws import slipping_encoder
from slider_drilling.blind.sealed_plant import PlantPerturbation, simulate_foreign
from slider_drilling.contact import friction_table
from slider_drilling.drillstring import Commands, InitialState, Modifiers, Plant, Response
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import Rig, load_rig

UNCHANGED = np.array([[0.0, 1.0, 1.0, 1.0], [1e5, 1.0, 1.0, 1.0]])
ELEMENTS = 120


@pytest.fixture(scope="module")
def rig() -> Rig:
    return load_rig(installed_file("config/rig.example.yaml"))


@pytest.fixture(scope="module")
def commands(rig: Rig) -> Commands:
    return varied(np.random.default_rng(3), rig, 90.0)


def foreign(rig: Rig, commands: Commands, structure: Structure) -> Response:
    return ForeignPlant(rig, ELEMENTS, 0.1, InitialState(), Modifiers(), structure, UNCHANGED).advance(commands)


def turning(rig: Rig) -> Commands:
    """Steady rotation off bottom."""
    time = np.arange(0.0, 60.0, 0.1)
    still = np.zeros_like(time)
    return Commands(time, 3.0 * time, np.full_like(time, 3.0), still - 5.0, still, still)


def test_structure_like_ours_gives_our_response(rig: Rig, commands: Commands) -> None:
    ours = Plant(rig, ELEMENTS, 0.1).advance(commands)
    theirs = foreign(rig, commands, Structure(FrictionState.RADIAL_DAHL, presliding=0.013))
    difference = theirs.surface_torque - ours.surface_torque
    # The radial law differs from the paper's two-step operator where one motion stretches and the other slackens.
    assert np.std(difference) < 0.02 * np.std(ours.surface_torque)


@pytest.mark.parametrize("elements", [32, 100])
def test_almost_rigid_contact_is_coulomb_friction(rig: Rig, commands: Commands, elements: int) -> None:
    rigid = replace(rig, contact=replace(rig.contact, stiffness=200.0 * rig.contact.stiffness))
    ours = Plant(rigid, elements, 0.1).advance(commands)
    structure = Structure(FrictionState.REGULARISED_COULOMB, creep_speed=1e-5)
    theirs = ForeignPlant(rig, elements, 0.1, InitialState(), Modifiers(), structure, UNCHANGED).advance(commands)
    difference = theirs.surface_torque - ours.surface_torque
    assert np.std(difference) < 0.03 * np.std(ours.surface_torque)


@pytest.mark.parametrize(
    "state, elastic_share", [(FrictionState.RADIAL_DAHL, 0.0), (FrictionState.ELASTO_PLASTIC, 1.0)]
)
def test_vector_law_is_foreign_law(rig: Rig, commands: Commands, state: FrictionState, elastic_share: float) -> None:
    contact = replace(rig.contact, elastic_share=elastic_share, vector_share=1.0)
    ours = Plant(replace(rig, contact=contact), ELEMENTS, 0.1).advance(commands)
    theirs = foreign(rig, commands, Structure(state, presliding=0.013))
    assert np.std(ours.tool_face - theirs.tool_face) < 0.01
    assert np.std(ours.hook_load - theirs.hook_load) < 300.0


def test_elastic_contact_is_closer_to_elasto_plastic_friction(rig: Rig, commands: Commands) -> None:
    theirs = foreign(rig, commands, Structure(FrictionState.ELASTO_PLASTIC, presliding=0.013)).surface_torque

    def error(share: float) -> float:
        elastic = replace(rig, contact=replace(rig.contact, elastic_share=share))
        return float(np.std(Plant(elastic, ELEMENTS, 0.1).advance(commands).surface_torque - theirs))

    assert error(1.0) < 0.5 * error(0.0)


@pytest.mark.parametrize("state", list(FrictionState))
def test_steady_rotation_takes_the_closed_form(rig: Rig, state: FrictionState) -> None:
    plant = ForeignPlant(
        rig, ELEMENTS, 0.1, InitialState(), Modifiers(), Structure(state, isotropy=1.0), UNCHANGED
    )  # fmt: skip
    torque = plant.advance(turning(rig)).surface_torque[-50:].mean()
    model = Plant(rig, ELEMENTS, 0.1).advance(turning(rig)).surface_torque[-50:].mean()
    # Isotropic friction is the mean over directions; the model has that of slip across the hole (q = 0).
    table = friction_table(rig.contact.shear_factor, rig.contact.asperity)
    assert torque / model == pytest.approx(table.mean() / table[0], rel=0.01)


def test_hanging_weight_needs_no_friction(rig: Rig) -> None:
    time = np.arange(0.0, 5.0, 0.1)
    still = np.zeros_like(time)
    response = foreign(rig, Commands(time, still, still, still, still, still), Structure())
    ours = Plant(rig, ELEMENTS, 0.1).advance(Commands(time, still, still, still, still, still))
    assert response.hook_load[0] == pytest.approx(ours.hook_load[0], rel=1e-9)


def test_coulomb_string_at_rest_creeps_little(rig: Rig) -> None:
    time = np.arange(0.0, 120.0, 0.1)
    speed = np.where(time < 5.0, 2.0, 0.0)
    still = np.zeros_like(time)
    commands = Commands(time, np.minimum(2.0 * time, 10.0), speed, still - 2.0, still, still)
    torque = foreign(rig, commands, Structure(FrictionState.REGULARISED_COULOMB)).surface_torque
    assert torque[-1] > 0.9 * torque[200]


def test_wall_holds_no_torque_of_a_drilling_bit(rig: Rig) -> None:
    # A string that is lowered slides along the hole: no direction of friction is left that could hold torque at rest.
    time = np.arange(0.0, 240.0, 0.1)
    pump = np.full_like(time, rig.reference_pump_speed)
    angle = 27.0 * np.sin(2.0 * np.pi * time / 8.0)
    speed = 27.0 * 2.0 * np.pi / 8.0 * np.cos(2.0 * np.pi * time / 8.0)
    commands = Commands(time, angle, speed, 0.0025 * time, np.full_like(time, 0.0025), pump)
    structure = Structure(FrictionState.REGULARISED_COULOMB, isotropy=1.0)
    plant = ForeignPlant(rig, 20, 0.1, InitialState(), Modifiers(), structure, UNCHANGED)
    response = plant.advance(commands)
    cycles = slice(-800, None)  # ten
    torque = response.bit_torque[cycles].mean()
    assert torque > 1e3, "the bit drills"
    assert response.surface_torque[cycles].mean() == pytest.approx(torque, rel=0.15)


def test_halved_step_changes_little(rig: Rig, commands: Commands) -> None:
    structure = Structure(FrictionState.ELASTO_PLASTIC, drive_lag=0.1)
    coarsest = ForeignPlant(rig, ELEMENTS, 0.1, InitialState(), Modifiers(), structure, UNCHANGED)
    finer = ForeignPlant(
        rig, ELEMENTS, 0.1, InitialState(), Modifiers(), structure, UNCHANGED, substeps=2 * coarsest.substeps
    )  # fmt: skip
    coarse, fine = coarsest.advance(commands), finer.advance(commands)
    assert np.std(fine.surface_torque - coarse.surface_torque) < 0.02 * np.std(fine.surface_torque)


def test_split_run_equals_whole_run(rig: Rig, commands: Commands) -> None:
    structure = draw_structure(np.random.default_rng(5))
    changes = slow_changes(structure, 90.0, np.random.default_rng(6))

    def plant() -> ForeignPlant:
        return ForeignPlant(rig, ELEMENTS, 0.1, InitialState(), Modifiers(), structure, changes)

    whole, first, second = plant(), plant(), plant()
    expected = whole.advance(commands).surface_torque
    begin = first.advance(commands.samples(slice(0, 400))).surface_torque
    second.continue_from(first)
    end = second.advance(commands.samples(slice(400, None))).surface_torque
    assert np.array_equal(np.concatenate([begin, end]), expected)
    assert np.array_equal(second.driven, whole.driven)


def test_sheaves_read_less_while_lowering(rig: Rig, commands: Commands) -> None:
    structure = Structure(deadline_hysteresis=3e3)
    plant = ForeignPlant(rig, ELEMENTS, 0.1, InitialState(), Modifiers(), structure, UNCHANGED)
    response = plant.advance(commands)
    _, seen = as_read(structure, commands, response, plant.driven, np.random.default_rng(1))
    lowering = commands.block_speed > 2e-3
    read_less = (response.hook_load - seen.hook_load)[lowering]
    assert np.all((read_less > 2e3) & (read_less < 3e3))


def test_hidden_change_of_the_drive_stays_hidden(rig: Rig, commands: Commands) -> None:
    """An encoder that slips shows what was asked for, whatever the drive of a foreign plant does."""
    law = slipping_encoder(np.random.default_rng(1), rig, 1.0)
    seen, _ = simulate_foreign(rig, PlantPerturbation(elements=80), law, commands, Structure(), 1)
    assert np.max(np.abs(seen.top_drive_angle - commands.top_drive_angle)) < 0.05


def test_drawn_structures_keep_their_ranges() -> None:
    drawn = [draw_structure(np.random.default_rng(seed)) for seed in range(200)]
    assert {one.friction_state for one in drawn} == set(FrictionState)
    assert all(0.004 <= one.presliding <= 0.016 and 0.0 <= one.joint_radius <= 0.12 for one in drawn)
