"""Blank figures for tests that look at none: drawing takes half of the time of a short run."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from tuner.report import write_figures


class DrawnHere:
    """Draws figures in this process, which has matplotlib already; `tests/tuner/report/test_drawing.py` has the one that else does."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def begin(self) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Do nothing."""

    def wait(self) -> None:
        """Draw."""
        write_figures(self.folder)


@contextmanager
def undrawn() -> Iterator[None]:
    """Leave figures blank, here and in processes that are started here."""
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    here = patch("tuner.report.start_figures", DrawnHere)
    with here, patch("matplotlib.figure.Figure.draw"), patch.dict(os.environ, {"PYTHONPATH": path}):
        yield
