"""The nodes' statuses in groups on /diagnostics_agg; needs diagnostic_aggregator.

    ros2 launch slider_drilling diagnostics.launch.py
"""

from launch import LaunchDescription, LaunchDescriptionEntity
from launch_ros.actions import Node

from slider_drilling.files.installed_files import installed_file
from slider_drilling.nodes.launch_helpers import LaunchArguments, description


def aggregator(given: LaunchArguments) -> list[LaunchDescriptionEntity]:
    """The aggregator with this package's groups."""
    groups = str(installed_file("config/diagnostic_aggregator.yaml"))
    return [Node(package="diagnostic_aggregator", executable="aggregator_node", parameters=[groups])]


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` asks for."""
    return description((), aggregator)
