"""The program `slider-drilling`; `python -m slider_drilling` is the same."""

import os
import sys

# `python -m` looks for every module in the working directory first, where a file `queue.py` would be executed in place
# of the standard library's.
if not getattr(sys.flags, "safe_path", False) and sys.path and sys.path[0] == os.getcwd():
    sys.path.append(sys.path.pop(0))

import signal


def _exit_on_signal(number: int, frame: object) -> None:
    os._exit(128 + number)


# Set before the slow imports: an interrupted start has nothing to finish, and Python would print a traceback. Signals
# that the parent process ignores stay ignored.
for _number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    if signal.getsignal(_number) is not signal.SIG_IGN:
        signal.signal(_number, _exit_on_signal)

from slider_drilling.cli import main  # noqa: E402

if __name__ == "__main__":
    main()
