"""Top drive, block and bit of a running rig in RViz; needs robot_state_publisher, joint_state_publisher and rviz2.

    ros2 launch slider_drilling rviz.launch.py namespace:=rig_a
"""

from launch import LaunchDescription, LaunchDescriptionEntity
from launch_ros.actions import Node

from slider_drilling.files.installed_files import installed_file
from slider_drilling.files.output_files import read_text
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes.launch_helpers import LaunchArguments, description

JOINTS = ("top_drive", "draw_works", "truth_bit")  # of a real rig the bit's is missing, and its angle stays 0


def rviz(given: LaunchArguments) -> list[LaunchDescriptionEntity]:
    """The publishers of the rig's frames, and RViz."""
    urdf = read_text(installed_file("config/urdf/rig.urdf"), "URDF")
    joints = {"robot_description": urdf, "source_list": [TOPICS[name].name for name in JOINTS]}
    namespace = given["namespace"]
    return [
        Node(package="joint_state_publisher", executable="joint_state_publisher", namespace=namespace,
             parameters=[joints]),
        Node(package="robot_state_publisher", executable="robot_state_publisher", namespace=namespace,
             parameters=[{"robot_description": urdf}]),
        Node(package="rviz2", executable="rviz2", namespace=namespace, arguments=["--fixed-frame", "map"]),
    ]  # fmt: skip


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` asks for."""
    return description(("namespace",), rviz)
