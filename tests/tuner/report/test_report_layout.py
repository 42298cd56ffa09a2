"""The page at three widths and on paper: nothing is cut, nothing overlaps, and it scrolls sideways inside boxes only.

Skipped where Playwright's Python package or a Chromium is missing.
"""

import pytest

from tests.tuner.extensions.contests.report.fabricate_contest import fabricate as fabricate_contest
from tests.tuner.report.fabricate import fabricate
from tests.tuner.report.screenshots import HEIGHT, browser_path, chromium, offline_page
from tuner.extensions.contests.run import write_contest_report
from tuner.report import write_report

pytest.importorskip("playwright", reason="Playwright's Python package is not installed")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(browser_path() is None, reason="no Chromium is found on this machine"),
]

WIDTHS = (390, 900, 1440)
PAPER = 703
"""Width of A4 within its margins, 186 mm [px]."""
BLOCKS = "header > *, #pins > *, main figure, main table, main h2, main h3, main p, main ul, main dl"
OVERLAPS = """(blocks) => {
  const shown = [...document.querySelectorAll(blocks)].filter((e) => e.checkVisibility() && e.offsetHeight && !e.closest('.hidden'));
  // What a box scrolls is as large as the box.
  const boxes = shown.map((e) => (e.closest('.wide, .tall, pre') ?? e).getBoundingClientRect());
  const apart = (a, b) => a.right <= b.left + 1 || b.right <= a.left + 1 || a.bottom <= b.top + 1 || b.bottom <= a.top + 1;
  const out = [];
  shown.forEach((a, i) => shown.slice(i + 1).forEach((b, k) => {
    const held = a.contains(b) || b.contains(a) || (a.closest('.wide, .tall') ?? a) === b.closest('.wide, .tall');
    if (!held && !apart(boxes[i], boxes[i + 1 + k])) out.push([a.outerHTML.slice(0, 60), b.outerHTML.slice(0, 60)]);
  }));
  return out;
}"""
CUT = """(width) => [...document.querySelectorAll('main table, main figure, header p')]
  .filter((e) => e.checkVisibility() && e.getBoundingClientRect().right > width + 1).map((e) => e.outerHTML.slice(0, 80))"""


@pytest.fixture(scope="module")
def browser():
    with chromium() as started:
        yield started


@pytest.fixture(
    scope="module", params=[pytest.param("two objectives", marks=pytest.mark.slow), "three objectives", "contest"]
)
def report(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("layout") / "made-up"
    if request.param == "contest":
        return write_contest_report(fabricate_contest(folder))
    return write_report(fabricate(folder, objectives=2 if request.param == "two objectives" else 3))


def opened(browser, report, width, address=""):
    page = offline_page(browser, width)
    page.goto(report.resolve().as_uri() + address)
    page.wait_for_selector("html[data-ready]", state="attached")
    page.evaluate("document.querySelectorAll('section > .fold').forEach((fold) => { fold.open = true; })")
    return page


@pytest.fixture(scope="module")
def shared(browser, report):
    """The page as it opens on a phone: its widths follow one another, for loading it takes longer than all that is asked of it."""
    page = opened(browser, report, WIDTHS[0], "#point=p0107&pins=p0103")
    yield page
    page.context.close()


def widened(page, width):
    """Give a page a width and wait until it is laid out for it."""
    page.set_viewport_size({"width": width, "height": HEIGHT})
    page.evaluate("() => new Promise((laid_out) => requestAnimationFrame(() => requestAnimationFrame(laid_out)))")
    return page


@pytest.mark.parametrize("width", WIDTHS)
def test_the_page_never_scrolls_sideways_and_nothing_overlaps(shared, width):
    page = widened(shared, width)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate(OVERLAPS, BLOCKS) == []


@pytest.mark.parametrize("width", [1100, 1280, 1440])
def test_tables_of_answer_and_finalists_are_whole_on_a_wide_screen(shared, width):
    page = widened(shared, width)
    for box in page.query_selector_all("#finalists, .wide:has(> .outcome), .wide:has(> .states), #values .wide"):
        assert box.evaluate("e => e.scrollWidth <= e.clientWidth"), box.inner_html()[:80]


def test_nothing_overlaps_or_is_cut_on_paper(shared, request):
    page = widened(shared, PAPER)
    page.emulate_media(media="print")
    page.evaluate("() => window.dispatchEvent(new Event('beforeprint'))")
    if "contest" not in request.node.callspec.id:
        assert page.locator(".fold:not([open])").count() == 0 and "p0103" in page.inner_text("#pins")
    assert page.evaluate("document.documentElement.scrollWidth") <= PAPER
    assert page.locator(BLOCKS).count() > 30
    assert page.evaluate(OVERLAPS, BLOCKS) == []
    assert page.evaluate(CUT, PAPER) == []
    # A box that hides what overflows cuts a column without being wider itself.
    for box in page.query_selector_all(".wide:has(> .outcome)"):
        assert box.evaluate("e => e.scrollWidth <= e.clientWidth"), box.inner_html()[:80]
    page.evaluate("() => window.dispatchEvent(new Event('afterprint'))")
    page.emulate_media(media="screen")


def test_a_limited_quantity_selects_finalists_and_gets_a_column(browser, tmp_path):
    page = opened(browser, write_report(fabricate(tmp_path / "made-up")), 1440)
    before = page.locator("#finalists .picker").count()
    slider = page.locator("#limit-levels .level-row", has_text="phase margin").locator("input")
    slider.fill("500")
    left = page.locator("#finalists tbody tr")
    assert 0 < left.count() < before
    heads = page.locator("#finalists thead th").all_inner_texts()
    column = next(k for k, text in enumerate(heads) if text.startswith("phase margin"))
    low = float(page.locator("#chips button").inner_text().split(" min ")[1].split()[0])
    cells = [row.locator("th, td").nth(column).inner_text() for row in left.all()]
    # The chip shows three digits.
    assert all(text == "∞" or float(text) >= 0.99 * low for text in cells)
    slider.fill("0")
    assert page.locator("#finalists .picker").count() == before
    page.context.close()
