"""The nodes' reference pages list their topics, services and parameters with types, units and ranges."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
import rclpy
from rcl_interfaces.srv import DescribeParameters, ListParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from slider_drilling.log import LogWriter
from slider_drilling.nodes import friction_simulator, log_player, opcua_bridge, recorder, rocking_controller, twin
from slider_drilling.nodes.controller_settings import settings_parameters
from slider_drilling.nodes.parameters import NodeParameter
from slider_drilling.nodes.shutdown import ShutdownRequest

MODULES = {
    "friction_simulator": (friction_simulator, friction_simulator.FrictionSimulator),
    "rocking_controller": (rocking_controller, rocking_controller.RockingController),
    "recorder": (recorder, recorder.Recorder),
    "log_player": (log_player, log_player.LogPlayer),
    "twin": (twin, twin.TwinNode),
    "opcua_bridge": (opcua_bridge, opcua_bridge.OpcuaBridge),
}
# Every node has these; parameters and lifecycles are ROS 2's own to describe.
COMMON = {"/parameter_events", "/rosout"}
SERVICES_OF_ROS = re.compile(r"/(\w+_parameters?(_\w+)?|get_\w+|change_state)$")
KINDS = {str: "text", bool: "bool", int: "int", float: "float", list: "texts"}


def rows(page: str, heading: str) -> list[list[str]]:
    """The cells of a section's table, code marks taken off."""
    section = page[page.index(f"\n## {heading}") + 1 :].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")][2:]
    return [[cell.strip().strip("`") for cell in line.strip("|").split("|")] for line in lines]


def described(parameter: NodeParameter) -> list[str]:
    """A parameter as its page has it, but for the default."""
    is_number = isinstance(parameter.default, (int, float)) and not isinstance(parameter.default, bool)
    limits = f"{parameter.low:g} to {parameter.high:g}" if is_number else ""
    return [
        parameter.name,
        KINDS[type(parameter.default)],
        parameter.unit,
        limits,
        "yes" if parameter.live else "",
        parameter.description,
    ]


def default_of(cell: str, parameter: NodeParameter) -> object:
    """A page's default as a value."""
    if cell == "empty":
        return type(parameter.default)([""]) if isinstance(parameter.default, list) else ""
    return cell == "true" if isinstance(parameter.default, bool) else type(parameter.default)(cell)


def check_parameters(listed: list[list[str]], parameters: list[NodeParameter]) -> None:
    assert [[*row[:2], *row[3:]] for row in listed] == [described(one) for one in parameters]
    assert [default_of(row[2], one) for row, one in zip(listed, parameters, strict=True)] == [
        one.default for one in parameters
    ]


@pytest.fixture(params=MODULES)
def node(request, alone, tmp_path, repository) -> Node:
    if request.param == "opcua_bridge":
        pytest.importorskip("asyncua", reason="no asyncua: pip install '.[bridge]'")
    log = tmp_path / "played.mcap"
    with LogWriter(log) as writer:
        writer.joint_state("top_drive/joint_states", 0.0, "top_drive", 0.0, 0.0, 0.0)
    given = {
        "friction_simulator": {"elements": 20},
        "recorder": {"directory": str(tmp_path / "bag")},
        "log_player": {"log": str(log)},
        "opcua_bridge": {"mapping": str(repository / "config" / "opcua_rig.example.yaml"), "command": True},
    }.get(request.param, {})
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    made = MODULES[request.param][1](
        ShutdownRequest(), parameter_overrides=[Parameter(name, value=value) for name, value in given.items()]
    )
    yield made
    if isinstance(made, recorder.Recorder):
        made.discard()
    made.destroy_node()
    rclpy.try_shutdown()


def test_reference_page_lists_parameters_services_and_topics(node, repository):
    name = node.get_name()
    page = (repository / "docs" / "reference" / "nodes" / f"{name}.md").read_text()
    check_parameters(rows(page, "Parameters"), list(type(node).PARAMETERS))
    services = {
        (f"~/{topic.rpartition('/')[2]}", kinds[0].replace("/srv/", "/"))
        for topic, kinds in node.get_service_names_and_types_by_node(name, "/")
        if not SERVICES_OF_ROS.search(topic)
    }
    assert {(row[0], row[1]) for row in rows(page, "Services")} == services
    if name == "log_player":
        return  # its topics are the log's
    if isinstance(node, recorder.Recorder):
        node.subscribe_to_top_drive()
    if isinstance(node, rocking_controller.RockingController):
        node._commands.make()
        settings = rows(page, "Settings of SlideController")
        check_parameters(settings, settings_parameters(node.settings))
    topics = {
        (topic if topic == "/clock" else topic[1:], way, kinds[0].replace("/msg/", "/"))
        for way, found in (
            ("publishes", node.get_publisher_names_and_types_by_node(name, "/")),
            ("listens to", node.get_subscriber_names_and_types_by_node(name, "/")),
        )
        for topic, kinds in found
        if topic not in COMMON and not topic.endswith("/transition_event")
    }
    assert {tuple(row[:3]) for row in rows(page, "Topics") if row[0] != "/diagnostics"} == topics


