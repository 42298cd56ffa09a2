"""The look of marks: colour by name, symbol, dashes. Shapes and dashes say what colours say, for print and colour-blind eyes.

The page has the colours as variables of its style sheet, light and dark; paper has the inks below, which are those of light.
"""

from collections.abc import Hashable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from tuner.text.markup import Markup, element, join

if TYPE_CHECKING:
    from tuner.documents.comparison import ComparedFolder

INKS = {
    "default": "#b4530a", "tuned": "#0b63a5", "front": "#2f7d6d", "other": "#7a4aa0", "faint": "#9aa3ab", "muted": "#2b3238",
    "ink": "#2b3238", "bad": "#a3262a", "surface": "#ffffff",
    "c0": "#0b63a5", "c1": "#b4530a", "c2": "#2f7d6d", "c3": "#7a4aa0", "c4": "#a8326e", "c5": "#6b6a12", "c6": "#16798c",
    "c7": "#7a4b34",
}  # fmt: skip
# Symbol -> matplotlib's marker, and its path in a box of 16 by 16.
SYMBOLS = {
    "circle": ("o", "M8 3.2a4.8 4.8 0 1 0 .01 0z"),
    "diamond": ("D", "M8 2l6 6l-6 6l-6 -6z"),
    "square": ("s", "M3.5 3.5h9v9h-9z"),
    "triangle-up": ("^", "M8 2.5l5.8 10.5h-11.6z"),
    "cross": ("P", "M6 2.5h4v3.5h3.5v4h-3.5v3.5h-4v-3.5h-3.5v-4h3.5z"),
    "triangle-down": ("v", "M8 13.5l-5.8 -10.5h11.6z"),
    "x": (
        "X",
        "M3 5.2l2.2 -2.2l2.8 2.8l2.8 -2.8l2.2 2.2l-2.8 2.8l2.8 2.8l-2.2 2.2l-2.8 -2.8l-2.8 2.8l-2.2 -2.2l2.8 -2.8z",
    ),
    "hexagon": ("h", "M8 2l5.4 3v6l-5.4 3l-5.4 -3v-6z"),
    "x-thin": ("x", "M3 3l10 10M13 3l-10 10"),
    "cross-thin": ("+", "M8 1v14M1 8h14"),
    "line-ns": ("|", "M8 2v12"),
    "dot": (".", "M8 6.5a1.5 1.5 0 1 0 .01 0z"),
}
COUNT = 8
# Lengths of strokes and gaps [px] of contenders; the reference is dotted, so no contender is.
DASHES = ((), (7, 3), (9, 3, 2, 3), (4, 2), (12, 3, 2, 2, 2, 3), (14, 4), (5, 2, 1.5, 2), (3, 1.5))


class Look(NamedTuple):
    """Colour and symbol by name; size and width in pixels; hollow: the symbol is not filled."""

    colour: str
    symbol: str = "circle"
    hollow: bool = False
    dash: tuple[float, ...] = ()
    size: float = 8.0
    width: float = 1.8
    opacity: float = 1.0

    @property
    def ink(self) -> str:
        """Colour on paper."""
        return INKS[self.colour]

    @property
    def marker(self) -> str:
        """Symbol for matplotlib."""
        return SYMBOLS[self.symbol][0]

    @property
    def linestyle(self) -> Any:
        """Line style for matplotlib, which counts in line widths."""
        return (0, tuple(0.6 * length for length in self.dash)) if self.dash else "solid"


