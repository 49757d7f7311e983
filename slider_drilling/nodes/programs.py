"""The programs that `ros2 run slider_drilling NAME` starts: one node each, one line for a user's mistake."""

import os
import signal
from collections.abc import Callable
from functools import partial


def _leave(number: int, frame: object) -> None:
    os._exit(0)


# Before the imports that take a while: an interrupted start is no failure, and has nothing yet to finish. The launch
# files keep signals waiting while Python itself starts, which would answer with a traceback; here they are let through.
for _number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(_number, _leave)
signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT, signal.SIGTERM))


def __getattr__(name: str) -> Callable[[], None]:
    """Returns the entry point of the node `name`; setup.cfg lists them."""
    if name.startswith("_"):
        raise AttributeError(name)
    return partial(_main, name)


def _main(name: str) -> None:
    """Run the node and end the process: 0 after its work or a signal, 2 for the user's mistake."""
    import sys

    from slider_drilling.errors import InputError
    from slider_drilling.nodes import environment
    from slider_drilling.process.environment_variables import check_variables
    from slider_drilling.process.parent_death import interrupt_with_parent

    code = 0
    try:
        check_variables(os.environ)
        environment.prepare()
        interrupt_with_parent()
        from slider_drilling.nodes.run_node import run_node

        run_node(name)
    except InputError as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        code = 2
    # Python gives signals their ways back while it shuts down: one more would be taken for a crash.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    raise SystemExit(code)
