"""A simulated rig whose nodes a lifecycle manager brings up and down; needs nav2_lifecycle_manager.

    ros2 launch slider_drilling managed.launch.py record:=out
    ros2 service call /lifecycle_manager/manage_nodes nav2_msgs/srv/ManageLifecycleNodes "{command: 1}"

The second command pauses all nodes: the controller stops block and top drive, the recorder notes the pause.
"""

from launch import LaunchDescription, LaunchDescriptionEntity
from launch_ros.actions import Node

from slider_drilling.nodes.launch_helpers import LaunchArguments, description, process, run_together, twin

ARGUMENTS = ("rig", "record", "twin", "namespace", "parameters", "respawn", "discovery")


def managed_rig(given: LaunchArguments) -> list[LaunchDescriptionEntity]:
    """Simulator, controller and recorder, not configured, and their manager, which does not wait for a twin."""
    own = {"autostart": False, "rig": given["rig"]}
    simulator = process("friction_simulator", given, {"speed": 1.0, "wait_for_controller": True}, own)
    controller = process("rocking_controller", given, {"use_sim_time": True}, own)
    recorder = process("recorder", given, {"use_sim_time": True}, {**own, "directory": given["record"]})
    # The recorder first, which then misses nothing; the simulator last, whose time starts when it is active.
    names = ["recorder", "rocking_controller", "friction_simulator"]
    # These nodes have no bond: the manager would end them all when one is late.
    settings = {"node_names": names, "autostart": True, "bond_timeout": 0.0}
    manager = Node(package="nav2_lifecycle_manager", executable="lifecycle_manager", name="lifecycle_manager",
                   namespace=given["namespace"], parameters=[settings])  # fmt: skip
    observers = [recorder, *twin(given, True, given["rig"])]
    return [*run_together(ending=[simulator], required=[controller], optional=observers), manager]


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` asks for."""
    return description(ARGUMENTS, managed_rig)
