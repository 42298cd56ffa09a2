"""Sources of the product, and the nodes of their trees, for the tests that read code."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = "plant", "objectives", "tuner"


def sources(*packages: str, pattern: str = "") -> Iterator[tuple[str, str]]:
    """Yield name and text of each source file in which a pattern matches.

    A file without the words that a test looks for is not parsed: that takes most of its time.
    """
    search = re.compile(pattern).search
    for package in packages or PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            text = path.read_text(encoding="utf-8")
            if search(text):
                yield path.relative_to(ROOT).as_posix(), text


def walk(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all nodes of a tree, as `ast.walk` does, in a third of its time."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        for value in vars(node).values():
            kind = type(value)
            # Most values are names and places, which are recognized faster by their type.
            if kind is list:
                waiting += [part for part in value if isinstance(part, ast.AST)]
            elif kind is not int and kind is not str and isinstance(value, ast.AST):
                waiting.append(value)
