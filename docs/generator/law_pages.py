"""The page of the control laws: a diagram, equations, gains, and when to use each, from the files of the laws."""

import re
from collections.abc import Callable
from html import escape

from plant.law_registry import LAWS
from plant.laws.law import Blocks, GainInfo, Law, Span
from plant.laws.law_text import law_text

HEAD = """# Laws

Every control law that comes with the tool, generated from the files of the laws. `tuner list laws NAME` prints the same
equations and gains in a terminal; [what there is to choose from](choices.md#control-laws) has all gains in one table, and
[a law of your own](how_to/add_a_law.md) is a file.

A law moves one output `y` of `y'' = f + b0 u`: an axis of a quadrotor, or a channel of a plant of one's own.

| symbol | meaning |
|---|---|
| `r`, `r'`, `r''` | reference with its first and second derivative |
| `y`, `y'` | measurement and its rate |
| `u` | command; an observer is fed with what the actuators delivered of it |
| `b0` | second derivative of `y` for one unit of `u`, as the controller believes it |
| `f` | total disturbance: all of `y''` that is not `b0 u` |
| `z1`, `z2`, `z3` | estimates of `y`, `y'` and `f` by an extended state observer (ESO) |
| `h` | control period; `v+` is the value after it |
| `sgn`, `sat` | sign, and the sign that is linear between -1 and 1 |

Equations are in continuous time where they have derivatives; *sampled* says how each becomes a difference equation. Ranges are
those that a search walks where a study gives none, for attitude loops (`y` in rad) and position loops (`y` in m).
"""
PROMISES = {
    "tracks": "a reference that the channel can fly leaves no error",
    "rejects": "a constant disturbance leaves no error",
}
MARKUP = re.compile(r"(`[^`]*`)|([\\*_\[\]<>#|])")
# Sizes of a diagram: of a letter, a block, a gap, and the heights of its two rows.
LETTER, PADDING, GAP, HEIGHT, FORTH, BACK = 8, 20, 46, 36, 40, 116


def laws_page(table: Callable[..., str]) -> str:
    """Return the page, a section for each law; table: what makes a Markdown table of a head and rows."""
    return "\n".join([HEAD, *(section(law, table) for law in LAWS.values())])


def section(law: Law, table: Callable[..., str]) -> str:
    """Return diagram, equations, use, gains and source of one law."""
    text = law_text(law)
    promises = "; ".join(PROMISES[name] for name in sorted(law.promises)) or "nothing"
    facts = [("Keeps", promises), ("Sampled", law.discretisation), ("Source", law.source)]
    parts = [
        f"## {law.name}",
        plain(text.about),
        diagram(law.blocks),
        f"```text\n{text.equations}\n```",
        plain(text.use),
        table(("gain", "symbol", "unit", "attitude", "position", "meaning"), map(gain_row, law.gains)).strip(),
        *map(plain, text.remarks),
        "\n".join(f"- {name}: {plain(fact)}" for name, fact in facts),
    ]
    return "\n\n".join(parts) + "\n"


def gain_row(gain: GainInfo) -> tuple[str, ...]:
    """Return name, symbol, unit, default and range in both loops, and meaning of a gain."""
    name = gain.name.rstrip("_")
    unit = gain.unit.replace("{y}", "y")
    return f"`{name}`", f"`{gain.symbol}`", unit, spanned(gain.attitude), spanned(gain.position), gain_meaning(gain)


def gain_meaning(gain: GainInfo) -> str:
    """Return the meaning of a gain, and the term that 0 turns off."""
    return gain.meaning + (f"; 0 turns the {gain.term} off" if gain.term else "")


def spanned(span: Span) -> str:
    """Return a default with its range."""
    return f"{span.default:g} ({span.low:g} to {span.high:g})"


def plain(text: str) -> str:
    """Return a text without Markdown's own signs, but for code in backticks."""
    return MARKUP.sub(lambda match: match[1] or f"\\{match[2]}", text)


def diagram(blocks: Blocks) -> str:
    """Return the block diagram of a loop under a law as SVG, in the color of the text around it."""
    forth, x = list[tuple[str, int, int]](), 40
    for label in filter(None, (blocks.reference, blocks.feedback, "actuators, plant")):
        forth.append((label, x + GAP, LETTER * len(label) + PADDING))
        x = forth[-1][1] + forth[-1][2]
    law, plant = forth[-2:]
    left, right, command = law[1] + law[2] // 2, x + GAP // 2, plant[1] - GAP // 2
    drawn = [line((20, FORTH), (forth[0][1], FORTH)), word("r", 12, FORTH), word("y", x + GAP + 8, FORTH)]
    drawn += [
        line((before[1] + before[2], FORTH), (after[1], FORTH)) for before, after in zip(forth, forth[1:], strict=False)
    ]
    drawn += [box(label, start, width, FORTH) for label, start, width in forth]
    drawn += [word("u", command, FORTH - 12), line((x, FORTH), (x + GAP, FORTH))]
    if blocks.measured:
        width = LETTER * len(blocks.measured) + PADDING
        start = max(left + GAP, min(command, right - GAP) - width)
        drawn += [box(blocks.measured, start, width, BACK), line((right, FORTH), (right, BACK), (start + width, BACK))]
        drawn.append(line((start, BACK), (left, BACK), (left, FORTH + HEIGHT // 2)))
        if blocks.takes_command:
            taken = min(command, start + width - PADDING // 2)
            drawn.append(
                line((command, FORTH), (command, FORTH + HEIGHT), (taken, FORTH + HEIGHT), (taken, BACK - HEIGHT // 2))
            )
    else:
        drawn.append(line((right, FORTH), (right, BACK), (left, BACK), (left, FORTH + HEIGHT // 2)))
    head = f'<svg viewBox="0 0 {x + GAP + 24} {BACK + HEIGHT}" role="img" fill="none" stroke="currentColor"'
    title = f"<title>{escape(', '.join(filter(None, (blocks.reference, blocks.feedback, blocks.measured))))}</title>"
    return "\n".join([f'{head} style="max-width: {x + GAP + 24}px">', title, *drawn, "</svg>"])


def box(label: str, x: int, width: int, y: int) -> str:
    """Return a block of a diagram with its label; y: its middle."""
    frame = f'<rect x="{x}" y="{y - HEIGHT // 2}" width="{width}" height="{HEIGHT}"/>'
    return frame + word(label, x + width // 2, y)


def word(text: str, x: int, y: int) -> str:
    """Return a text of a diagram around a point."""
    style = 'text-anchor="middle" font-size="14" fill="currentColor" stroke="none"'
    return f'<text x="{x}" y="{y + 5}" {style}>{escape(text)}</text>'


def line(*points: tuple[int, int]) -> str:
    """Return an arrow along points."""
    (x0, y0), (x, y) = points[-2:]
    along = (x > x0) - (x < x0), (y > y0) - (y < y0)
    # The tip: two strokes back from the end, to either side.
    tips = [(x - 7 * along[0] + side * along[1], y - 7 * along[1] + side * along[0]) for side in (4, -4)]
    path = " L".join(f"{a} {b}" for a, b in points)
    return f'<path d="M{path} M{tips[0][0]} {tips[0][1]} L{x} {y} L{tips[1][0]} {tips[1][1]}"/>'
