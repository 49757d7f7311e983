"""The environment that ROS needs: shared libraries, domain, discovery. Runs without ROS."""

import os
import sys

import pytest

from slider_drilling.errors import InputError
from slider_drilling.nodes import environment


@pytest.fixture
def own(tmp_path, monkeypatch):
    """The library folders of an environment with ROS wheels."""
    site = tmp_path / "lib" / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"
    for name in ("ros_rcl.libs", "ros_rclpy.libs", "numpy.libs"):
        (site / name).mkdir(parents=True)
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    return [str(tmp_path / "lib"), str(site / "ros_rcl.libs"), str(site / "ros_rclpy.libs")]


def test_own_libraries_are_accepted_in_any_order(own):
    assert environment.library_path(os.pathsep.join(reversed(own)), from_wheels=True) is None
    assert environment.library_path(os.pathsep.join([*own, "/opt/cuda/lib"]), from_wheels=True) is None


@pytest.mark.parametrize("inherited", ["", "/other/venv/lib", "/other/venv/lib:/other/venv/lib/ros_rcl.libs"])
def test_libraries_of_other_environments_come_last(own, inherited):
    expected = [*own, *filter(None, inherited.split(os.pathsep))]
    assert environment.library_path(inherited, from_wheels=True) == os.pathsep.join(expected)


def test_sourced_ros_excludes_the_wheels(own):
    assert environment.library_path("/opt/ros/jazzy/lib", from_wheels=False) is None
    mixed = os.pathsep.join([own[0], "/opt/ros/jazzy/lib", own[2]])
    assert environment.library_path(mixed, from_wheels=False) == "/opt/ros/jazzy/lib"


def test_missing_rclpy_is_one_line(monkeypatch):
    monkeypatch.setattr(environment.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'slider_drilling\[ros\]'.*source a ROS 2 Jazzy"):
        environment.prepare()


def test_process_restarts_only_once(own, monkeypatch):
    monkeypatch.setenv("SLIDER_DRILLING_RESTARTED", "/wanted")
    with pytest.raises(InputError, match="LD_LIBRARY_PATH"):
        environment.restart({"LD_LIBRARY_PATH": "/wanted"})


@pytest.mark.parametrize("domain", ["232", "9999", "-1", "x", "1.0", "9" * 5000])
def test_domain_without_ports_is_refused(domain):
    with pytest.raises(InputError, match=r"ROS_DOMAIN_ID = .*: must be a whole number from 0 to 231"):
        environment.check_domain({"ROS_DOMAIN_ID": domain})
    for good in ("0", "231", ""):
        environment.check_domain({"ROS_DOMAIN_ID": good})


@pytest.mark.parametrize("homeless", [{}, {"HOME": ""}, {"HOME": "", "ROS_LOG_DIR": ""}])
def test_log_folder_is_set_without_home(homeless):
    variables = dict(homeless)
    environment.set_log_folder(variables)
    assert "slider_drilling_ros_" in variables["ROS_LOG_DIR"]
    for housed in ({"HOME": "/home/a"}, {"HOME": "", "ROS_HOME": "/ros"}):
        left = dict(housed)
        environment.set_log_folder(left)
        assert left == housed


def test_missing_middleware_is_refused():
    with pytest.raises(InputError, match=r"RMW_IMPLEMENTATION = 'rmw_nope': the wheels only have rmw_fastrtps_cpp"):
        environment.check_middleware({"RMW_IMPLEMENTATION": "rmw_nope"})
    for good in ({}, {"RMW_IMPLEMENTATION": ""}, {"RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"}):
        environment.check_middleware(good)


@pytest.mark.parametrize("reach", ["localhost", "SUBNETS", "MOON"])
def test_unknown_discovery_range_is_refused(reach):
    with pytest.raises(InputError, match=f"ROS_AUTOMATIC_DISCOVERY_RANGE = '{reach}': must be one of OFF, LOCALHOST"):
        environment.restrict_to_loopback({"ROS_AUTOMATIC_DISCOVERY_RANGE": reach})


def test_dds_uses_loopback_unless_the_user_decides():
    variables = {}
    environment.restrict_to_loopback(variables)
    assert variables["FASTRTPS_DEFAULT_PROFILES_FILE"].endswith("config/loopback.xml")
    assert variables["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SYSTEM_DEFAULT"
    inherited = variables | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    environment.restrict_to_loopback(inherited)
    assert inherited == variables
    for wider in ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}):
        left = dict(wider)
        environment.restrict_to_loopback(left)
        assert left == wider
    for other in ({"FASTRTPS_DEFAULT_PROFILES_FILE": "mine.xml"}, {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}):
        left = dict(other)
        environment.restrict_to_loopback(left)
        assert left == other | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
