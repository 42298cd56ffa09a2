"""A law in words: the parts of the docstring of its file.

Lines that are indented there are equations, a paragraph that begins with "Use it" says when, and what is left are remarks.
"""

from dataclasses import dataclass
from inspect import cleandoc

from plant.laws.law import Law

USE = "Use it "


@dataclass(frozen=True)
class LawText:
    """The parts of a law's docstring.

    Each is empty where there is none; equations keep their lines.
    """

    about: str
    equations: str
    use: str
    remarks: tuple[str, ...]


def law_text(law: Law) -> LawText:
    """Return the text of a law's file in parts."""
    about, *paragraphs = cleandoc(_docstring(law)).split("\n\n")
    equations = "\n".join(cleandoc(f"\n{part}") for part in paragraphs if part.startswith(" "))
    prose = [" ".join(part.split()) for part in paragraphs if not part.startswith(" ")]
    use = "".join(part for part in prose if part.startswith(USE))
    return LawText(" ".join(about.split()), equations, use, tuple(part for part in prose if not part.startswith(USE)))


def _docstring(law: Law) -> str:
    """Return the docstring of the file that defines a law.

    A law that varies another one shares functions with the file of that one.
    """
    plain = law.plain or law
    for function in (plain.prepare, plain.start, plain.step):
        names = getattr(function, "__globals__", {})
        if getattr(names.get("LAW"), "name", None) == plain.name:
            return names.get("__doc__") or ""
    return ""
