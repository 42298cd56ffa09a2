"""The page in a real browser: by keyboard alone from opening to a saved file, undo, pins, hostile names, a server that ends.

Skipped where Playwright's Python package or a Chromium is missing.
"""

import json
import subprocess
import sys

import pytest

from tests.tuner.extensions.studio.conftest import STUDIES
from tests.tuner.report.screenshots import browser_path, chromium

pytest.importorskip("playwright", reason="Playwright's Python package is not installed")
pytestmark = pytest.mark.skipif(browser_path() is None, reason="no Chromium is found on this machine")
HOSTILE = "<img src=x onerror='alert(1)'>"


@pytest.fixture(scope="module")
def browser():
    with chromium() as started:
        yield started


class Reader:
    """The page of a studio; `complaints`: errors of its scripts, and requests to other places."""

    def __init__(self, browser, client, width=1440, fragment="", scheme="light"):
        self.context = browser.new_context(
            viewport={"width": width, "height": 900}, color_scheme=scheme, reduced_motion="reduce"
        )
        self.page, self.complaints = self.context.new_page(), []
        self.page.on(
            "console", lambda message: self.complaints.append(message.text) if message.type == "error" else None
        )
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("dialog", lambda dialog: (self.complaints.append(dialog.message), dialog.dismiss()))
        origin = client.door.origin
        self.page.on(
            "request",
            lambda made: None if made.url.startswith((origin, "data:")) else self.complaints.append(made.url),
        )
        self.page.goto(client.door.address)
        if fragment:
            self.page.goto(f"{origin}/#{fragment}")
            self.page.reload()
        self.page.wait_for_selector("html[data-ready]", state="attached", timeout=60_000)
        self.rest()

    def rest(self):
        """Wait until the last request is answered with all flights."""
        self.page.wait_for_selector("html[data-rest]", state="attached", timeout=60_000)

    def close(self):
        self.context.close()
        assert self.complaints == []


@pytest.fixture
def reader(browser, client):
    made = Reader(browser, client)
    yield made
    made.close()


@pytest.fixture(scope="module")
def opened(browser, motor):
    """A page for tests that begin wherever an earlier one left it."""
    made = Reader(browser, motor[1])
    yield made
    made.close()


def here(reader):
    """Cells of the setting at hand."""
    return reader.page.eval_on_selector_all(
        "#table tbody tr:not(.group)", "rows => rows.map((row) => row.cells[1].innerText)"
    )


def test_a_key_on_a_slider_moves_numbers_and_charts_and_undo_takes_them_back(reader):
    page = reader.page
    before = here(reader)
    drawn = page.evaluate(
        "JSON.stringify(document.getElementById('response-0').data.map((trace) => trace.y.slice(0, 50)))"
    )
    page.focus("#slider-0")
    page.keyboard.press("PageUp")
    reader.rest()
    assert here(reader) != before
    assert drawn != page.evaluate(
        "JSON.stringify(document.getElementById('response-0').data.map((trace) => trace.y.slice(0, 50)))"
    )
    page.keyboard.press("Control+z")
    reader.rest()
    assert here(reader) == before and page.is_disabled("#undo") and not page.is_disabled("#redo")


PATHS = "[...document.querySelectorAll('#response-0 .js-line')].map((line) => line.getAttribute('d'))"
MOVE = """at => { const slider = document.getElementById('slider-0'); slider.value = String(at);
slider.dispatchEvent(new Event('input', { bubbles: true })); }"""


@pytest.mark.slow
def test_lines_follow_the_hand_before_the_charts_are_drawn_in_full(opened):
    page = opened.page
    before, number = page.evaluate(PATHS), page.evaluate("document.documentElement.dataset.answered")
    page.evaluate(MOVE, 700)
    while page.evaluate("document.documentElement.dataset.answered") == number:
        page.wait_for_timeout(5)
    moved = page.evaluate(PATHS)
    # The setting at hand is drawn last: its median moves, the default's and the reference stay.
    assert len(moved) == len(before)
    changed = [old != new for old, new in zip(before, moved, strict=True)]
    assert any(changed) and not all(changed)
    opened.rest()


def test_the_slider_of_a_rule_moves_the_gains_together(reader):
    page = reader.page
    before = [page.input_value(f"#field-{i}") for i in range(3)]
    page.focus("#design-time")
    page.keyboard.press("PageDown")
    reader.rest()
    page.wait_for_selector("#undo:not([disabled])")
    after = [page.input_value(f"#field-{i}") for i in range(3)]
    assert after[0] != before[0] and "the range ends at" in page.inner_text("#design")
    page.keyboard.press("Control+z")
    reader.rest()
    assert [page.input_value(f"#field-{i}") for i in range(3)] == before


