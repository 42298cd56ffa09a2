"""Pictures of a report at three widths, light and dark: `python -m tests.tuner.report.screenshots RESULTS OUT`.

Needs Playwright's Python package (in the extra `test`) and a Chromium on the machine; the network is blocked. Writes
OUT/WIDTH-SCHEME.png of the whole page and OUT/SECTION-WIDTH-SCHEME.png of each section.
"""

import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from plant.errors import InputError, ToolError

WIDTHS = {"phone": 390, "tablet": 820, "wide": 1440}
SCHEMES = ("light", "dark")
HEIGHT = 1000
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def browser_path() -> str | None:
    """Return the path of a Chromium on this machine, None where there is none."""
    return next((path for name in BROWSERS if (path := shutil.which(name))), None)


@contextmanager
def chromium() -> Iterator[Any]:
    """Start a headless Chromium; raises InputError where there is none, or no Playwright."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        raise InputError("Playwright is missing; install it with: pip install playwright") from None
    path = browser_path()
    if path is None:
        raise InputError(f"no browser is found; looked for {', '.join(BROWSERS)}")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        try:
            yield browser
        finally:
            browser.close()


def offline_page(browser: Any, width: int, height: int = HEIGHT, scheme: str = "light") -> Any:
    """Return an empty page without network, whose every request but for files is refused."""
    # Pages then jump where they would scroll smoothly, for seconds where they are as long as on a phone.
    context = browser.new_context(
        viewport={"width": width, "height": height},
        color_scheme=scheme,
        offline=True,
        accept_downloads=True,
        reduced_motion="reduce",
    )
    page = context.new_page()
    page.route(lambda address: not address.startswith(("file:", "blob:", "data:")), lambda route: route.abort())
    return page


def take(report: Path, out: Path) -> list[Path]:
    """Take all pictures of a report and return their files."""
    out.mkdir(parents=True, exist_ok=True)
    files = []
    with chromium() as browser:
        for name, width in WIDTHS.items():
            for scheme in SCHEMES:
                page = offline_page(browser, width, scheme=scheme)
                page.goto(report.resolve().as_uri())
                page.wait_for_selector("html[data-ready]", state="attached")
                files += pictures(page, out, f"{name}-{scheme}")
                page.context.close()
    return files


def pictures(page: Any, out: Path, name: str) -> list[Path]:
    """Take pictures of every section, and of the whole page once all of its figures have come into sight."""
    files = []
    for section in page.query_selector_all("main > section"):
        for part in [section, *section.query_selector_all("figure")]:
            part.scroll_into_view_if_needed()
            page.wait_for_timeout(60)
        page.wait_for_timeout(300)
        files.append(out / f"{section.get_attribute('id')}-{name}.png")
        section.screenshot(path=files[-1])
    files.append(out / f"{name}.png")
    page.screenshot(path=files[-1], full_page=True)
    return files


def main(arguments: list[str]) -> int:
    """Run the command."""
    if len(arguments) != 2:
        print("usage: python -m tests.tuner.report.screenshots RESULTS OUT", file=sys.stderr)
        return 2
    results, out = (Path(argument) for argument in arguments)
    try:
        report = results / "report.html"
        if not report.exists():
            raise InputError("there is no report.html; write it with `tuner report`", file=results)
        print(f"{len(take(report, out))} pictures in {out}")
    except ToolError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
