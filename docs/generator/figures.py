"""Make the runs that pages report and write their tables: python docs/generator/figures.py [--check] [RUN ...]

A table is between `<!-- figures NAME -->` and `<!-- end -->`. Runs named on the command line are made alone. With --check pages
stay as they are, and numbers that differ by more than the tolerance end it with exit code 1.
"""

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from figure_tables import ROOT, TABLES, Listing, Table

TOLERANCE = 0.05
"""Largest relative difference of a number; searches of another processor may end at a neighbor of the same front."""
NUMBER = re.compile(r"-?\d+(?:,\d{3})*(?:\.\d+)?")
FILES = {
    "log15": "tests/tuner/extensions/logs/crazyflie/log15_70_to_85",
    "racer5.toml": "plant/quadrotor/airframes/racer5.toml",
    "studies": "studies",
}
"""Files of the repository that commands name."""


def make(table: Table | Listing, folder: Path) -> None:
    """Make the runs of a table in a folder; those that are there already stay."""
    for name, source in FILES.items():
        if not (folder / name).exists():
            (folder / name).symlink_to(ROOT / source)
    write_files(table.page, folder)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = folder / ".done"
    made = done.read_text().splitlines() if done.exists() else []
    for command in table.commands:
        if command not in made:
            environment = {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}
            line = command.replace("{folder}", str(folder))
            subprocess.run(line, shell=True, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
            with done.open("a") as file:
                file.write(f"{command}\n")


def write_files(page: str, folder: Path) -> None:
    """Write the files that a page shows and says to be there from the start."""
    text = (ROOT / page).read_text(encoding="utf-8")
    for name, content in re.findall(r"^`([\w.]+)`[^\n`]*:\n\n```\w+\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        (folder / name).write_text(content, encoding="utf-8")


def marked(name: str) -> re.Pattern[str]:
    """Return the pattern of a table between its marks."""
    return re.compile(rf"(?<=<!-- figures {name} -->\n).*?(?=<!-- end -->)", re.DOTALL)


def differs(before: str, after: str) -> bool:
    """Return True where two tables differ in words, or in a number by more than the tolerance."""
    if NUMBER.sub("#", before) != NUMBER.sub("#", after):
        return True
    pairs = zip(*([float(x.replace(",", "")) for x in NUMBER.findall(text)] for text in (before, after)), strict=True)
    return any(abs(a - b) > TOLERANCE * max(abs(a), abs(b)) for a, b in pairs)


def update(table: Table | Listing, folder: Path, check: bool) -> bool:
    """Write a table into its page, or only compare; return True where it differs."""
    page = ROOT / table.page
    text = page.read_text(encoding="utf-8")
    match = marked(table.name).search(text)
    if match is None:
        raise SystemExit(f"{table.page} has no marks for {table.name}")
    after = "\n" + "\n".join(table.lines(folder)) + "\n\n"
    if not check:
        page.write_text(text[: match.start()] + after + text[match.end() :], encoding="utf-8")
    return differs(match[0], after)


def main() -> int:
    """Make the runs, write or compare the tables; return the exit status."""
    parser = argparse.ArgumentParser(description="Write the tables of pages from runs.")
    parser.add_argument("names", nargs="*", metavar="RUN", help=f"of {', '.join(table.name for table in TABLES)}")
    parser.add_argument("--check", action="store_true", help="compare, and write nothing")
    parser.add_argument("--folder", type=Path, help="where runs are made, or are already")
    given = parser.parse_args()
    with TemporaryDirectory() as temporary:
        folder = (given.folder or Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        status = 0
        for table in TABLES:
            if not given.names or table.name in given.names:
                make(table, folder)
                other = update(table, folder, given.check)
                print(f"{table.page}: {table.name} {'differs' if other else 'holds'}", flush=True)
                status |= given.check and other
    return int(status)


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    sys.exit(main())
