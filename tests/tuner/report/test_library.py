"""The drawing library that pages carry: the scripts as published, and the smaller one where it draws all that a page shows."""

import gzip
import json
import re
from base64 import b64decode
from hashlib import sha256
from importlib.resources import files

import pytest
from plotly.offline import get_plotlyjs

from tuner.report.page import Page, Section, library, scripts
from tuner.text.markup import Markup, element

FOLDER = files("tuner.report").joinpath("plotly")
STATED = dict(
    re.findall(r"^\| `(\S+)` .* \| ([0-9a-f]{64}) \|$", FOLDER.joinpath("README.md").read_text(), re.MULTILINE)
)


def test_scripts_are_those_that_were_published():
    assert {entry.name for entry in FOLDER.iterdir()} == {"LICENSE", "README.md", *STATED} and len(STATED) == 2
    for name, digest in STATED.items():
        assert sha256(gzip.decompress(FOLDER.joinpath(name).read_bytes())).hexdigest() == digest


def test_the_whole_library_is_that_of_the_package_for_python():
    whole = gzip.decompress(b64decode(library(in_space=True))).decode()
    (ours,), (theirs,) = (re.findall(r"plotly\.js v([\d.]+)", script[:200]) for script in (whole, get_plotlyjs()))
    assert ours != theirs or whole == get_plotlyjs()


def test_each_bundle_has_the_kinds_of_traces_that_pages_draw():
    """A bundle registers a kind of trace under its name; `scatter3d` is drawn in the chart `space` alone."""
    drawn = {"bar", "contour", "scatter"}
    assert drawn | {"scatter3d"} >= set(re.findall(r'type: "(scatter\w*|bar|contour)"', scripts()))
    small, whole = (gzip.decompress(b64decode(library(in_space))).decode() for in_space in (False, True))
    for kind in drawn:
        assert f'name:"{kind}"' in small and f'name:"{kind}"' in whole
    assert 'name:"scatter3d"' not in small and 'name:"scatter3d"' in whole


@pytest.mark.parametrize(("chart", "in_space"), [("matrix", False), ("space", True)])
def test_a_page_carries_the_smallest_library_that_draws_it(chart, in_space):
    section = Section("explorer", "Explorer", element("div", id=chart))
    page = Page("tuning", "Title", Markup(), Markup(), [section], {"charts": {"a": {}}})
    assert library(in_space) in page.text() and library(not in_space) not in page.text()
    assert library(in_space) not in page._replace(data=json.loads("{}")).text()
