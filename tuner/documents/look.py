"""How a contender looks, the same in every figure, legend and table: colour, symbol, line style and tag.

Shapes and dashes say what the colours say, so that nothing is lost in print or to a colour-blind eye. The colours of the
page are the variables --c0 to --c7 of contest.css; those of the figures for a paper stand here.
"""

from collections.abc import Hashable, Sequence
from typing import Any, NamedTuple

from tuner.text.markup import Markup, element, join

# plotly symbol, matplotlib marker, path in a box of 16 by 16.
SYMBOLS = (
    ("circle", "o", "M8 3.2a4.8 4.8 0 1 0 .01 0z"),
    ("diamond", "D", "M8 2l6 6l-6 6l-6 -6z"),
    ("square", "s", "M3.5 3.5h9v9h-9z"),
    ("triangle-up", "^", "M8 2.5l5.8 10.5h-11.6z"),
    ("cross", "P", "M6 2.5h4v3.5h3.5v4h-3.5v3.5h-4v-3.5h-3.5v-4h3.5z"),
    ("triangle-down", "v", "M8 13.5l-5.8 -10.5h11.6z"),
    (
        "x",
        "X",
        "M3 5.2l2.2 -2.2l2.8 2.8l2.8 -2.8l2.2 2.2l-2.8 2.8l2.8 2.8l-2.2 2.2l-2.8 -2.8l-2.8 2.8l-2.2 -2.2l2.8 -2.8z",
    ),
    ("hexagon", "h", "M8 2l5.4 3v6l-5.4 3l-5.4 -3v-6z"),
)
# Lengths of strokes and gaps [px]; the reference is dotted, so no contender is.
DASHES = ((), (7, 3), (9, 3, 2, 3), (4, 2), (12, 3, 2, 2, 2, 3), (14, 4), (5, 2, 1.5, 2), (3, 1.5))
INKS = ("#0b63a5", "#b4530a", "#2f7d6d", "#7a4aa0", "#a8326e", "#6b6a12", "#16798c", "#7a4b34")
COUNT = len(SYMBOLS)


class Look(NamedTuple):
    """Numbers of colour, symbol and line style, each below `COUNT`; hollow: the symbol is not filled."""

    colour: int
    symbol: int
    style: int
    hollow: bool

    @property
    def variable(self) -> str:
        """Colour for plotly.js, by name."""
        return f"@c{self.colour}"

    @property
    def ink(self) -> str:
        """Colour of a paper's figures."""
        return INKS[self.colour]

    @property
    def marker(self) -> str:
        """Symbol for matplotlib."""
        return SYMBOLS[self.symbol][1]

    @property
    def linestyle(self) -> Any:
        """Line style for matplotlib, which counts in line widths."""
        dashes = DASHES[self.style]
        return (0, tuple(0.6 * length for length in dashes)) if dashes else "solid"


def looks(flown: Sequence[tuple[Hashable, str]]) -> list[Look]:
    """Return a look for each contender, given as its laws and its airframe.

    The same laws on another airframe keep colour and symbol, which turns hollow; line styles are all different up to eight.
    """
    airframes = list(dict.fromkeys(airframe for _, airframe in flown))
    seen: list[tuple[Hashable, str]] = []
    families: dict[tuple[Hashable, int], int] = {}
    found = []
    for number, (laws, airframe) in enumerate(flown):
        family = families.setdefault((laws, seen.count((laws, airframe))), len(families))
        seen.append((laws, airframe))
        # Beyond eight, colours return with other symbols.
        symbol = (family + family // COUNT) % COUNT
        found.append(Look(family % COUNT, symbol, number % COUNT, airframes.index(airframe) % 2 == 1))
    return found


def mark(look: Look, x: float = 8.0, y: float = 8.0, size: float = 16.0) -> Markup:
    """Return the symbol of a contender centred at a place inside a drawing."""
    place = f"translate({x - size / 2:.1f} {y - size / 2:.1f}) scale({size / 16:.3g})"
    name = f"mark{' hollow' if look.hollow else ''} c{look.colour}"
    return element("path", d=SYMBOLS[look.symbol][2], transform=place, class_=name)


def sample(look: Look) -> Markup:
    """Return line and symbol of a contender as a small drawing for legends and table heads."""
    dashes = " ".join(f"{length:g}" for length in DASHES[look.style])
    style = {"stroke_dasharray": dashes} if dashes else {}
    line = element("path", d="M1 8h38", class_=f"stroke c{look.colour}", **style)
    parts = join((line, mark(look, 20.0, 8.0, 14.0)))
    return element("svg", parts, class_="icon", viewBox="0 0 40 16", width=40, height=16, aria_hidden="true")


def plotly_marker(look: Look, size: float) -> dict[str, Any]:
    """Return the marker of a contender for plotly.js."""
    symbol = SYMBOLS[look.symbol][0] + ("-open" if look.hollow else "")
    line = {"width": 1.8 if look.hollow else 0, "color": look.variable}
    return {"symbol": symbol, "size": size, "color": look.variable, "line": line}


def plotly_line(look: Look, width: float = 1.8) -> dict[str, Any]:
    """Return the line of a contender for plotly.js."""
    dash = ",".join(f"{length:g}px" for length in DASHES[look.style]) or "solid"
    return {"width": width, "color": look.variable, "dash": dash}
