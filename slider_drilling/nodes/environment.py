"""Prepares the environment for rclpy: shared libraries, share folders, discovery within this machine."""

from __future__ import annotations

import importlib.util
import os
import signal
import sys
import tempfile
from collections.abc import Mapping, MutableMapping
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file

LOOPBACK = "config/loopback.xml"  # a profile of Fast DDS
MAX_DOMAIN = 231  # domain 232 has no ports for the 64 programs that config/loopback.xml lets DDS look for
WHEELS_RMW = "rmw_fastrtps_cpp"
DISCOVERY_RANGES = ("OFF", "LOCALHOST", "SUBNET", "SYSTEM_DEFAULT")
INSTALL = "install it with `pip install 'slider_drilling[ros]'`, or source a ROS 2 Jazzy (setup.bash)"
SIGNALS = (signal.SIGINT, signal.SIGTERM)
RESTARTED_VARIABLE = "SLIDER_DRILLING_RESTARTED"  # the LD_LIBRARY_PATH with which a process has restarted itself
# Set by the wheels once LD_LIBRARY_PATH is theirs; child processes inherit it, whichever environment they belong to.
WHEELS_VARIABLE = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"


def prepare() -> None:
    """Make `import rclpy` work in this process. Call it before any import of ROS, and so before `rclpy.init`.

    A sourced ROS 2 takes precedence over the wheels of this Python environment. If LD_LIBRARY_PATH belongs to another
    environment, the process restarts itself with the right one, since the dynamic linker reads it at the start. DDS
    stays on this machine unless ROS_AUTOMATIC_DISCOVERY_RANGE is set.

    Raises:
        InputError: ROS 2 is missing, or an environment variable cannot be used.
    """
    if RESTARTED_VARIABLE in os.environ:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
    spec = importlib.util.find_spec("rclpy")
    if spec is None or spec.origin is None:
        raise InputError(f"ROS 2 is not installed: Python at {sys.prefix} has no rclpy; {INSTALL}")
    set_log_folder(os.environ)
    check_domain(os.environ)
    restrict_to_loopback(os.environ)
    wanted = library_path(os.environ.get("LD_LIBRARY_PATH", ""), from_wheels=_within(Path(spec.origin), sys.prefix))
    if wanted is not None:
        restart({"LD_LIBRARY_PATH": wanted})
    if _within(Path(spec.origin), sys.prefix):
        check_middleware(os.environ)
    add_share_folders(os.environ, Path(spec.origin))


def add_share_folders(variables: MutableMapping[str, str], rclpy: Path) -> None:
    """Make ROS find the message packages of the wheels, if its `rclpy` is theirs; of a sourced ROS 2 it does."""
    prefixes = variables.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    if _within(rclpy, sys.prefix) and sys.prefix not in prefixes:
        variables["AMENT_PREFIX_PATH"] = os.pathsep.join([sys.prefix, *filter(None, prefixes)])


def open_to_others(variables: Mapping[str, str]) -> str:
    """Why DDS listens on every interface although nobody asked for it, and what to do; empty where that is not so."""
    if variables.get("ROS_AUTOMATIC_DISCOVERY_RANGE") or variables.get("ROS_LOCALHOST_ONLY") == "1":
        return ""
    return (
        "everyone in this network can read and command the rig: this program has not called "
        "slider_drilling.nodes.environment.prepare() before rclpy.init(); call it, or set ROS_AUTOMATIC_DISCOVERY_RANGE"
    )


def set_log_folder(variables: MutableMapping[str, str]) -> None:
    """Set a folder for the logs of ROS 2 if no home folder is set; ROS 2 would not start without one."""
    if not any(variables.get(name) for name in ("HOME", "ROS_HOME", "ROS_LOG_DIR")):
        variables["ROS_LOG_DIR"] = str(Path(tempfile.gettempdir()) / f"slider_drilling_ros_{os.getuid()}")


