"""Controller and recorder for a real rig, on the wall clock; a bridge publishes the rig's measurements.

    ros2 launch slider_drilling real_rig.launch.py rig:=rig.yaml record:=out target_deg:=45
"""

from launch import LaunchDescription, LaunchDescriptionEntity

from slider_drilling.nodes.launch_helpers import (
    LaunchArguments,
    dashboard,
    description,
    process,
    run_together,
    target,
    twin,
)


def real_rig(given: LaunchArguments) -> list[LaunchDescriptionEntity]:
    """The controller and, where a folder is given, the recorder; of recorder, page and twin none stops another."""
    controller = process("rocking_controller", given, {"use_sim_time": False}, {
        "rig": given["rig"], "tool_face_target": target(given), "controller": given["controller"],
        "programme": given.get("programme", "")})
    observers = dashboard(given) + twin(given, False, given["rig"])
    if given["record"]:
        observers.append(process("recorder", given, {"use_sim_time": False}, {
            "rig": given["rig"], "directory": given["record"], "programme": given.get("programme", "")}))
    return run_together(ending=[], required=[controller], optional=observers)


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` asks for."""
    return description(
        ("rig", "target_deg", "controller", "programme", "record", "dashboard", "twin", "namespace", "parameters",
         "respawn", "discovery"), real_rig)
