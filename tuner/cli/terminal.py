"""The console of all commands: rich's, with texts that stay texts; `tuner.text.inert_stream` does it for what is printed.

Numbers follow the rules of `tuner.text.numbers`, in letters that can be copied into a file.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from rich import console
from rich.segment import Segment
from rich.text import Text

from plant.texts import inert
from tuner.text import numbers, sentences

if TYPE_CHECKING:
    from tuner.documents.comparison_document import EstimateRow
    from tuner.documents.parts import Estimate

FLY_AIRFRAME = 'Written: {}; fly it with file = "..." in [airframe] and from = "airframe" in [scenario.spread].'
"""Advice after an airframe's file is written."""
MIN_WIDTH = 20
"""Least columns for which anything is laid out."""
SPACES = str.maketrans({"\u202f": ","})
PLAIN = SPACES | str.maketrans({"−": "-"})


class Console(console.Console):
    """A console whose texts are texts: no markup, no emoji codes, nothing that steers the terminal."""

    def __init__(self, **options: Any) -> None:
        super().__init__(markup=False, emoji=False, highlight=False, **options)
        # Charts and tables have no form in less; the terminal breaks longer lines.
        self.width = max(self.width, MIN_WIDTH)

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a text ready to be laid out; see `Console.render_str`."""
        return super().render_str(inert(text.translate(SPACES)), **options)

    def render(
        self, renderable: console.RenderableType, options: console.ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """Yield what is written; rich's own control codes are left as they are."""
        for segment in super().render(renderable, options):
            yield segment if segment.control else Segment(inert(segment.text), segment.style)

    def warn(self, texts: Iterable[str]) -> None:
        """Print warnings, a line each."""
        for text in texts:
            self.print(f"Warning: {text}", style="yellow")

    def bullets(self, texts: Iterable[str]) -> None:
        """Print sentences as a list."""
        for text in texts:
            self.print(f"- {text}")


def unit_text(unit: str, form: str = "{}") -> str:
    """Return a unit within other words; nothing for "1" or ""."""
    return "" if unit in ("", "1") else form.format(unit)


def bound_text(row: Any) -> str:
    """Return the limit of a row, "min 35"; one without a sense is an upper one, and no limit is ""."""
    return "" if row.limit is None else sentences.bound_text(row.limit, getattr(row, "sense", "max")).translate(PLAIN)


def width(entry: Any) -> float:
    """Return the width of a number's interval, or else the number."""
    spread = 0.0 if entry.low is None or entry.high is None else entry.high - entry.low
    return spread or entry.value or 0.0


def digits(value: float | None, width: float) -> str:
    """Return a number with digits that suit its interval's width.

    width: of the interval, or a companion of that size.
    """
    return numbers.rounded_to(value, width).translate(PLAIN)


def estimate(entry: "Estimate | EstimateRow", signed: bool = False) -> str:
    """Return the value over its interval, or alone where it has none; signed: with a plus on positive values."""
    if entry.value is None:
        return "unbounded"
    if entry.low is None or entry.high is None:
        return f"{numbers.plus(entry.value, signed)}{entry.value:.4g}"
    value, interval = numbers.estimate(entry.value, entry.low, entry.high)
    return f"{numbers.plus(entry.value, signed)}{value}\n{interval}".translate(PLAIN)


def difference(entry: "Estimate") -> str:
    """Return a difference over its interval, with its sign."""
    return estimate(entry, signed=True)
