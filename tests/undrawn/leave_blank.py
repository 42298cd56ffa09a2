"""Leaves figures blank in a Python process that imports this module from this folder.

matplotlib takes half a second to import, so nothing happens before the process imports it itself. The product's own process of
figures is isolated and imports no module of the tests as it starts: a process that has this one puts it before the other's program.
"""

import sys
from collections.abc import Callable
from importlib.abc import MetaPathFinder
from importlib.util import find_spec
from pathlib import Path

HERE = str(Path(__file__).parent)
BLANK = f"import sys; sys.path.insert(0, {HERE!r}); import leave_blank; "
"""Beginning of a program whose figures are blank."""


def _leave_blank(module) -> None:
    from blank import replacements  # of this folder

    for owner, name, blank in replacements(module):
        setattr(owner, name, blank)


def _start_blank(module) -> None:
    module.CODE = BLANK + module.CODE


CHANGES: dict[str, Callable] = {"tuner.report.charts.paper": _leave_blank, "tuner.report.charts.printer": _start_blank}


class BlankFigures(MetaPathFinder):
    """Finds modules as others do, and changes those of `CHANGES` once they are loaded."""

    def __init__(self) -> None:
        self._left = dict(CHANGES)

    def find_spec(self, fullname, path=None, target=None):
        change = self._left.pop(fullname, None)
        if change is None:
            return None
        spec = find_spec(fullname)
        assert spec is not None and spec.loader is not None
        load = spec.loader.exec_module

        def load_changed(module):
            load(module)
            change(module)

        spec.loader.exec_module = load_changed
        return spec


sys.meta_path.insert(0, BlankFigures())