DEFAULT = Look("default", "square", hollow=True, dash=(6, 3), size=10)
TUNED = Look("tuned", "diamond", size=11)
FRONT = Look("front", size=8)
FINALIST = Look("front", hollow=True, size=8)
START = Look("other", "triangle-up", hollow=True, size=10)
SEARCHED = Look("faint", "dot", size=4, opacity=0.7)
INFEASIBLE = Look("faint", "x-thin", size=5, opacity=0.7)
PINS = (
    Look("c4", "triangle-up", dash=(9, 3, 2, 3), size=10),
    Look("c6", "triangle-down", dash=(4, 2), size=10),
    Look("c5", "hexagon", dash=(12, 3, 2, 2, 2, 3), size=10),
    Look("c7", "x", dash=(14, 4), size=10),
)
LOST = Look("bad", "x-thin", size=13, width=2.0)
REFERENCE = Look("muted", dash=(2, 3), width=1.3)
BOUND = Look("ink", dash=(3, 3), width=1.0)
RULE = Look("muted", dash=(1, 2), width=1.0)


def worst_look(look: Look) -> Look:
    """Return the look of the worst flight of a point: thin, dotted."""
    return look._replace(dash=(5, 2, 1, 2) if look.dash else (1.5, 1.5), width=1.0)


def role_look(role: str) -> Look:
    """Return the look of a point: of the default, or of whichever stands against it."""
    return DEFAULT if role == "default" else TUNED


def looks(flown: Sequence[tuple[Hashable, str]]) -> list[Look]:
    """Return a look for each contender, given as its laws and its airframe.

    The same laws on another airframe keep colour and symbol, which turns hollow; line styles are all different up to eight.
    """
    symbols, airframes = list(SYMBOLS)[:COUNT], list(dict.fromkeys(airframe for _, airframe in flown))
    seen: list[tuple[Hashable, str]] = []
    families: dict[tuple[Hashable, int], int] = {}
    styles = []
    for number, (laws, airframe) in enumerate(flown):
        family = families.setdefault((laws, seen.count((laws, airframe))), len(families))
        seen.append((laws, airframe))
        # Beyond eight, colours return with other symbols.
        symbol, hollow = symbols[(family + family // COUNT) % COUNT], airframes.index(airframe) % 2 == 1
        styles.append(Look(f"c{family % COUNT}", symbol, hollow, DASHES[number % COUNT]))
    return styles


@lru_cache(maxsize=1)
def looks_of(compared: "ComparedFolder") -> dict[str, Look]:
    """Return the look of each contender by name, the same in every chart, legend and table."""
    flown = [(tuple(entry.law_of.values()), entry.flown) for entry in compared.contenders]
    return dict(zip(compared.index, looks(flown), strict=True))


def drawn_mark(look: Look, x: float = 8.0, y: float = 8.0, size: float = 16.0) -> Markup:
    """Return the symbol of a look centred at a place inside a small drawing."""
    place = f"translate({x - size / 2:.1f} {y - size / 2:.1f}) scale({size / 16:.3g})"
    thin = " thin" if look.symbol.endswith("thin") else ""
    name = f"mark{thin}{' hollow' if look.hollow else ''} {look.colour}"
    return element("path", d=SYMBOLS[look.symbol][1], transform=place, class_=name)


def symbol(look: Look, size: float = 14.0) -> Markup:
    """Return the symbol of a look alone, for legends."""
    return element(
        "svg",
        drawn_mark(look, 8.0, 8.0, size),
        class_="icon",
        viewBox="0 0 16 16",
        width=16,
        height=16,
        aria_hidden="true",
    )


def legend(names: Sequence[tuple[str, Look]]) -> Markup:
    """Return a line with the lines of a chart by their names."""
    return element("p", join((join((sample(look, marked=False), f" {name} ")) for name, look in names)), class_="aid")


def sample(look: Look, marked: bool = True) -> Markup:
    """Return line and symbol of a look as a small drawing for legends and table heads."""
    dashes = " ".join(f"{length:g}" for length in look.dash)
    style = {"stroke_dasharray": dashes} if dashes else {}
    line = element("path", d="M1 8h38", class_=f"stroke {look.colour}", stroke_width=look.width, **style)
    parts = join((line, drawn_mark(look, 20.0, 8.0, 14.0) if marked else ""))
    return element("svg", parts, class_="icon", viewBox="0 0 40 16", width=40, height=16, aria_hidden="true")
