"""The plant behind the seal: another mesh, another step and another nuisance than the rig file's."""

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


@dataclass(frozen=True)
class PlantPerturbation:
    """What differs from the rig file besides the law.

    elements: of the mesh; finer_step: how many times as many steps as the plant would take; nuisance: multiples of
    the rig file's values; start: wind-up and toolface zero, rad.
    """

    elements: int = 260
    finer_step: float = 1.33
    nuisance: dict[str, float] = field(default_factory=dict)
    start: InitialState = InitialState()


def random_perturbation(generator: np.random.Generator) -> PlantPerturbation:
    """Nuisance off by some per cent, a mesh and a step that no diagnosis uses."""
    spread = {"friction_1": 0.06, "friction_2": 0.06, "torsional_damping": 0.15, "axial_damping": 0.15,
              "bit_stiffness": 0.07, "motor_gain": 0.03, "pressure_gain": 0.015, "pressure_lag": 0.1}  # fmt: skip
    nuisance = {name: float(np.exp(generator.normal(0.0, sigma))) for name, sigma in spread.items()}
    start = InitialState(float(generator.normal(0.0, 1.0)), float(generator.normal(0.0, 0.3)))
    return PlantPerturbation(int(generator.integers(200, 300)), float(generator.uniform(1.2, 1.8)), nuisance, start)


def simulate_sealed(rig: Rig, hidden: PlantPerturbation, law: PlantLaw, commands: Commands) -> Response:
    """What the plant with the law does, without noise."""
    actual = law.change_commands(commands)
    mesh = build_mesh(rig, hidden.elements)
    modifiers = Modifiers(
        1.0 if law.friction is None else law.friction(mesh.middle),
        0.0 if law.curvature is None else law.curvature(mesh.middle),
    )
    chunk = commands.time.size if law.update_interval is None else round(law.update_interval / INTERVAL_S)
    pieces, state, substeps = [], None, None
    for begin in range(0, commands.time.size, chunk):
        part = slice(begin, begin + chunk)
        at = _moment(rig, commands, begin, chunk)
        tuned = law.change_rig(rig_with(rig, hidden.nuisance | law.values(at)), at)
        substeps = substeps or _substeps(tuned, hidden)
        plant = Plant(tuned, hidden.elements, INTERVAL_S, hidden.start, modifiers, substeps)
        if state is not None:
            plant.restore(state)
        pieces.append(plant.advance(actual.samples(part)))
        state = plant.save()
    joined = [np.concatenate([getattr(piece, name) for piece in pieces]) for name in Response.__dataclass_fields__]
    return law.change_response(Response(*joined))


def _moment(rig: Rig, commands: Commands, begin: int, chunk: int) -> OperatingPoint:
    middle = min(begin + chunk // 2, commands.time.size - 1)
    flow = commands.pump_speed[middle] * rig.mud_pump.displacement / rig.hydraulics.reference_flow
    time = commands.time
    return OperatingPoint(
        float(time[middle]), float(commands.top_drive_angle[middle]), float(flow), float(time[-1] - time[0])
    )


def _substeps(rig: Rig, hidden: PlantPerturbation) -> int:
    own = Plant(rig, hidden.elements, INTERVAL_S)
    return int(np.ceil(hidden.finer_step * own.interval / own.step - 1e-9))


def size_in_noise(rig: Rig, plain: Response, changed: Response) -> float:
    """How far a law moves the most moved channel, RMS in noise floors."""
    sensors = rig.sensors
    floors = {"surface_torque": sensors.surface_torque.noise, "hook_load": sensors.hook_load.noise,
              "standpipe_pressure": sensors.standpipe_pressure.noise}  # fmt: skip

    def moved(name: str) -> Array:
        difference: Array = getattr(changed, name) - getattr(plain, name)
        return difference

    return max(float(np.sqrt(np.mean(moved(name) ** 2))) / sigma for name, sigma in floors.items())
