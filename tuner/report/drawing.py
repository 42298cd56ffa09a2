"""Figures drawn by a process of their own while the run goes on writing: matplotlib alone takes a second to import."""

import subprocess
import sys
from pathlib import Path

from plant.errors import StoreError


class Drawing:
    """Figures of a results folder that are being drawn."""

    def __init__(self, folder: Path) -> None:
        code = "import sys; from tuner.report.drawing import draw; sys.exit(draw(sys.argv[1]))"
        self._process = subprocess.Popen(
            [sys.executable, "-c", code, str(folder.resolve())], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            text=True, cwd=Path(__file__).parents[2],
        )  # fmt: skip

    def wait(self) -> None:
        """Wait until they are there; StoreError says why they are not."""
        _, said = self._process.communicate()
        if self._process.returncode:
            raise StoreError(
                said.strip().splitlines()[-1].removeprefix("Error: ") if said.strip() else "no figures drawn"
            )


def draw(folder: str) -> int:
    """Draw all figures of a folder; return 0, or 2 with one line on stderr where that cannot be done."""
    from tuner.cli.errors import guarded
    from tuner.report.figures import write_all

    def drawn() -> None:
        write_all(Path(folder))

    return guarded(drawn)
