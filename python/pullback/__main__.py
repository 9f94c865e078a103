"""The program `pullback`, as `cargo install` builds it."""

import signal
import sys

from . import _pullback


def main() -> int:
    """Runs the program with the arguments of this process; its exit code."""
    # The program answers Ctrl-C itself, and before its first step the system does.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _pullback.program(["pullback", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
