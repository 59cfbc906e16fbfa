"""The command ``manylight`` of the package: the same program as the one that cargo builds."""

import signal
import sys

from ._native import run_command


def main() -> None:
    """Runs the command with the words of this process."""
    # The renderer handles Ctrl-C by itself: it writes the image.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run_command(["manylight", *sys.argv[1:]]))
