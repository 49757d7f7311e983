"""The program `slider-drilling`; `python -m slider_drilling` is the same."""

import os
import signal


def _leave(number: int, frame: object) -> None:
    os._exit(128 + number)


# Before the imports that take a while: an interrupted start has nothing to finish, and Python would answer it with a
# traceback. What whoever started us has ignored stays so.
for _number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    if signal.getsignal(_number) is not signal.SIG_IGN:
        signal.signal(_number, _leave)

from slider_drilling.cli import main  # noqa: E402

if __name__ == "__main__":
    main()
