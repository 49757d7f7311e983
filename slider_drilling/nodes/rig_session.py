"""Controller and recorder on a rig's own topics until a programme has ended; no simulator.

python -m slider_drilling.nodes.rig_session RIG PROGRAMME FOLDER [NAMESPACE]
"""

from __future__ import annotations

import contextlib
import json
import sys
from pathlib import Path

import rclpy

from slider_drilling.errors import InputError
from slider_drilling.nodes import environment
from slider_drilling.nodes.recorder import Recorder
from slider_drilling.nodes.rocking_controller import RockingController
from slider_drilling.nodes.run_node import init
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.nodes.spin import drain, node_maker, spin
from slider_drilling.process.parent_death import interrupt_with_parent
from slider_drilling.programmes.progress import ProgrammeProgress


def run_on_rig(rig: Path, programme: Path, folder: Path, namespace: str = "/") -> tuple[Path, ProgrammeProgress | None]:
    """Run a programme on the rig behind the topics, with its limits and interlocks, and record it.

    Args:
        rig: Rig file.
        programme: The programme.
        folder: Of the log.
        namespace: Of the rig's topics.

    Returns:
        The log, and how far the programme came.

    Raises:
        InputError: A file or folder cannot be used.
    """
    init(["slider-drilling", "--ros-args", "-r", f"__ns:={namespace}"])
    shutdown_request = ShutdownRequest()
    shutdown_request.take_signals()
    try:
        with contextlib.ExitStack() as ending:
            return _run(rig, programme, folder, shutdown_request, ending)
    finally:
        rclpy.try_shutdown()
        shutdown_request.restore_handlers()


def _run(
    rig: Path, programme: Path, folder: Path, shutdown_request: ShutdownRequest, ending: contextlib.ExitStack
) -> tuple[Path, ProgrammeProgress | None]:
    make = node_maker(shutdown_request, ending)
    recorder = make(Recorder, directory=str(folder), rig=str(rig), programme=str(programme))
    ending.callback(recorder.close)
    controller = make(RockingController, rig=str(rig), programme=str(programme), end_with_programme=True)
    executor = spin([recorder, controller], shutdown_request, lambda: None)
    ending.callback(executor.shutdown)
    drain(executor, lambda: recorder.messages)
    shutdown_request.raise_error()
    return recorder.path, controller.programme_progress


def why_not_done(progress: ProgrammeProgress | None) -> str:
    """Why a programme did not come to its end; empty if it did."""
    if progress is None:
        return "it never began"
    return progress.reason if progress.state.ended else f"interrupted: {progress}"


def main() -> int:
    """Run a programme and print its log as JSON; exit code 0 at its end, 1 if it did not get there, 2 for a mistake."""
    if len(sys.argv) not in (4, 5):
        print(__doc__, file=sys.stderr)
        return 2
    rig, programme, folder, *rest = sys.argv[1:]
    interrupt_with_parent()
    environment.prepare()
    try:
        log, progress = run_on_rig(Path(rig), Path(programme), Path(folder), *rest)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    reason = why_not_done(progress)
    print(json.dumps({"log": str(log), "programme": {"reason": reason}}))
    return 1 if reason else 0


if __name__ == "__main__":
    sys.exit(main())
