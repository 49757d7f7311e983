"""Friction simulator, rocking controller and recorder, a process each.

    ros2 launch slider_drilling rocking.launch.py rig:=rig.yaml duration:=300 speed:=1 record:=out target_deg:=45
"""

import math

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, RegisterEventHandler, Shutdown
from launch.event_handlers import OnProcessExit
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = "slider_drilling"
ARGUMENTS = {
    "rig": ("", "rig file; empty: the 4 km example well"),
    "duration": ("0.0", "simulated time, s; 0: until interrupted"),
    "speed": ("1.0", "simulated seconds a second; 0 or max: as fast as possible, in lockstep"),
    "target_deg": ("0.0", "tool-face to hold, deg"),
    "controller": ("", "controller as module:Class; empty: this package's own"),
    "record": ("", "folder for the log; empty: no recorder"),
    "namespace": ("", "namespace of every topic"),
    "parameters": ("", "YAML file with further node parameters"),
}


def nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """The processes that the arguments ask for; all end with the simulator."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    speed = 0.0 if given["speed"] == "max" else float(given["speed"])
    further = [given["parameters"]] if given["parameters"] else []
    target = math.remainder(math.radians(float(given["target_deg"])), 2.0 * math.pi)

    def node(name: str, **parameters: object) -> Node:
        return Node(package=PACKAGE, executable=name, name=name, namespace=given["namespace"], output="screen",
                    parameters=[parameters, *further])

    simulator = node("friction_simulator", rig=given["rig"], speed=speed, duration=float(given["duration"]),
                     wait_for_controller=True, minimum_subscribers=2 if given["record"] else 1)
    own = {"controller": given["controller"]} if given["controller"] else {}
    controller = node("rocking_controller", rig=given["rig"], tool_face_target=target, use_sim_time=True, **own)
    started = [simulator, controller]
    if given["record"]:
        started.append(node("recorder", directory=given["record"], rig=given["rig"], use_sim_time=True))
    ended = [RegisterEventHandler(OnProcessExit(target_action=one, on_exit=[Shutdown(reason="a node has ended")]))
             for one in started]
    return [*ended, *started]


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` asks for."""
    declared = [DeclareLaunchArgument(name, default_value=default, description=text)
                for name, (default, text) in ARGUMENTS.items()]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])
