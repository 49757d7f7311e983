"""How a log drove its rig, as far as it was logged and as its sensors tell the rest."""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.drillstring import Commands, InitialState
from slider_drilling.gap.model import Array
from slider_drilling.log import RigLog
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.log_inputs.infer_initial_state import infer_initial_state, initial_transient_end
from slider_drilling.rig import Rig


@dataclass(frozen=True)
class RunInputs:
    """commands: what moved the rig; acceleration: (n,) rad/s2 of the top drive, None where commands have no noise;
    start: what the run begins with, before anything is fitted; flow_steps: s at which the flow may have changed unseen,
    None where the pump was logged; lowered: whether nobody logged the block; begin: s from which the run is compared.
    """

    commands: Commands
    acceleration: Array | None = None
    start: InitialState = InitialState()
    flow_steps: tuple[float, ...] | None = None
    lowered: bool = False
    begin: float = 0.0


def read_run_inputs(log: RigLog, rig: Rig, remarks: list[str]) -> RunInputs:
    """How this log drove the rig; what it does not hold and how that is made up for is added to the remarks."""
    driven = commands_from_log(log, rig)
    said = [*driven.assumptions]
    if driven.flow_step_times:
        at = ", ".join(f"{step:.1f}" for step in driven.flow_step_times)
        said.append(f"pressure steps at {at} s: by how much the flow changed is fitted")
    start, begin = infer_initial_state(log, rig, driven.commands), float(driven.commands.time[0])
    if start.loaded:
        begin = initial_transient_end(rig, driven.commands)
        said.append(
            "begins while the string is at work: its state is fitted, and what was measured before "
            f"{begin:.1f} s is left out"
        )
    remarks += [f"{log.source}: {sentence}" for sentence in said]
    return RunInputs(
        driven.commands, driven.acceleration, start, driven.flow_step_times, driven.block_from_pressure, begin
    )
