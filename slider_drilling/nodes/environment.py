"""Makes ready what rclpy needs of the environment: libraries, share folders, discovery within this machine."""

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
LAST_DOMAIN = 231  # of 232 the ports of 64 programs, which config/loopback.xml has DDS knock at, do not exist
WHEELS_RMW = "rmw_fastrtps_cpp"
RANGES = ("OFF", "LOCALHOST", "SUBNET", "SYSTEM_DEFAULT")  # how far ROS 2 looks for others
INSTALL = "install it with `pip install 'slider_drilling[ros]'`, or source a ROS 2 Jazzy (setup.bash)"
# The wheels' own mark that LD_LIBRARY_PATH is theirs; children inherit it, whichever environment they belong to.
TRIED = "SLIDER_DRILLING_RESTARTED"  # holds the LD_LIBRARY_PATH that a process has started itself again with
SIGNALS = (signal.SIGINT, signal.SIGTERM)
BOOTSTRAPPED = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"


def prepare() -> None:
    """Make `import rclpy` and what follows work in this process, or raise InputError saying what is missing.

    A sourced ROS 2 is taken before the wheels of this Python environment. The dynamic linker reads
    LD_LIBRARY_PATH when a process starts, so where it belongs to another environment the process starts itself
    again with the right one. DDS stays on this machine unless ROS_AUTOMATIC_DISCOVERY_RANGE says otherwise.
    """
    if TRIED in os.environ:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
    spec = importlib.util.find_spec("rclpy")
    if spec is None or spec.origin is None:
        raise InputError(f"ROS 2 is not there: Python at {sys.prefix} has no rclpy; {INSTALL}")
    give_logs_a_place(os.environ)
    check_domain(os.environ)
    keep_to_loopback(os.environ)
    wanted = library_path(os.environ.get("LD_LIBRARY_PATH", ""), from_wheels=_within(Path(spec.origin), sys.prefix))
    if wanted is not None:
        _start_again({"LD_LIBRARY_PATH": wanted})
    if _within(Path(spec.origin), sys.prefix):
        check_middleware(os.environ)
        prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
        if sys.prefix not in prefixes:
            os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join([sys.prefix, *filter(None, prefixes)])


def give_logs_a_place(variables: MutableMapping[str, str]) -> None:
    """Name a folder for the logs of ROS 2, which refuses to start without, where no home names one."""
    if not any(variables.get(name) for name in ("HOME", "ROS_HOME", "ROS_LOG_DIR")):
        variables["ROS_LOG_DIR"] = str(Path(tempfile.gettempdir()) / f"slider_drilling_ros_{os.getuid()}")


def check_domain(variables: Mapping[str, str]) -> None:
    """Raises InputError for a ROS_DOMAIN_ID whose ports do not exist: Fast DDS would end the process."""
    given = variables.get("ROS_DOMAIN_ID", "")
    if given and not (given.isdecimal() and int(given[:9]) <= LAST_DOMAIN):
        raise InputError(f"ROS_DOMAIN_ID = {given!r}: must be a whole number within 0 to {LAST_DOMAIN}")


def check_middleware(variables: Mapping[str, str]) -> None:
    """Raises InputError for an RMW_IMPLEMENTATION that the wheels do not hold: ROS 2 would end the process with 102."""
    given = variables.get("RMW_IMPLEMENTATION") or WHEELS_RMW
    if given != WHEELS_RMW:
        raise InputError(f"RMW_IMPLEMENTATION = {given!r}: the wheels hold {WHEELS_RMW} alone; unset it")


def keep_to_loopback(variables: MutableMapping[str, str]) -> None:
    """Have DDS open sockets on the loopback interface alone, unless the variables of the environment say otherwise.

    With LOCALHOST ROS 2 keeps discovery to this machine, but its sockets listen on every interface. With a profile of
    Fast DDS they do not; what ROS 2 adds to it would open the others again, and SYSTEM_DEFAULT keeps that out. Raises
    InputError for a range that ROS 2 does not know, and would take for another.
    """
    reach = variables.get("ROS_AUTOMATIC_DISCOVERY_RANGE") or "LOCALHOST"
    if reach not in RANGES:
        raise InputError(f"ROS_AUTOMATIC_DISCOVERY_RANGE = {reach!r}: must be one of {', '.join(RANGES)}")
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
    """The LD_LIBRARY_PATH that rclpy needs, None where the present one will do.

    With the wheels, this environment's libraries must come before any other's; with a sourced ROS 2 they must
    not come at all.
    """
    parts = [part for part in present.split(os.pathsep) if part]
    own = _wheel_libraries()
    others = [part for part in parts if part not in own]
    if not from_wheels:
        return os.pathsep.join(others) if len(others) < len(parts) else None
    first = parts[: len(own)]
    return None if set(first) == set(own) else os.pathsep.join([*own, *others])


def _wheel_libraries() -> list[str]:
    """Where the ROS wheels of this environment keep their shared libraries."""
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    site = Path(sys.prefix) / "lib" / version / "site-packages"
    return [str(Path(sys.prefix) / "lib"), *sorted(str(found.resolve()) for found in site.glob("ros_*.libs"))]


def _within(path: Path, folder: str) -> bool:
    return Path(folder).resolve() in path.resolve().parents


def _start_again(changes: dict[str, str]) -> None:
    if os.environ.get(TRIED) == changes["LD_LIBRARY_PATH"]:
        raise InputError(f"LD_LIBRARY_PATH: could not be set for {sys.executable}; unset it and try again")
    environment = {**os.environ, **changes, BOOTSTRAPPED: "1", TRIED: changes["LD_LIBRARY_PATH"]}
    sys.stdout.flush()
    sys.stderr.flush()
    # A signal waits until the process that begins now can take it: `prepare` lets it through.
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], environment)