def check_domain(variables: Mapping[str, str]) -> None:
    """Raises InputError for a ROS_DOMAIN_ID whose ports do not exist, with which Fast DDS ends the process."""
    given = variables.get("ROS_DOMAIN_ID", "")
    if given and not (given.isdecimal() and int(given[:9]) <= MAX_DOMAIN):
        raise InputError(f"ROS_DOMAIN_ID = {given!r}: must be a whole number from 0 to {MAX_DOMAIN}")


def check_middleware(variables: Mapping[str, str]) -> None:
    """Raises InputError for an RMW_IMPLEMENTATION that the wheels lack, with which ROS 2 exits with code 102."""
    given = variables.get("RMW_IMPLEMENTATION") or WHEELS_RMW
    if given != WHEELS_RMW:
        raise InputError(f"RMW_IMPLEMENTATION = {given!r}: the wheels only have {WHEELS_RMW}; unset it")


def restrict_to_loopback(variables: MutableMapping[str, str]) -> None:
    """Make DDS open sockets on the loopback interface only, unless environment variables ask for more.

    With the range LOCALHOST, ROS 2 restricts discovery to this machine, but its sockets listen on every interface. A
    Fast DDS profile restricts the sockets too. The range must then be SYSTEM_DEFAULT, because ROS 2 would otherwise add
    settings that open the other interfaces again.

    Raises:
        InputError: The range is one that ROS 2 does not know; it would silently use another.
    """
    reach = variables.get("ROS_AUTOMATIC_DISCOVERY_RANGE") or "LOCALHOST"
    if reach not in DISCOVERY_RANGES:
        raise InputError(f"ROS_AUTOMATIC_DISCOVERY_RANGE = {reach!r}: must be one of {', '.join(DISCOVERY_RANGES)}")
    if reach != "LOCALHOST":
        return
    variables["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    profile = str(installed_file(LOOPBACK))
    given = {variables.get(f"{name}_DEFAULT_PROFILES_FILE", profile) for name in ("FASTRTPS", "FASTDDS")}
    if given != {profile} or not variables.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp").startswith("rmw_fastrtps"):
        return
    variables["FASTRTPS_DEFAULT_PROFILES_FILE"] = profile
    variables["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SYSTEM_DEFAULT"


def library_path(present: str, from_wheels: bool) -> str | None:
    """The LD_LIBRARY_PATH that rclpy needs; None if the present one is right.

    With the wheels, this environment's libraries must come first; with a sourced ROS 2 they must be absent.
    """
    parts = [part for part in present.split(os.pathsep) if part]
    own = _wheel_libraries()
    others = [part for part in parts if part not in own]
    if not from_wheels:
        return os.pathsep.join(others) if len(others) < len(parts) else None
    first = parts[: len(own)]
    return None if set(first) == set(own) else os.pathsep.join([*own, *others])


def _wheel_libraries() -> list[str]:
    """The folders of the shared libraries of this environment's ROS wheels."""
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    site = Path(sys.prefix) / "lib" / version / "site-packages"
    return [str(Path(sys.prefix) / "lib"), *sorted(str(found.resolve()) for found in site.glob("ros_*.libs"))]


def _within(path: Path, folder: str) -> bool:
    return Path(folder).resolve() in path.resolve().parents


def restart(changes: dict[str, str]) -> None:
    """Restart this process with another LD_LIBRARY_PATH. Raises InputError if a restart with it did not help."""
    if os.environ.get(RESTARTED_VARIABLE) == changes["LD_LIBRARY_PATH"]:
        raise InputError(f"LD_LIBRARY_PATH: could not be set for {sys.executable}; unset it and try again")
    environment = {**os.environ, **changes, WHEELS_VARIABLE: "1", RESTARTED_VARIABLE: changes["LD_LIBRARY_PATH"]}
    sys.stdout.flush()
    sys.stderr.flush()
    # Block signals until the restarted process can handle them; `prepare` unblocks them.
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], environment)
