"""Friction simulator, rocking controller and recorder, one process each.

    ros2 launch slider_drilling rocking.launch.py rig:=rig.yaml duration:=300 speed:=1 record:=out target_deg:=45
"""

from launch import LaunchDescription

from slider_drilling.nodes.launch_helpers import description
from slider_drilling.nodes.simulated_rig import SIMULATED, one_rig


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` asks for."""
    return description(SIMULATED, one_rig)
