"""Blank figures for tests that look at none: drawing takes half of the time of a short run.

Figures are blank in all of `tests/tuner/` but `tests/tuner/report/`: the fixtures `blank_figures` and `drawn_figures`.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any
from unittest.mock import patch

from matplotlib.figure import Figure

from tuner.report import write_figures
from tuner.report.charts import printer

HERE = str(Path(__file__).parent)
DRAW: Any = Figure.draw
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
    here = patch("tuner.report.start_figures", DrawnHere), patch.object(Figure, "draw", lambda *_: None)
    with (
        here[0],
        here[1],
        patch.object(printer, "CODE", f"import sys; sys.path.insert(0, {HERE!r}); import sitecustomize; {CODE}"),
        patch("tuner.report.charts.printer.early", nullcontext),
        patch.dict(os.environ, PYTHONPATH=search_path(HERE)),
    ):
        yield


@contextmanager
def drawn() -> Iterator[None]:
    """Draw figures within `undrawn`, in processes that are started here too."""
    blank_no_more = patch.object(Figure, "draw", DRAW), patch.object(printer, "CODE", CODE)
    with blank_no_more[0], blank_no_more[1], patch.dict(os.environ, PYTHONPATH=search_path()):
        yield
