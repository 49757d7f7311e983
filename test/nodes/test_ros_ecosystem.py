"""What other ROS programs read: frames and URDF, groups of statuses, launch files for foreign nodes."""

import importlib.util
import math
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from slider_drilling.messages.cdr import FRAME_ID
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes.run_node import NODES


@pytest.fixture
def urdf(repository: Path) -> ElementTree.Element:
    return ElementTree.parse(repository / "config" / "urdf" / "rig.urdf").getroot()


def test_urdf_has_the_messages_frame_and_joints(urdf):
    links = {link.get("name") for link in urdf.findall("link")}
    assert {FRAME_ID, "top_drive", "block", "bit"} <= links
    moving = {joint.get("name") for joint in urdf.findall("joint") if joint.get("type") != "fixed"}
    assert moving == {TOPICS[name].joint for name in ("top_drive", "draw_works", "truth_bit")}


def test_urdf_is_one_tree_from_the_map(urdf):
    parents = {joint.find("child").get("link"): joint.find("parent").get("link") for joint in urdf.findall("joint")}
    links = {link.get("name") for link in urdf.findall("link")}
    assert links - set(parents) == {"map"} and set(parents.values()) <= links


def test_urdf_axes_point_down_the_hole(urdf):
    """The floor's frame is turned over, so that its z points down; every joint moves along or about it."""
    floor = next(joint for joint in urdf.findall("joint") if joint.find("child").get("link") == FRAME_ID)
    assert [float(angle) for angle in floor.find("origin").get("rpy").split()] == pytest.approx([math.pi, 0.0, 0.0])
    for joint in urdf.findall("joint"):
        if joint is not floor:
            assert joint.find("axis").get("xyz") == "0 0 1", joint.get("name")


def test_every_reporting_node_has_a_group(repository):
    text = (repository / "config" / "diagnostic_aggregator.yaml").read_text()
    analyzers = yaml.safe_load(text)["/**"]["ros__parameters"]["analyzers"]
    found = [name for analyzer in analyzers.values() for name in analyzer["contains"]]
    assert sorted(found) == sorted(f"{name}: " for name in NODES if name != "dashboard")


def test_pressure_is_said_to_be_gauge(repository):
    assert "gauge" in TOPICS["standpipe_pressure"].content
    assert "**gauge** pressure" in (repository / "docs" / "how_to" / "nodes.md").read_text()


@pytest.mark.parametrize(
    ("name", "programs"),
    [
        ("rviz", {"joint_state_publisher", "robot_state_publisher", "rviz2"}),
        ("diagnostics", {"aggregator_node"}),
        ("managed", {"friction_simulator", "rocking_controller", "recorder", "lifecycle_manager"}),
    ],
)
def test_launch_files_for_foreign_nodes_describe_them(name, programs, repository):
    launch = pytest.importorskip("launch")
    actions = pytest.importorskip("launch_ros.actions")
    spec = importlib.util.spec_from_file_location("under_test", repository / "launch" / f"{name}.launch.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    context = launch.LaunchContext()
    description = module.generate_launch_description()
    for one in description.entities:
        if isinstance(one, launch.actions.DeclareLaunchArgument):
            context.launch_configurations[one.name] = ""
    (made,) = [one for one in description.entities if isinstance(one, launch.actions.OpaqueFunction)]
    nodes = [one for one in made.execute(context) if isinstance(one, actions.Node)]
    assert {node.node_executable for node in nodes} == programs
