"""Blank figures for tests that look at none: drawing takes half of the time of a short run.

Figures are blank in all of `tests/tuner/` but `tests/tuner/report/`: the fixtures `blank_figures` and `drawn_figures`.
"""

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path
from unittest.mock import patch

from tests.undrawn.blank import replacements
from tuner.report import write_figures
from tuner.report.charts import paper, printer

HERE = str(Path(__file__).parent)
BLANK = replacements(paper)
DRAWN = [(owner, name, getattr(owner, name)) for owner, name, _ in BLANK]
CODE = printer.CODE
"""Program of the process that draws, which is isolated: no folder of PYTHONPATH changes it."""


class DrawnHere:
    """Draws figures in this process, which has matplotlib already; `tests/tuner/report/test_drawing.py` has the one that else does."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def begin(self, results: object) -> None:
        """Do nothing."""

    def go_on(self, results: object) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Do nothing."""

    def wait(self) -> None:
        """Draw."""
        write_figures(self.folder)


def search_path(*first: str) -> str:
    """Return the folders that new processes look for modules in, the given ones first and this one nowhere else."""
    others = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    return os.pathsep.join([*first, *(folder for folder in others if folder not in ("", HERE))])


@contextmanager
def undrawn() -> Iterator[None]:
    """Leave figures blank, here and in processes that are started here."""
    with ExitStack() as patched:
        for each in (
            patch("tuner.report.start_figures", DrawnHere),
            *(patch.object(*replaced) for replaced in BLANK),
            patch.object(printer, "CODE", f"import sys; sys.path.insert(0, {HERE!r}); import leave_blank; {CODE}"),
            patch("tuner.report.charts.printer.early", nullcontext),
            patch.dict(os.environ, PYTHONPATH=search_path(HERE)),
        ):
            patched.enter_context(each)
        yield


@contextmanager
def drawn() -> Iterator[None]:
    """Draw figures within `undrawn`, in processes that are started here too."""
    with ExitStack() as patched:
        for each in (
            *(patch.object(*replaced) for replaced in DRAWN),
            patch.object(printer, "CODE", CODE),
            patch.dict(os.environ, PYTHONPATH=search_path()),
        ):
            patched.enter_context(each)
        yield
