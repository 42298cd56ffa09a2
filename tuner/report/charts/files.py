"""Figures as files of a results folder. Apart from `paper`, so that a process which only draws imports no store."""

from pathlib import Path

from tuner.report.charts.paper import Figure, printed
from tuner.store.folder import put


def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write NAME.png and NAME.pdf into a results folder, each whole or not at all; return both paths."""
    return [put(folder, name + ending, content) for ending, content in printed(figure).items()]
