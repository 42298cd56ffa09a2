"""A console for wide tables; imports nothing but rich, for listings are to come at once."""

import sys

from tuner.cli.terminal import Console

# A pipe has no width, and 80 columns would cut names and fold meanings into ribbons.
PIPE_WIDTH = 160


def wide_console() -> Console:
    """Return a console as wide as the terminal, or as `PIPE_WIDTH` in a pipe."""
    return Console(width=None if sys.stdout.isatty() else PIPE_WIDTH)
