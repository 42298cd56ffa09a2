"""Settings of Sphinx."""

import re
import sys
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

project = "gainproof"
author = "the gainproof developers"
release = version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
html_theme = "furo"
html_title = f"gainproof {release}"
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False

# attrs_inline: anchors inside a line.
myst_enable_extensions = ["attrs_inline"]
# Headings have the anchors that GitHub gives them.
myst_heading_anchors = 4

autodoc_typehints = "description"
autodoc_member_order = "bysource"
# Names in single backticks are code.
default_role = "code"
STAR = re.compile(r"(`[^`]*`)|\*")
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

# Studies in part, and JavaScript for a shell, are no whole programs.
suppress_warnings = ["misc.highlighting_failure"]


def setup(app: Any) -> None:
    """Connect what is done to docstrings before napoleon reads them."""
    app.connect("autodoc-process-docstring", keep_literal, priority=400)


def keep_literal(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Keep stars from being read as emphasis, and what stands before the colon of a property from being read as its type."""
    for i, line in enumerate(lines):
        if not line.lstrip().startswith((">>>", "...")):
            lines[i] = STAR.sub(lambda found: found[1] or r"\*", line)
    if what in ("property", "attribute"):
        lines.insert(0, "\\ ")
