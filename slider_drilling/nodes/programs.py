"""The programs that `ros2 run slider_drilling NAME` starts, one node each."""

import os
import signal
from collections.abc import Callable
from functools import partial


def _exit_on_signal(number: int, frame: object) -> None:
    os._exit(0)


# Before the slow imports: an interrupted start is not a failure and has nothing to finish. The launch files block
# signals while Python itself starts, which would print a traceback; from here on they are let through.
for _number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(_number, _exit_on_signal)
signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT, signal.SIGTERM))


def __getattr__(name: str) -> Callable[[], None]:
    """Returns the entry point of the node `name`; setup.cfg lists them."""
    if name.startswith("_"):
        raise AttributeError(name)
    return partial(_main, name)


def _main(name: str) -> None:
    """Run the node and exit: 0 after its work or a signal, 1 if nobody reads its help, 2 for a mistake of the user."""
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
        sys.stdout.flush()
    except InputError as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        code = 2
    except BrokenPipeError:
        # The reader has left, as `| head` does; Python's flush at exit would report it again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 1
    # Python restores the default handlers while it shuts down; another signal would then look like a crash.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    raise SystemExit(code)