@pytest.mark.slow
def test_many_moves_end_with_the_answer_to_the_last(reader, client):
    page = reader.page
    for i in range(200):
        page.evaluate(MOVE, 300 + i)
    reader.rest()
    value = float(page.input_value("#field-0"))
    last = client.lines("/answer", {"number": 1, "page": "check", "values": {"angle.kp": value}})[-1]
    assert here(reader)[0].split("\n")[0] == last["rows"][0]["here"][0]


def test_from_opening_to_a_saved_file_by_keys_alone(reader, out):
    page = reader.page
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    page.focus("#field-0")
    page.keyboard.press("Control+a")
    page.keyboard.type("17.5")
    page.keyboard.press("Tab")
    reader.rest()
    page.get_by_label("File", exact=True).fill("keys.json")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    page.wait_for_selector("text=Written:")
    assert json.loads((out / "keys.json").read_text())["gains"]["angle.kp"]["value"] == 17.5


def test_a_field_beyond_the_range_is_refused_in_a_sentence(opened):
    page = opened.page
    page.fill("#field-0", "600")
    page.keyboard.press("Tab")
    assert "angle.kp: given 600; allowed: 1 to 60" in page.inner_text("#notice")
    assert page.get_attribute("#field-0", "aria-invalid") == "true"


@pytest.mark.slow
def test_the_address_holds_setting_and_pins_and_names_are_text(browser, client):
    reader = Reader(browser, client, fragment=f"at=20,10,0.2&scenario=0&loop=angle&pin=5,10,0.2;{HOSTILE}&pin=nonsense")
    page = reader.page
    assert page.input_value("#field-0") == "20"
    assert page.input_value(".pin .text-field") == HOSTILE[:40] and page.locator(".pin").count() == 1
    assert page.locator("img").count() == 0
    page.click("text=Remove")
    assert page.locator(".pin").count() == 0 and "pin=" not in page.url
    reader.close()


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_shows_all_without_scrolling_sideways(browser, client, scheme):
    reader = Reader(browser, client, width=390, scheme=scheme)
    assert reader.page.evaluate("document.documentElement.scrollWidth") == 390
    unlabelled = "all => all.filter((one) => !(one.labels?.length || one.getAttribute('aria-label'))).map((one) => one.outerHTML)"
    assert reader.page.eval_on_selector_all("input, select", unlabelled) == []
    reader.close()


@pytest.mark.slow
def test_an_address_beyond_a_range_is_refused_in_a_sentence(browser, client):
    context = browser.new_context()
    page = context.new_page()
    page.goto(client.door.address)
    page.goto(f"{client.door.origin}/#at=600,10,0.2")
    page.reload()
    page.wait_for_selector("#notice:not([hidden])", timeout=60_000)
    assert "angle.kp: given 600; allowed: 1 to 60" in page.inner_text("#notice")
    page.click("text=Default")
    page.wait_for_selector("html[data-rest]", state="attached", timeout=60_000)
    assert page.is_hidden("#notice")
    context.close()


@pytest.mark.slow
def test_two_browsers_on_one_studio_hold_their_own_settings(browser, client, reader):
    other = Reader(browser, client, fragment="at=20,10,0.2")
    before = here(reader)
    for page, value in ((other.page, "33"), (reader.page, "12")):
        page.fill("#field-0", value)
        page.keyboard.press("Tab")
    for each in (other, reader):
        each.rest()
    assert other.page.input_value("#field-0") == "33" and reader.page.input_value("#field-0") == "12"
    assert here(reader) != before and here(reader) != here(other)
    reader.page.keyboard.press("Control+z")
    reader.rest()
    assert here(reader) == before and other.page.input_value("#field-0") == "33"
    other.close()


@pytest.mark.slow
def test_a_killed_server_is_reported_on_the_page(browser, tmp_path):
    command = [sys.executable, "-m", "tuner", "studio", str(STUDIES / "dc_motor.toml"), "--no-browser"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, encoding="utf-8") as process:
        assert process.stdout is not None
        context = browser.new_context()
        page = context.new_page()
        page.goto(process.stdout.readline().split()[-1])
        page.wait_for_selector("html[data-rest]", state="attached", timeout=60_000)
        process.kill()
    page.focus("#slider-0")
    page.keyboard.press("ArrowRight")
    page.wait_for_selector("#notice:not([hidden])")
    assert "Start it again with `tuner studio`" in page.inner_text("#notice")
    context.close()
