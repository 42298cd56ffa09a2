"""Settings of Sphinx."""

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

project = "holdfast"
author = "the holdfast developers"
release = version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
html_theme = "furo"
html_title = f"holdfast {release}"
html_copy_source = False
html_show_sourcelink = False

# attrs_inline: anchors inside a line.
myst_enable_extensions = ["attrs_inline"]
# Headings have the anchors that GitHub gives them.
myst_heading_anchors = 4

autodoc_typehints = "description"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "undoc-members": False}
napoleon_google_docstring = True
napoleon_numpy_docstring = False

# Studies in part, and JavaScript for a shell, are no whole programs.
suppress_warnings = ["misc.highlighting_failure"]
