"""Stand-ins of figures that no test looks at: axes that take any call, and files of an empty figure 0.1 inch wide.

Axes take half of the time of a figure, its files as much again, whatever is drawn. A process that draws imports this module too,
from this folder.
"""

from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

SIZE = 0.1
"""Width and height of an empty figure [in]."""


class Anything:
    """Axes and all that belongs to them."""

    def __getattr__(self, _: str) -> "Anything":
        return self

    def __call__(self, *_: Any, **__: Any) -> "Anything":
        return self


def replacements(paper: Any) -> list[tuple[Any, str, Any]]:
    """Return owners, names and stand-ins; paper: the module of figures for paper."""
    formats = ((paper.FigureCanvasAgg, "print_png"), (paper.FigureCanvasPdf, "print_pdf"))
    marks = ("draw", "mark_edges", "legend_above", "legend_over")
    return [
        (paper.Figure, "draw", _nothing),
        (paper, "grid", lambda count, *_: (paper.Figure(figsize=(SIZE, SIZE)), [Anything()] * count)),
        *((paper, name, _nothing) for name in marks),
        *((canvas, name, _printer(paper.Figure, canvas, name)) for canvas, name in formats),
    ]


def _nothing(*_: Any, **__: Any) -> None:
    """Draw nothing."""


def _printer(figure: Any, canvas: Any, name: str) -> Any:
    """Return a method that writes the file of an empty figure."""
    printed = getattr(canvas, name)

    @cache
    def empty() -> bytes:
        file = BytesIO()
        printed(canvas(figure(figsize=(SIZE, SIZE))), file, metadata={"CreationDate": None} if "pdf" in name else None)
        return file.getvalue()

    def write(_: Any, file: Any, **__: Any) -> None:
        if isinstance(file, str | Path):
            Path(file).write_bytes(empty())
        else:
            file.write(empty())

    return write
