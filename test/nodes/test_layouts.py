"""The layouts for Foxglove and PlotJuggler: each of their paths exists in a recorded run."""

from __future__ import annotations

import json
import math
import os
import re
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from typing import Any

import pytest
from mcap.reader import make_reader

from slider_drilling.files.installed_files import installed_file
from slider_drilling.nodes.session import SessionOptions, run_session

DecoderFactory = pytest.importorskip("mcap_ros2.decoder").DecoderFactory

# Functions of Foxglove's message paths, and how its layouts write them.
FUNCTIONS = {
    "degrees": lambda value: math.degrees(value),
    "div": lambda value, by: value / by,
    "mul": lambda value, by: value * by,
}
SANE = {"kN m": (-20.0, 20.0), "kN": (-1.0, 600.0), "bar": (150.0, 250.0), "deg": (-720.0, 720.0), "m/h": (-40.0, 60.0)}


@pytest.fixture(scope="module")
def messages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    """Every message of a slide of 40 s beside a twin, decoded, by topic."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
        patch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
        outcome = run_session(
            SessionOptions(duration=40.0, record=tmp_path_factory.mktemp("log"), target=0.3, elements=20, twin=True)
        )
    assert outcome.log is not None
    found = defaultdict(list)
    with outcome.log.open("rb") as file:
        for one in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            found[one.channel.topic].append(one.decoded_message)
    return dict(found)


def looked_up(path: str, messages: dict[str, list[Any]]) -> list[float]:
    """The numbers that a message path of Foxglove's gives."""
    topic, *steps = re.split(r"\.(?![0-9])", path)
    values = messages[topic]
    for step in steps:
        function = re.fullmatch(r"@(\w+)(?:\(([\d.]+)\))?", step)
        field = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", step)
        if function:
            given = [float(one) for one in function.groups()[1:] if one]
            values = [FUNCTIONS[function[1]](value, *given) for value in values]
        else:
            assert field is not None, step
            values = [getattr(value, field[1]) for value in values]
            values = values if field[2] is None else [value[int(field[2])] for value in values]
    return values


def curve_of(name: str, messages: dict[str, list[Any]]) -> list[float]:
    """The numbers of a PlotJuggler series: a joint's are called topic/joint/quantity, any other's topic/field/..."""
    topic = max((topic for topic in messages if name.startswith(f"{topic}/")), key=len)
    steps = name[len(topic) + 1 :].split("/")
    found = []
    for value in messages[topic]:
        if hasattr(value, "effort"):
            joint, quantity = steps
            found.append(getattr(value, quantity)[value.name.index(joint)])
        else:
            for step in steps:
                value = getattr(value, step)
            found.append(value)
    return found


def assert_sane(values: list[float], label: str) -> None:
    if "noise levels" in label or label.startswith("/gap"):
        values = [value for value in values if not math.isnan(value)]  # a channel without a gap so far
    assert values and all(math.isfinite(value) for value in values), label
    unit = re.search(r", ([^,()]+)$", label)
    if unit and unit[1] in SANE:
        low, high = SANE[unit[1]]
        assert low <= min(values) <= max(values) <= high, (label, min(values), max(values))


def test_foxglove_layout_shows_logged_fields_with_units(messages: dict[str, list[Any]]) -> None:
    layout = json.loads(installed_file("config/foxglove_layout.json").read_text())
    plots = [panel for name, panel in layout["configById"].items() if name.startswith("Plot!")]
    assert len(plots) >= 8
    for plot in plots:
        for path in plot["paths"]:
            label = path["label"] if "," in path["label"] and " k" in path["label"] else plot["title"].split(", sim")[0]
            assert_sane(looked_up(path["value"], messages), label)


def test_foxglove_gauges_cover_their_readings(messages: dict[str, list[Any]]) -> None:
    layout = json.loads(installed_file("config/foxglove_layout.json").read_text())
    gauges = [panel for name, panel in layout["configById"].items() if name.startswith("Gauge!")]
    assert len(gauges) == 3
    for gauge in gauges:
        readings = looked_up(gauge["path"], messages)
        assert gauge["minValue"] <= min(readings) <= max(readings) <= gauge["maxValue"]
        assert max(map(abs, readings)) > 0.01 * gauge["maxValue"]
    assert layout["configById"]["DiagnosticSummary!health"]["topicToRender"] in messages


def test_foxglove_layout_places_every_panel_once() -> None:
    layout = json.loads(installed_file("config/foxglove_layout.json").read_text())
    placed = re.findall(r'"(\w+!\w+)"', json.dumps(layout["layout"]))
    assert sorted(placed) == sorted(layout["configById"])


def test_plotjuggler_layout_shows_logged_fields_with_units(messages: dict[str, list[Any]]) -> None:
    root = ElementTree.parse(installed_file("config/plotjuggler_layout.xml")).getroot()
    made = {}
    for snippet in root.iter("snippet"):
        function = re.fullmatch(r"return value ([/*]) ([\d.]+)", snippet.findtext("function", ""))
        assert function is not None
        factor = float(function[2]) if function[1] == "*" else 1.0 / float(function[2])
        source = curve_of(snippet.findtext("linked_source", ""), messages)
        made[snippet.get("name")] = [factor * value for value in source]
    curves = [curve.get("name", "") for curve in root.iter("curve")]
    assert len(curves) > 10 and set(made) <= set(curves)
    for name in curves:
        assert_sane(made[name] if name in made else curve_of(name, messages), name)
    for splitter in root.iter("DockSplitter"):
        assert int(splitter.get("count", "0")) == len(list(splitter)) == len(splitter.get("sizes", "").split(";"))
