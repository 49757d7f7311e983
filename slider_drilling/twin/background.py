"""A diagnosis in a process of its own: started, looked after and ended without ever waiting for it."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider_drilling.diagnosis.onset import Onset, Since
from slider_drilling.log import RigLog
from slider_drilling.process.peak_memory import peak_bytes
from slider_drilling.rig import Rig
from slider_drilling.twin.ask import Ask

_POLLED_S = 0.05
_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
_START = "import sys; sys.path[:] = sys.argv[3:]; from slider_drilling.twin.background import main; main()"


@dataclass(frozen=True)
class PickledBaseline:
    """A baseline as the other process keeps it: the twin's own process never loads the code of the diagnosis.

    Attributes:
        content: Pickled.
    """

    content: bytes


@dataclass(frozen=True)
class Question:
    """What is asked, see `ask.Ask`.

    Attributes:
        nice: Of its process: below the one that follows a rig, as it where that waits for the reply.
    """

    ask: Ask
    before: RigLog | PickledBaseline
    after: RigLog
    rig: Rig
    since: Since | None
    onset: Onset | None = None
    nice: int = 10


@dataclass(frozen=True)
class Reply:
    """What the other process answers.

    Attributes:
        tree: See `ask.Answer`; None without an answer.
        baseline: It can be given in place of the samples from before when the same is asked again.
        error: Why there is no answer, in one line; None if there is one.
        cpu: s of processor time, from the start of that process.
        peak: bytes, the most memory that it held.
    """

    tree: dict[str, Any] | None
    baseline: PickledBaseline | None
    error: str | None
    cpu: float = 0.0
    peak: int = 0

    def comes_at(self, asked: float) -> float:
        """When it comes beside a rig if asked at this time of the rig, s, whatever else this machine does now."""
        return asked + self.cpu


class BackgroundDiagnosis:
    """One question at a time, in another process."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="slider_drilling_twin_")
        self._process: subprocess.Popen[bytes] | None = None

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

    def poll(self) -> Reply | None:
        """The reply once there is one, else None; never waits."""
        if self._process is None or self._process.poll() is None:
            return None
        code, self._process = self._process.returncode, None
        try:
            reply: Reply = pickle.loads(self._paths()[1].read_bytes())
        except (OSError, EOFError, pickle.UnpicklingError):
            return Reply(None, None, f"the process of the diagnosis ended with code {code} without an answer")
        return reply

    def wait(self) -> Reply | None:
        """The reply, as late as it comes; None where nothing was asked."""
        while self.running:
            reply = self.poll()
            if reply is not None:
                return reply
            time.sleep(_POLLED_S)
        return None

    def end(self) -> None:
        """End the process, if there is one, without its reply."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def close(self) -> None:
        """End the process, and remove its files."""
        self.end()
        self._folder.cleanup()

    def _paths(self) -> tuple[Path, Path]:
        return Path(self._folder.name) / "question", Path(self._folder.name) / "answer"


def main() -> None:
    """The other process: reads the question from the file of the first argument and writes the answer."""
    from slider_drilling.process.worker_pool import exit_with_parent

    exit_with_parent(os.getppid())
    question: Question = pickle.loads(Path(sys.argv[1]).read_bytes())
    os.nice(question.nice)
    reply = _reply_to(question)
    written = Path(sys.argv[2] + ".part")
    written.write_bytes(pickle.dumps(reply))
    written.replace(sys.argv[2])


def _reply_to(question: Question) -> Reply:
    before = question.before
    try:
        given = pickle.loads(before.content) if isinstance(before, PickledBaseline) else before
        answer = question.ask(given, question.after, question.rig, question.since, question.onset)
    except Exception as problem:  # whatever is wrong with these samples, the twin goes on and says it
        error = " ".join(str(problem).split()) or type(problem).__name__
        return Reply(None, None, error, time.process_time(), peak_bytes() or 0)
    kept = None if answer.baseline is None else PickledBaseline(pickle.dumps(answer.baseline))
    return Reply(answer.tree, kept, None, time.process_time(), peak_bytes() or 0)
