"""A diagnosis in a process of its own: started, looked after and ended without ever waiting for it."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from slider_drilling.log import RigLog
from slider_drilling.rig import Rig
from slider_drilling.twin.ask import Answer, Ask

if TYPE_CHECKING:
    from slider_drilling.diagnosis.baseline import Baseline

_NICE = 10  # below the process that follows the rig
_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
_START = "import sys; sys.path[:] = sys.argv[3:]; from slider_drilling.twin.background import main; main()"


@dataclass(frozen=True)
class Question:
    """What is asked, see `ask.Ask`."""

    ask: Ask
    before: RigLog | Baseline
    after: RigLog
    rig: Rig
    since: float


class BackgroundDiagnosis:
    """One question at a time, in another process.

    Attributes:
        error: Why the last question has no answer, in one line; None if it has one.
    """

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="slider_drilling_twin_")
        self._process: subprocess.Popen[bytes] | None = None
        self.error: str | None = None

    @property
    def running(self) -> bool:
        """Whether a question is being answered, or its answer has not been taken yet."""
        return self._process is not None

    def start(self, question: Question) -> None:
        """Ask; the process before must have ended (`poll`)."""
        assert self._process is None
        self._paths()[0].write_bytes(pickle.dumps(question))
        self._paths()[1].unlink(missing_ok=True)
        # A session of its own: Ctrl-C is for this process, which ends the other one in `close`.
        self._process = subprocess.Popen(
            [sys.executable, "-c", _START, *map(str, self._paths()), *(p for p in sys.path if p), os.getcwd()],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, **_ONE_THREAD}, start_new_session=True,
        )  # fmt: skip

    def poll(self) -> Answer | None:
        """The answer once there is one, else None; never waits."""
        if self._process is None or self._process.poll() is None:
            return None
        code, self._process = self._process.returncode, None
        try:
            answer, self.error = pickle.loads(self._paths()[1].read_bytes())
        except (OSError, EOFError, pickle.UnpicklingError):
            answer, self.error = None, f"the process of the diagnosis ended with code {code} without an answer"
        return answer if isinstance(answer, Answer) else None

    def close(self) -> None:
        """End the process, if there is one, and remove its files."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None
        self._folder.cleanup()

    def _paths(self) -> tuple[Path, Path]:
        return Path(self._folder.name) / "question", Path(self._folder.name) / "answer"


def main() -> None:
    """The other process: reads the question from the file of the first argument and writes the answer."""
    from slider_drilling.process.worker_pool import exit_with_parent

    exit_with_parent(os.getppid())
    os.nice(_NICE)
    question: Question = pickle.loads(Path(sys.argv[1]).read_bytes())
    try:
        answer, error = question.ask(question.before, question.after, question.rig, question.since), None
    except Exception as problem:  # whatever is wrong with these samples, the twin goes on and says it
        answer, error = None, " ".join(str(problem).split()) or type(problem).__name__
    written = Path(sys.argv[2] + ".part")
    written.write_bytes(pickle.dumps((answer, error)))
    written.replace(sys.argv[2])
