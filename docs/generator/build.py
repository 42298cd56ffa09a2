"""Build the site into build/docs, with warnings as errors: python3 bootstrap.py docs."""

import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import build_main

ROOT = Path(__file__).resolve().parents[2]
# The program of this checkout is described, whatever is installed.
sys.path.insert(0, str(ROOT))

from accessible import make_accessible  # noqa: E402
from pages import page_list, pages, pictures  # noqa: E402

SOURCE, SITE = ROOT / "build" / "docs_source", ROOT / "build" / "docs"


def main() -> int:
    """Lay out the pages, then build them; return the exit status."""
    for folder in (SOURCE, SITE):
        shutil.rmtree(folder, ignore_errors=True)
    for name, text in pages().items():
        made(SOURCE / name).write_text(text, encoding="utf-8")
    for name, picture in pictures().items():
        shutil.copyfile(picture, made(SOURCE / name))
    status = build_main(["-q", "-W", "--keep-going", "-c", str(Path(__file__).parent), str(SOURCE), str(SITE)])
    if status == 0:
        make_accessible(SITE)
        (SITE / "llms.txt").write_text(page_list(), encoding="utf-8")
        print(f"Documentation: {SITE / 'index.html'}")
    return status


def made(file: Path) -> Path:
    """Return a file whose folder is there."""
    file.parent.mkdir(parents=True, exist_ok=True)
    return file


if __name__ == "__main__":
    sys.exit(main())
