"""Figures as they are, and made-up results folders, one for each number of objectives, shared by the tests that only read them."""

from functools import cache

import pytest

from tests.tuner.report.fabricate import fabricate
from tests.undrawn import drawn
from tuner.report import write_report


# Not of the package: without an __init__.py its end is that of the session, and all that follows would be drawn.
@pytest.fixture(scope="module", autouse=True)
def drawn_figures():
    """Have figures drawn as they are; elsewhere they are blank."""
    with drawn():
        yield


@pytest.fixture(scope="session")
def folder_with(tmp_path_factory):
    """A function that returns the results folder of so many objectives; two scenarios where there are three or more."""

    @cache
    def folder_with(objectives):
        scenarios = ("gusts",) if objectives < 3 else ("gusts", "calm air")
        path = fabricate(tmp_path_factory.mktemp("report") / "made-up", objectives=objectives, scenarios=scenarios)
        write_report(path)
        return path

    return folder_with


@pytest.fixture(scope="session", params=[1, 2, 3, 4])
def folder(request, folder_with):
    """A results folder with its report."""
    return folder_with(request.param)
