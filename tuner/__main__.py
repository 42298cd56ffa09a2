"""The command `tuner`, and `python -m tuner`, the same without the console script."""

import os
import sys
import traceback
from pathlib import Path

from tuner.text.signals import CRASHED, SIGNALLED, end_at_interrupts, end_without_joining


def run() -> None:
    """Run the command line; a signal is heard from before the first import of it to the end of the process."""
    end_at_interrupts()
    open_closed_streams()
    leave_out_working_folder()
    try:
        from tuner.cli.main import main

        main()
    except SystemExit as ended:
        if isinstance(ended.code, int) and ended.code > SIGNALLED:
            end_without_joining(ended.code)
        raise
    except Exception:
        # Python's own code is 1, which is a verdict; a broken installation ends here, before `tuner.text.errors` is there.
        traceback.print_exc()
        sys.exit(CRASHED)


def open_closed_streams() -> None:
    """Replace closed standard streams: the next file that is opened would stand in their place."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "w" if number else "r", closefd=False))


def leave_out_working_folder() -> None:
    """Take the working folder off the search path: `python -m` puts it first, and a stranger's rich.py there would run."""
    home = Path(__file__).resolve().parents[1]
    if sys.path and Path(sys.path[0]).resolve() == Path.cwd() != home:
        del sys.path[0]


if __name__ == "__main__":
    run()
