"""`tuner verify`: is a recorded run what this machine computes from the same study?"""

import json
from pathlib import Path

from typer import Exit

from tuner.cli.display import TerminalWatcher
from tuner.cli.terminal import Console
from tuner.search.watcher import Watcher

DIFFERENT = 1


def verify_command(results: Path, sample: int | None, threads: int | None, as_json: bool) -> None:
    """Replay and fly again, print the verdict; exit code 1 at the first difference."""
    from tuner.experiments.again.verify import verify

    if as_json:
        found = verify(results, sample, threads, Watcher())
        print(json.dumps(found.as_dict(), indent=2))
    else:
        console = Console()
        with TerminalWatcher(console) as watcher:
            found = verify(results, sample, threads, watcher)
        console.print(found.words, highlight=False, soft_wrap=True)
    if not found.identical:
        raise Exit(DIFFERENT)
