"""The command ``dpn``: the wheel's entry point, the same code as the binary."""

import signal
import sys

from ._dpn import main as _main


def main() -> None:
    """Runs the command line with the process's arguments and exits with its code."""
    # Python would keep Ctrl-C for itself until the call is over, which may be hours away.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_main(sys.argv))
