"""What drove the rig in a log: as logged, and reconstructed where the log lacks it."""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.drillstring import Commands, InitialState
from slider_drilling.gap.model import Array
from slider_drilling.log import RigLog
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.log_inputs.infer_initial_state import infer_initial_state, initial_transient_end
from slider_drilling.rig import Rig
from slider_drilling.units import Text, sentence


@dataclass(frozen=True)
class RunInputs:
    """Inputs of a simulated run.

    Attributes:
        commands: Motion of top drive, block and pump.
        acceleration: (n,) rad/s2 of the top drive; None for commands without noise, which can be differentiated.
        initial_state: Of the string, before anything is fitted.
        flow_step_times: s at which the flow may have changed; None if the pump was logged.
        block_from_pressure: The block was not logged; its motion comes from standpipe pressure.
        compared_from: s from which measured and simulated are compared.
    """

    commands: Commands
    acceleration: Array | None = None
    initial_state: InitialState = InitialState()
    flow_step_times: tuple[float, ...] | None = None
    block_from_pressure: bool = False
    compared_from: float = 0.0


def read_run_inputs(log: RigLog, rig: Rig, remarks: list[Text]) -> RunInputs:
    """The inputs of a logged run.

    Args:
        log: The checked log.
        rig: Its rig file.
        remarks: Gets one sentence for each assumption that replaces a missing channel.
    """
    logged = commands_from_log(log, rig)
    notes = [*logged.assumptions]
    if logged.flow_step_times:
        times = ", ".join(f"{step:.1f}" for step in logged.flow_step_times)
        notes.append(f"standpipe pressure steps at {times} s: the change of flow there is fitted")
    initial_state = infer_initial_state(log, rig, logged.commands)
    compared_from = float(logged.commands.time[0])
    if initial_state.loaded:
        compared_from = initial_transient_end(rig, logged.commands)
        notes.append(
            "the log starts while the string is loaded: its initial state is fitted, and samples before "
            f"{compared_from:.1f} s are left out"
        )
    remarks += [sentence(f"{log.source}: ", note) for note in notes]
    return RunInputs(
        logged.commands, logged.acceleration, initial_state, logged.flow_step_times, logged.block_from_pressure,
        compared_from,
    )  # fmt: skip
