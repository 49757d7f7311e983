"""A programme in the node `rocking_controller`: loaded, aborted, and ended with the node."""

from __future__ import annotations

from slider_drilling.control.interface import Controller
from slider_drilling.errors import InputError
from slider_drilling.programmes.controller import ProgrammeController
from slider_drilling.programmes.find_programme import find_programme
from slider_drilling.programmes.progress import ProgrammeProgress
from slider_drilling.programmes.rig_check import check_start_depth
from slider_drilling.rig import Rig

END_DELAY = 5.0  # s of rig time for which the node goes on after the programme's end


class ProgrammeRun:
    """What the node does beside stepping a programme's controller.

    Args:
        path: Of the programme or slide sheet, or the name of a built-in one; empty where the node runs another
            controller.
        ends_node: Whether the node ends with the programme.
    """

    def __init__(self, path: str, ends_node: bool) -> None:
        self.path = path
        self._ends_node = ends_node
        self._controller: ProgrammeController | None = None
        self._ended_at: float | None = None

    def load(self, rig: Rig) -> Controller:
        """The programme's controller, from its first step on. Raises InputError."""
        found = find_programme(self.path)
        check_start_depth(found.start, rig, self.path)
        self._controller = ProgrammeController(rig, found.programme, self.path)
        self._ended_at = None
        return self._controller

    def abort(self, reason: str) -> str:
        """Abort the programme; returns what happens. Raises InputError where none runs."""
        if self._controller is None:
            raise InputError("no programme runs; give its file as the parameter programme")
        return self._controller.abort(reason)

    @property
    def progress(self) -> ProgrammeProgress | None:
        """How far the programme is; None where none runs."""
        return None if self._controller is None else self._controller.progress()

    def held_tool_face(self, target: float) -> float | None:
        """Toolface to publish as the target: the programme's, or the node's where it runs another controller."""
        return target if self._controller is None else self._controller.held_tool_face

    def ends_node(self, time: float) -> bool:
        """Whether the node ends now, with the programme; time: of the rig, s."""
        if self._controller is None or not self._ends_node or not self._controller.ended:
            return False
        if self._ended_at is None:
            self._ended_at = time
        return time >= self._ended_at + END_DELAY
