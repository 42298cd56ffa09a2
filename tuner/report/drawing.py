"""Figures drawn by a process of their own while the run goes on writing: matplotlib alone takes half a second to import.

That process touches no file. It gets panels and returns figures; the run, which holds the folder's lock, reads
and writes. It ends when its parent does, however that dies: its standard input is a pipe that the system then closes.
"""

from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from plant.errors import StoreError
from tuner.report.charts.printer import end, taken
from tuner.report.charts.printing import Order, order, received
from tuner.store.folder import put_together

if TYPE_CHECKING:
    from tuner.documents.tuning import TuningFolder


class FigureProcess:
    """Figures of a results folder, drawn by a process that imports what it needs at once and draws when told to."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._process = taken()
        assert self._process.stdin is not None
        # Taken away from `communicate`, which would close it before it reads.
        self._orders, self._process.stdin = self._process.stdin, None

    def begin(self, results: "TuningFolder") -> None:
        """Draw search and front; the folder may lack responses."""
        # Imported beside the search by then, see `report.prepare`; the process is to start at once.
        from tuner.report.sheets import search_sheets

        self._give(search_sheets(results))

    def go_on(self, results: "TuningFolder") -> None:
        """Draw what the responses show."""
        from tuner.report.sheets import scenario_sheets

        for name, sheet in scenario_sheets(results).items():
            self._give({name: sheet()})

    def _give(self, sheets: Order) -> None:
        # Where the process has ended already, `wait` says why.
        with suppress(BrokenPipeError):
            self._orders.write(order(sheets))
            self._orders.flush()

    def stop(self) -> None:
        """Give up, whatever was begun."""
        end(self._process)
        with suppress(BrokenPipeError):
            self._orders.close()

    def wait(self) -> None:
        """Wait for the figures and write them; StoreError says why they are not there."""
        self._give({})
        out, errors = self._process.communicate()
        self.stop()
        files, stderr = received(BytesIO(out)), errors.decode(errors="replace").strip()
        if self._process.returncode or files is None:
            raise StoreError(stderr.splitlines()[-1] if stderr else "no figures drawn")
        put_together(self._folder, files)
