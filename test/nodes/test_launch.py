"""The launch file, where `launch` is installed: a sourced ROS 2 has it, the wheels do not."""

import importlib.util
from pathlib import Path

import pytest

launch = pytest.importorskip("launch")
launch_ros_actions = pytest.importorskip("launch_ros.actions")


def described(repository: Path, **arguments: str) -> dict[str, dict[str, object]]:
    """Node name -> parameters, of the processes that the launch file would start."""
    spec = importlib.util.spec_from_file_location("rocking_launch", repository / "launch" / "rocking.launch.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    context = launch.LaunchContext()
    description = module.generate_launch_description()
    for entity in description.entities:
        if isinstance(entity, launch.actions.DeclareLaunchArgument):
            context.launch_configurations[entity.name] = arguments.get(
                entity.name, launch.utilities.perform_substitutions(context, entity.default_value))
    started = [one for one in module.nodes(context) if isinstance(one, launch_ros_actions.Node)]
    return {one._Node__node_name: one for one in started}


def test_recorder_only_where_a_folder_is_given(repository):
    assert set(described(repository)) == {"friction_simulator", "rocking_controller"}
    assert set(described(repository, record="out")) == {"friction_simulator", "rocking_controller", "recorder"}


def test_speed_max_is_lockstep(repository):
    assert described(repository, speed="max", duration="300")
    with pytest.raises(ValueError, match="fast"):
        described(repository, speed="fast")
