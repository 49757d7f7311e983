"""The plant of a sealed log. Its mesh, time step and nuisance parameters differ from those of the rig file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from slider_drilling.blind.foreign.instruments import as_read
from slider_drilling.blind.foreign.plant import ForeignPlant, slow_changes
from slider_drilling.blind.foreign.structure import Structure
from slider_drilling.blind.plant_law import OperatingPoint, PlantLaw
from slider_drilling.diagnosis.rig_values import rig_with
from slider_drilling.drillstring import Commands, InitialState, Modifiers, Plant, Response
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.rig import Rig
from slider_drilling.wellbore.mesh import build_mesh

INTERVAL_S = 0.1
"""Sampling interval of a sealed log."""


@dataclass(frozen=True)
class PlantPerturbation:
    """How a sealed plant differs from the rig file, apart from its law.

    Attributes:
        elements: Of the mesh.
        finer_step: Time steps of the sealed plant for each step of a plant from the rig file.
        nuisance: Factors on the rig file's values, by nuisance parameter.
        start: Twist at the start and zero of the toolface, rad.
    """

    elements: int = 260
    finer_step: float = 1.33
    nuisance: dict[str, float] = field(default_factory=dict)
    start: InitialState = InitialState()


def random_perturbation(generator: np.random.Generator) -> PlantPerturbation:
    """Returns nuisance parameters that are wrong by some per cent, and a mesh and step that no diagnosis uses."""
    spread = {"friction_1": 0.06, "friction_2": 0.06, "torsional_damping": 0.15, "axial_damping": 0.15,
              "bit_stiffness": 0.07, "motor_gain": 0.03, "pressure_gain": 0.015, "pressure_lag": 0.1}  # fmt: skip
    nuisance = {name: float(np.exp(generator.normal(0.0, sigma))) for name, sigma in spread.items()}
    start = draw_start(generator)
    return PlantPerturbation(int(generator.integers(200, 300)), float(generator.uniform(1.2, 1.8)), nuisance, start)


def draw_start(generator: np.random.Generator) -> InitialState:
    """Returns how a run begins: twist, and zero of the toolface."""
    return InitialState(float(generator.normal(0.0, 1.0)), float(generator.normal(0.0, 0.3)))


def simulate_sealed(rig: Rig, perturbation: PlantPerturbation, law: PlantLaw, commands: Commands) -> Response:
    """Returns the response of the sealed plant, without noise.

    Args:
        rig: The rig as its file states it.
        perturbation: How the plant differs from the file.
        law: What else the plant does.
        commands: What the log states; the law may change it.
    """
    state, substeps, responses = None, None, []
    modifiers = _modifiers(rig, perturbation, law)
    for changed, part in _parts(rig, perturbation, law, commands, law.change_commands(commands)):
        substeps = substeps or _substeps(changed, perturbation)
        plant = Plant(changed, perturbation.elements, INTERVAL_S, perturbation.start, modifiers, substeps)
        if state is not None:
            plant.restore(state)
        responses.append(plant.advance(part))
        state = plant.save()
    return law.change_response(_joined(responses))


def simulate_foreign(
    rig: Rig, perturbation: PlantPerturbation, law: PlantLaw, commands: Commands, structure: Structure, seed: int
) -> tuple[Commands, Response]:
    """Returns what the instruments of a plant of foreign structure show: commands and response, without noise.

    Args:
        rig: The rig as its file states it.
        perturbation: How the plant's numbers differ from the file.
        law: What else the plant does.
        commands: What the controller asks for; the law may change it.
        structure: How the plant differs from the model.
        seed: Of its slow changes and of its clock.
    """
    generator = np.random.default_rng(seed)
    changes = slow_changes(structure, float(commands.time[-1]), generator)
    modifiers = _modifiers(rig, perturbation, law)
    plant: ForeignPlant | None = None
    responses, true_commands = [], law.change_commands(commands)
    for changed, part in _parts(rig, perturbation, law, commands, true_commands):
        following = ForeignPlant(
            changed, perturbation.elements, INTERVAL_S, perturbation.start, modifiers, structure, changes,
            plant.substeps if plant else None,
        )  # fmt: skip
        if plant is not None:
            following.continue_from(plant)
        responses.append(following.advance(part))
        plant = following
    assert plant is not None
    # The encoder shows where the drive is, but for what the law hides from it.
    angle = plant.driven[:, 0] - true_commands.top_drive_angle + commands.top_drive_angle
    speed = plant.driven[:, 1] - true_commands.top_drive_speed + commands.top_drive_speed
    response = law.change_response(_joined(responses))
    return as_read(structure, commands, response, np.column_stack([angle, speed]), generator)


def _modifiers(rig: Rig, perturbation: PlantPerturbation, law: PlantLaw) -> Modifiers:
    mesh = build_mesh(rig, perturbation.elements)
    return Modifiers(
        1.0 if law.friction is None else law.friction(mesh.middle),
        0.0 if law.curvature is None else law.curvature(mesh.middle),
    )


def _parts(
    rig: Rig, perturbation: PlantPerturbation, law: PlantLaw, commands: Commands, true_commands: Commands
) -> Iterator[tuple[Rig, Commands]]:
    """Yields the rig as it is and the true commands for each part of the run over which the law is constant."""
    samples = commands.time.size if law.update_interval is None else round(law.update_interval / INTERVAL_S)
    for begin in range(0, commands.time.size, samples):
        at = _operating_point(rig, commands, begin, samples)
        changed = law.change_rig(rig_with(rig, perturbation.nuisance | law.values(at)), at)
        yield changed, true_commands.samples(slice(begin, begin + samples))


def _joined(parts: Sequence[Response]) -> Response:
    names = Response.__dataclass_fields__
    return Response(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def _operating_point(rig: Rig, commands: Commands, begin: int, samples: int) -> OperatingPoint:
    middle = min(begin + samples // 2, commands.time.size - 1)
    flow = commands.pump_speed[middle] * rig.mud_pump.displacement / rig.hydraulics.reference_flow
    time = commands.time
    return OperatingPoint(
        float(time[middle]), float(commands.top_drive_angle[middle]), float(flow), float(time[-1] - time[0])
    )


def _substeps(rig: Rig, perturbation: PlantPerturbation) -> int:
    own = Plant(rig, perturbation.elements, INTERVAL_S)
    return int(np.ceil(perturbation.finer_step * own.interval / own.step - 1e-9))


def size_in_noise(rig: Rig, neutral: Response, changed: Response) -> float:
    """Returns how much a law changes the channel that it changes most: RMS in units of the declared noise."""
    sensors = rig.sensors
    floors = {"surface_torque": sensors.surface_torque.noise, "hook_load": sensors.hook_load.noise,
              "standpipe_pressure": sensors.standpipe_pressure.noise}  # fmt: skip

    def difference(name: str) -> Array:
        change: Array = getattr(changed, name) - getattr(neutral, name)
        return change

    return max(float(np.sqrt(np.mean(difference(name) ** 2))) / sigma for name, sigma in floors.items())
