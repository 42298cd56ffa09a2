"""A report as a reader's machine sees it: its elements, its text, its embedded figures."""

import base64
import gzip
import json
from html.parser import HTMLParser
from typing import Any

import numpy as np

VOID = {"meta", "br", "input", "link", "img"}


class Page(HTMLParser):
    """Elements (tag, attributes, enclosing tags), visible text, and the content of script elements; checks nesting."""

    def __init__(self, source):
        super().__init__()
        self.open, self.elements, self.words, self.scripts = [], [], [], []
        self.feed(source)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs), tuple(self.open)))
        if tag == "script":
            self.scripts.append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes <{self.open[-1:]}>"
        self.open.pop()

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            self.scripts[-1] += data
        elif not self.open or self.open[-1] != "style":
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())

    @property
    def ids(self):
        return [attrs["id"] for _, attrs, _ in self.elements if "id" in attrs]

    @property
    def library(self):
        """The drawing library, unpacked; there is one."""
        (packed,) = (script for script in self.scripts if script.startswith("H4sI"))
        return gzip.decompress(base64.b64decode(packed)).decode()

    @property
    def data(self):
        return json.loads(next(script for script in self.scripts if script.startswith("{")))


def read(folder):
    return Page((folder / "report.html").read_text(encoding="utf-8"))


def strings(value):
    """Every text inside nested lists and dictionaries."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for entry in value.values():
            yield from strings(entry)
    elif isinstance(value, list):
        for entry in value:
            yield from strings(entry)


def array_of(stored):
    """An array of the page as its scripts unpack it."""
    if isinstance(stored, list):
        return stored
    if isinstance(stored, str):
        return np.frombuffer(base64.b64decode(stored), dtype="<f4").tolist()
    low, step = stored["scale"]
    return (low + step * np.frombuffer(base64.b64decode(stored["packed"]), dtype="<u2")).tolist()


def resolved(value: Any, shared: Any) -> Any:
    """Stand in for js/06_charts.js: names become grey, or arrays."""
    if isinstance(value, str):
        if value.startswith("@"):
            return "#888888"
        return array_of(shared[value[1:]]) if value.startswith("#a") and value[1:] in shared else value
    if isinstance(value, list):
        return [resolved(entry, shared) for entry in value]
    if isinstance(value, dict):
        if "zip" in value:
            return list(zip(*[array_of(shared[name[1:]]) for name in value["zip"]], strict=True))
        return {key: resolved(entry, shared) for key, entry in value.items()}
    return value
