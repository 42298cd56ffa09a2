"""Figures drawn by a process of their own while the run goes on writing: matplotlib alone takes a second to import."""

import subprocess
import sys
from pathlib import Path

from plant.errors import StoreError


class Drawing:
    """Figures of a results folder, drawn by a process that imports what it needs at once and draws when told to begin."""

    def __init__(self, folder: Path) -> None:
        code = "import sys; from tuner.report.drawing import draw; sys.exit(draw(sys.argv[1]))"
        self._process = subprocess.Popen(
            [sys.executable, "-c", code, str(folder.resolve())], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE, text=True, cwd=Path(__file__).parents[2],
        )  # fmt: skip

    def begin(self) -> None:
        """Draw: everything that the figures show is in the folder."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.close()
        except BrokenPipeError:
            return  # It has ended already, and `wait` says why.

    def stop(self) -> None:
        """Give up."""
        self._process.kill()
        self._process.communicate()

    def wait(self) -> None:
        """Wait until they are there; StoreError says why they are not."""
        self.begin()
        assert self._process.stderr is not None
        with self._process.stderr as errors:
            said = errors.read()
        self._process.wait()
        if self._process.returncode:
            raise StoreError(
                said.strip().splitlines()[-1].removeprefix("Error: ") if said.strip() else "no figures drawn"
            )


def draw(folder: str) -> int:
    """Draw all figures of a folder once stdin ends; return 0, or 2 with one line on stderr where that cannot be done."""
    from tuner.cli.errors import guarded
    from tuner.report.figures import write_all

    def drawn() -> None:
        sys.stdin.read()
        write_all(Path(folder))

    return guarded(drawn)
