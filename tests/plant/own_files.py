"""Files of one's own that tests write: the shipped examples, whole or with one thing wrong."""

from pathlib import Path

from objectives.metrics import METRICS
from plant.law_registry import LAWS
from plant.own_code import HAVE_RUN
from plant.references import REFERENCES

SHIPPED = Path(__file__).parents[2] / "studies" / "own_law"
LAW, METRIC, SWAY, REFERENCE = (SHIPPED / name for name in ("pid_plain.py", "mae.py", "sway.py", "circle.py"))


def edited(source: Path, folder: Path, *changes: tuple[str, str], name: str | None = None) -> Path:
    """Return a copy of a file with some texts replaced, each of which it must hold."""
    text = source.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    file = folder / (name or source.name)
    file.write_text(text, encoding="utf-8")
    return file


def line_of(file: Path, text: str) -> int:
    """Return the number of the first line that holds a text."""
    lines = file.read_text(encoding="utf-8").splitlines()
    return next(number for number, line in enumerate(lines, 1) if text in line)


def forget() -> None:
    """Know no code of one's own any more, as another process does."""
    HAVE_RUN.clear()
    for registry in (LAWS, METRICS, REFERENCES):
        for name in [name for name, entry in registry.items() if entry.origin is not None]:
            del registry[name]
