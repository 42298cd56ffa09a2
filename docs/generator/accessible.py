"""Mend what the theme's pages lack for keyboards and screen readers, as axe-core finds it."""

import re
from pathlib import Path

CHANGES = (
    # The theme's captions of the navigation have the role of a heading without its level.
    (r'<p class="caption" role="heading">', '<p class="caption" role="heading" aria-level="2">'),
    (r'<aside class="sidebar-drawer">', '<aside class="sidebar-drawer" aria-label="Pages">'),
    (r'<aside class="toc-drawer', '<aside aria-label="On this page" class="toc-drawer'),
    # A block wider than the page scrolls, so a keyboard has to reach it.
    (r"<pre>", '<pre tabindex="0">'),
    (r'<div class="table-wrapper', '<div tabindex="0" class="table-wrapper'),
    (r'(<th class="head[^"]*">)<p></p></th>', r'\1<p class="visually-hidden">row</p></th>'),
    (r'<div id="search-results"></div>', '<h1>Search</h1>\n<div id="search-results"></div>'),
)
"""Patterns of the theme's HTML with their replacements."""


def accessible(html: str) -> str:
    """Return a page of the site with levels, names and focus."""
    for pattern, replacement in CHANGES:
        html = re.sub(pattern, replacement, html)
    return html


def make_accessible(site: Path) -> None:
    """Rewrite all pages of a built site."""
    for file in site.rglob("*.html"):
        file.write_text(accessible(file.read_text(encoding="utf-8")), encoding="utf-8")
