"""A simulated rig driven by the commands of a log, with the log's measurements in the namespace `recorded`.

    ros2 launch slider_drilling replay.launch.py log:=slide.mcap speed:=max record:=out

A twin (twin:=true) judges the log's measurements, in `recorded`.
"""

from pathlib import Path

from launch import LaunchDescription, LaunchDescriptionEntity

from slider_drilling.log import read_log
from slider_drilling.nodes.launch_helpers import (
    LaunchArguments,
    dashboard,
    description,
    is_true,
    process,
    run_together,
    speed,
    twin,
)

RECORDED = "recorded"  # namespace of the log's measurements


def replay(given: LaunchArguments) -> list[LaunchDescriptionEntity]:
    """Simulator and player, which end with the log, and, where a folder is given, recorder. Raises InputError."""
    if not given["log"]:
        raise ValueError("log:= is missing: give the MCAP log to play")
    shown = dashboard(given)
    begins = read_log(Path(given["log"])).start
    simulator = process(
        "friction_simulator", given, {"speed": 1.0, "wait_for_controller": True},
        {"rig": given["rig"] or given["log"], "speed": speed(given), "start_time": begins,
         "minimum_subscribers": 2 + len(shown) if given["record"] else None})
    player = process("log_player", given, {"use_sim_time": True, "beside": RECORDED},
                     {"log": given["log"], "commands_only": True, "twin_topics": not is_true(given, "twin")})
    if given["record"]:
        shown.append(process("recorder", given, {"use_sim_time": True}, {
            "rig": given["rig"], "directory": given["record"], "regex": ".*/recorded/.*"}))
    recorded = "/".join(filter(None, [given["namespace"].strip("/"), RECORDED]))
    shown += twin(given, True, given["rig"] or given["log"], recorded, given["namespace"])
    return run_together(ending=[player], required=[simulator], optional=shown)


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` asks for."""
    return description(
        ("log", "rig", "speed", "record", "dashboard", "twin", "namespace", "parameters", "respawn", "discovery"),
        replay)
