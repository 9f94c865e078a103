"""What all tests share."""

import signal


def pytest_configure() -> None:
    """Ctrl-C interrupts, also where the shell that began the tests has them ignore it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
