"""Made-up contest folders with their pages, shared by the tests that only read them."""

import pytest

from tests.tuner.extensions.contests.report.fabricate_contest import ALL, Made, fabricate
from tests.undrawn import drawn
from tuner.extensions.contests.run import write_contest_report

KINDS = {
    "three tuned": Made(),
    "two airframes": Made(names=ALL),
    "three objectives": Made(objectives=3),
    "one contender, one objective": Made(names=ALL[1:2], objectives=1),
    "given": Made(names=ALL[1:4], tuned=False),
}


# Not of the package: without an __init__.py its end is that of the session, and all that follows would be drawn.
@pytest.fixture(scope="module", autouse=True)
def drawn_figures():
    """Have figures drawn as they are; elsewhere they are blank."""
    with drawn():
        yield


@pytest.fixture(scope="session", params=list(KINDS.values()), ids=list(KINDS))
def folder(request, tmp_path_factory):
    """A contest folder with its report; nobody may write into it."""
    path = fabricate(tmp_path_factory.mktemp("contest") / "made-up", request.param)
    write_contest_report(path)
    return path


@pytest.fixture
def made(tmp_path):
    """A contest folder of one's own, without a report."""
    return fabricate(tmp_path / "made-up")
