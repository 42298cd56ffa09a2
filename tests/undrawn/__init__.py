"""Blank figures for tests that look at none: drawing takes half of the time of a short run."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch


@contextmanager
def undrawn() -> Iterator[None]:
    """Leave figures blank, here and in processes that are started here."""
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    with patch("matplotlib.figure.Figure.draw"), patch.dict(os.environ, {"PYTHONPATH": path}):
        yield
