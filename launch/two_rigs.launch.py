"""Two simulated rigs in one graph, in the namespaces rig_a and rig_b, each with its own clock and log.

    ros2 launch slider_drilling two_rigs.launch.py duration:=600 speed:=max record:=out
"""

from launch import LaunchDescription, LaunchDescriptionEntity

from slider_drilling.live.server import PORT
from slider_drilling.nodes.launch_helpers import LaunchArguments, description, run_together
from slider_drilling.nodes.simulated_rig import SIMULATED, simulated_rig


def two_rigs(given: LaunchArguments) -> list[LaunchDescriptionEntity]:
    """Both rigs, until both have ended or one has no controller; logs in folders of the rigs' names."""
    space = given["namespace"].strip("/")
    rigs = []
    for name, port in (("rig_a", PORT), ("rig_b", PORT + 1)):
        own = {**given, "record": f"{given['record']}/{name}" if given["record"] else ""}
        rigs.append(simulated_rig(own, "/".join(filter(None, [space, name])), port))
    return run_together(
        ending=[rig.simulator for rig in rigs],
        required=[rig.controller for rig in rigs],
        optional=[node for rig in rigs for node in rig.observers],
    )


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` asks for."""
    return description(SIMULATED, two_rigs)
