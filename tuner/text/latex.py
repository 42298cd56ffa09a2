"""Tables of texts as LaTeX, for papers: `tabular` with the rules of the package booktabs.

Text is hostile until it is escaped: a name of a study or of a gain cannot hold a command. Mathematics are made of the letters
that tables here hold: minus, thin space, powers, degrees, Greek.
"""

import re
from collections.abc import Collection, Sequence

PACKAGE = "booktabs"
_RAISED = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"
_PLAIN = str.maketrans(_RAISED, "-0123456789")
_POWER = re.compile(rf"\^\(([-\d/]+)\)|\^(-?\d+)|([{_RAISED}]+)")
_ESCAPES = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    '"': "''",
    "<": "$<$",
    ">": "$>$",
    "|": "$|$",
    "−": "$-$",
    "–": "--",
    "\u202f": r"\,",
    "×": r"$\times$",
    "·": r"$\cdot$",
    "°": r"$^{\circ}$",
    "≤": r"$\le$",
    "≥": r"$\ge$",
    "√": r"$\surd$",
    "µ": r"$\mu$",
    "∞": r"$\infty$",
    **{letter: f"\\{letter}" for letter in "{}$&#_%"},
}


def latex_table(title: str, head: Sequence[str], rows: Sequence[Sequence[str]], words: Collection[str]) -> str:
    """Return a table as a tabular environment.

    Args:
        title: A comment above it.
        head: Names of the columns.
        rows: Texts of the cells.
        words: Columns that begin at the left; the others end at the right.

    """
    columns = "".join("l" if name in words else "r" for name in head)
    lines = [
        f"% {' '.join(title.split())}; needs \\usepackage{{{PACKAGE}}}",
        f"\\begin{{tabular}}{{{columns}}}",
        r"\toprule",
        _row(head),
        r"\midrule",
        *map(_row, rows),
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(lines)


def latex_text(text: str) -> str:
    """Return a text as LaTeX, every character that steers LaTeX escaped."""
    parts = _POWER.split(text)
    # Of each match, the three groups of which one holds the power.
    plain, powers = parts[::4], list(zip(parts[1::4], parts[2::4], parts[3::4], strict=True))
    out = ["".join(_ESCAPES.get(letter, letter) for letter in plain[0])]
    for groups, rest in zip(powers, plain[1:], strict=True):
        power = next(group for group in groups if group).translate(_PLAIN)
        out += [f"$^{{{power}}}$", *(_ESCAPES.get(letter, letter) for letter in rest)]
    return "".join(out)


def _row(cells: Sequence[str]) -> str:
    text = " & ".join(map(latex_text, cells))
    # Behind the end of a row, "[" would begin an optional argument.
    return f"{'{}' if text.startswith('[') else ''}{text} \\\\"