def test_security_policy_allows_exactly_the_nodes_interfaces(node, repository):
    name = node.get_name()
    root = ElementTree.parse(repository / "config" / "security" / "policy.xml").getroot()
    (profile,) = root.findall(f"enclaves/enclave[@path='/slider_drilling/{name}']/profiles/profile")
    assert (profile.get("ns"), profile.get("node")) == ("/", name)

    def allowed(kind: str, way: str) -> set[str]:
        found = profile.findall(f"{kind}s[@{way}='ALLOW']/{kind}")
        return {f"/{name}{one.text[1:]}" if one.text.startswith("~") else f"/{one.text}" for one in found}

    def topics(found: list[tuple[str, list[str]]]) -> set[str]:
        return {topic for topic, _ in found}

    assert not profile.findall(".//*[@request]") and len(profile) == 3
    assert allowed("service", "reply") == topics(node.get_service_names_and_types_by_node(name, "/"))
    if name == "log_player":
        return  # its topics are the log's, and a rig's samples where it plays commands to one
    if isinstance(node, recorder.Recorder):
        node.subscribe_to_top_drive()
    if isinstance(node, rocking_controller.RockingController):
        node._commands.make()
    timed = set() if name in ("friction_simulator", "opcua_bridge") else {"/clock"}  # use_sim_time
    assert allowed("topic", "publish") == topics(node.get_publisher_names_and_types_by_node(name, "/"))
    assert allowed("topic", "subscribe") == topics(node.get_subscriber_names_and_types_by_node(name, "/")) | timed


COMMANDS = {"draw_works/command", "mud_pump/command", "top_drive/command"}


def published(repository: Path, enclave: str) -> set[str | None]:
    """Topics that an enclave may publish."""
    root = ElementTree.parse(repository / "config" / "security" / "policy.xml").getroot()
    found = root.findall(f"enclaves/enclave[@path='/slider_drilling/{enclave}']//topics[@publish='ALLOW']/topic")
    assert found
    return {topic.text for topic in found}


def test_player_may_command_in_one_enclave_only(repository: Path):
    assert not published(repository, "log_player") & COMMANDS
    ros = {"diagnostics", "parameter_events", "rosout", "~/transition_event"}
    assert published(repository, "log_player_commands") == COMMANDS | ros


def test_dashboard_may_use_exactly_its_interfaces(alone, repository, monkeypatch):
    pytest.importorskip("nicegui", reason="no NiceGUI: pip install '.[live]'")
    from slider_drilling.live.page_requests import DiagnoseNow, SetRecording, SetRocking, SetTarget
    from slider_drilling.nodes import dashboard

    class NoServer:
        url, token = "", None

        def __init__(self, *arguments: object) -> None:
            pass

        def stop(self) -> None:
            pass

    monkeypatch.setattr(dashboard, "PageServer", NoServer)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = dashboard.Dashboard(ShutdownRequest())
    switches = [kind(on) for kind in (SetRocking, SetRecording) for on in (True, False)]
    for request in (SetTarget(0.0), DiagnoseNow(), *switches):
        node.requests.put(request)
    node._serve_requests()
    node._read_parameters()
    for name in dashboard.ADJUSTABLE_NODES:
        node._on_names(name, _Done(ListParameters.Response()))
        node._on_descriptors(name, _Done(DescribeParameters.Response()))
        node._set_parameter(name, "gain", 1.0, "")
    root = ElementTree.parse(repository / "config" / "security" / "policy.xml").getroot()
    (profile,) = root.findall("enclaves/enclave[@path='/slider_drilling/dashboard']/profiles/profile")

    def allowed(kind: str, way: str) -> set[str]:
        found = profile.findall(f"{kind}s[@{way}='ALLOW']/{kind}")
        return {f"/dashboard{one.text[1:]}" if one.text.startswith("~") else f"/{one.text}" for one in found}

    def names(found: list[tuple[str, list[str]]]) -> set[str]:
        return {name for name, _ in found}

    own = ("dashboard", "/")
    assert allowed("topic", "publish") == names(node.get_publisher_names_and_types_by_node(*own))
    assert allowed("topic", "subscribe") == names(node.get_subscriber_names_and_types_by_node(*own)) | {"/clock"}
    assert allowed("service", "reply") == names(node.get_service_names_and_types_by_node(*own))
    assert allowed("service", "request") == names(node.get_client_names_and_types_by_node(*own))
    node.destroy_node()
    rclpy.try_shutdown()


class _Done:
    """A future with its result."""

    def __init__(self, result: object) -> None:
        self.result = lambda: result


def test_every_node_has_a_linked_page(repository: Path):
    text = (repository / "docs" / "how_to" / "nodes.md").read_text()
    for name in MODULES:
        assert f"nodes/{name}.md)" in text
