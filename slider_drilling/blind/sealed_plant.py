"""The plant of a sealed log. Its mesh, time step and nuisance parameters differ from those of the rig file."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from slider_drilling.blind.plant_law import OperatingPoint, PlantLaw
from slider_drilling.diagnosis.drill_string import rig_with
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
    start = InitialState(float(generator.normal(0.0, 1.0)), float(generator.normal(0.0, 0.3)))
    return PlantPerturbation(int(generator.integers(200, 300)), float(generator.uniform(1.2, 1.8)), nuisance, start)


def simulate_sealed(rig: Rig, perturbation: PlantPerturbation, law: PlantLaw, commands: Commands) -> Response:
    """Returns the response of the sealed plant, without noise.

    Args:
        rig: The rig as its file states it.
        perturbation: How the plant differs from the file.
        law: What else the plant does.
        commands: What the log states; the law may change it.
    """
    true_commands = law.change_commands(commands)
    mesh = build_mesh(rig, perturbation.elements)
    modifiers = Modifiers(
        1.0 if law.friction is None else law.friction(mesh.middle),
        0.0 if law.curvature is None else law.curvature(mesh.middle),
    )
    # The law is constant over a part of the run; each part continues from the state that the one before it left.
    samples = commands.time.size if law.update_interval is None else round(law.update_interval / INTERVAL_S)
    parts, state, substeps = [], None, None
    for begin in range(0, commands.time.size, samples):
        at = _operating_point(rig, commands, begin, samples)
        changed = law.change_rig(rig_with(rig, perturbation.nuisance | law.values(at)), at)
        substeps = substeps or _substeps(changed, perturbation)
        plant = Plant(changed, perturbation.elements, INTERVAL_S, perturbation.start, modifiers, substeps)
        if state is not None:
            plant.restore(state)
        parts.append(plant.advance(true_commands.samples(slice(begin, begin + samples))))
        state = plant.save()
    joined = [np.concatenate([getattr(part, name) for part in parts]) for name in Response.__dataclass_fields__]
    return law.change_response(Response(*joined))


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
