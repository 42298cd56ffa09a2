"""Take the ten pictures of docs/gallery.md: python docs/generator/gallery.py FOLDER [NAME ...]

Runs go into FOLDER; those that are there already stay. Needs a Chromium, and Playwright of the extra `test`.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tests.tuner.report.screenshots import chromium  # noqa: E402

PICTURES = ROOT / "docs" / "images" / "gallery"
LOG = ROOT / "tests/tuner/extensions/logs/crazyflie/log15_70_to_85"
N_COLORS = 96
"""Colors of a picture: a screen with five hues and their smoothed edges needs no more."""
GAP = 24
"""Pixels above the element at the top."""
COMMANDS = {
    "results/quickstart": "run quickstart --out results/quickstart",
    "designed.json": "design quickstart --out designed.json",
    "comparison": "compare results/quickstart designed.json --seeds 256 --out comparison",
    "mine.html": f"identify {LOG} --airframe crazyflie-pybullet --out mine.toml --report mine.html",
}
"""Commands by the file that each writes, in their order."""


class Shot(NamedTuple):
    """A picture: a page below FOLDER or the study of a studio, the element at its top, and the size of the window."""

    page: str
    top: str
    width: int = 1200
    height: int = 800
    scheme: str = "light"


REPORT = "results/quickstart/report.html"
SHOTS = {
    "answer": Shot(REPORT, "body"),
    "explore": Shot(REPORT, "#front h2"),
    "responses": Shot(REPORT, "#point .axis-grid"),
    "loops": Shot(REPORT, "#margins"),
    "reliability": Shot(REPORT, "#trust h2"),
    "phone": Shot(REPORT, "body", 390, 800, "dark"),
    "studio": Shot("studio quickstart", "body", 1440, 900),
    "studio_dark": Shot("studio dc_motor", "body", 1440, 900, "dark"),
    "identification": Shot("mine.html", "#prediction h2"),
    "comparison": Shot("comparison/report.html", "#differences h2"),
}


def main(folder: Path, names: list[str]) -> None:
    """Make the runs, then take the named pictures, or all."""
    folder.mkdir(parents=True, exist_ok=True)
    PICTURES.mkdir(parents=True, exist_ok=True)
    for file, command in COMMANDS.items():
        if not (folder / file).exists():
            subprocess.run([*tuner(), *command.split()], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    with chromium() as browser:
        for name in names or SHOTS:
            file = PICTURES / f"{name}.png"
            take(browser, SHOTS[name], folder, file)
            print(f"{file.relative_to(ROOT)}: {file.stat().st_size // 1000} kB")


def tuner() -> list[str]:
    """Return the words that start the command of this checkout."""
    return [sys.executable, "-m", "tuner"]


def take(browser: Any, shot: Shot, folder: Path, file: Path) -> None:
    """Take one picture and reduce its colors."""
    context = browser.new_context(
        viewport={"width": shot.width, "height": shot.height}, color_scheme=shot.scheme, reduced_motion="reduce"
    )
    page = context.new_page()
    with address_of(shot, folder) as address:
        page.goto(address)
        if shot.page.startswith("studio"):
            page.wait_for_selector("html[data-rest]", state="attached", timeout=180_000)
        # A figure is drawn when it comes into sight, here on the way down.
        page.locator(shot.top).first.evaluate("element => element.scrollIntoView({block: 'start'})")
        page.mouse.wheel(0, -GAP)
        page.wait_for_timeout(1500)
        page.screenshot(path=file)
    context.close()
    Image.open(file).convert("RGB").quantize(N_COLORS).save(file, optimize=True)


@contextmanager
def address_of(shot: Shot, folder: Path) -> Iterator[str]:
    """Give the address of a page; a studio runs until its picture is taken."""
    if not shot.page.startswith("studio"):
        yield (folder / shot.page).resolve().as_uri()
        return
    words = [*tuner(), *shot.page.split(), "--no-browser"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, text=True, env=environment)
    try:
        assert process.stdout is not None
        yield process.stdout.readline().split()[-1]
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
