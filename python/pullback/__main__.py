"""The program `pullback`, as `cargo install` builds it."""

import sys

from . import _pullback


def main() -> int:
    """Runs the program with the arguments of this process; its exit code."""
    return _pullback.program(["pullback", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
