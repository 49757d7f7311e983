"""Arguments of a node that runs alone."""

import pytest

from slider_drilling.nodes.run_node import own_clock


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], []),
        (["--ros-args", "-r", "__ns:=/"], []),
        (["--ros-args", "-r", "__ns:=/rig_a"], ["--ros-args", "-r", "/clock:=/rig_a/clock"]),
        (["--ros-args", "--remap", "recorder:__ns:=/field/rig_a"], ["--ros-args", "-r", "/clock:=/field/rig_a/clock"]),
        (["--ros-args", "-r", "__ns:=/rig_a", "-r", "/clock:=/clock"], []),
    ],
)
def test_namespace_remaps_the_clock(arguments, expected):
    assert own_clock(["recorder", *arguments]) == expected
