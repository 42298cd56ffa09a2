"""Leaves figures blank in a Python process that has this folder on its path, which imports this module by name as it starts.

matplotlib takes half a second to import, so nothing happens before the process imports it itself.
"""

import sys
from importlib.abc import MetaPathFinder
from importlib.util import find_spec


class BlankFigures(MetaPathFinder):
    """Finds matplotlib.figure as others do, and takes its drawing away once it is loaded."""

    def find_spec(self, fullname, path=None, target=None):
        if fullname != "matplotlib.figure":
            return None
        sys.meta_path.remove(self)
        spec = find_spec(fullname)
        assert spec is not None and spec.loader is not None
        load = spec.loader.exec_module

        def load_blank(module):
            load(module)
            module.Figure.draw = lambda *_: None

        spec.loader.exec_module = load_blank
        return spec


sys.meta_path.insert(0, BlankFigures())
