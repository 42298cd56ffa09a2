"""Set up and run, with nothing but Python 3.11 or newer: make .venv, install this project into it, run a command there.

    python3 bootstrap.py tuner run studies/quickstart.toml
    python3 bootstrap.py pytest
    python3 bootstrap.py docs

The first call installs (a few minutes, mostly downloads); later calls start at once unless pyproject.toml changed.
"""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")
STAMP = VENV / "installed"
# What a command needs beside the project; every other command is one of its development.
EXTRAS = {"tuner": "", "docs": "docs"}
SCRIPTS = {
    "pytest": ["-m", "pytest"],
    "ruff": ["-m", "ruff"],
    "pyright": ["-m", "pyright"],
    "docs": ["docs/generator/build.py"],
}


def main() -> int:
    """Install what is missing, then run the command given."""
    if sys.version_info < (3, 11):  # noqa: UP036  (this file is what an older Python would meet first)
        print(f"Python 3.11 or newer is needed; this is {sys.version.split()[0]}.", file=sys.stderr)
        return 2
    if len(sys.argv) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    command, arguments = sys.argv[1], sys.argv[2:]
    install(EXTRAS.get(command, "test"))
    if command in SCRIPTS:
        return subprocess.call([str(PYTHON), *SCRIPTS[command], *arguments], cwd=ROOT)
    return subprocess.call([str(BIN / command), *arguments])


def install(extra: str) -> None:
    """Make the environment and install the project with an extra, unless that was done for this pyproject.toml."""
    wanted = hashlib.sha256((ROOT / "pyproject.toml").read_bytes()).hexdigest()
    digest, *done = STAMP.read_text().split() if STAMP.exists() else [""]
    if digest != wanted:
        done = []
    elif not extra or extra in done:
        return
    if not PYTHON.exists():
        print(f"Making {VENV.name}", flush=True)
        subprocess.check_call([sys.executable, "-m", "venv", str(VENV)])
    print(f"Installing holdfast{f' with [{extra}]' if extra else ''} into {VENV.name}", flush=True)
    target = f"{ROOT}[{extra}]" if extra else str(ROOT)
    subprocess.check_call([str(PYTHON), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-e", target])
    STAMP.write_text(" ".join([wanted, *done, extra]) + "\n")


if __name__ == "__main__":
    try:
        sys.exit(main())
    except subprocess.CalledProcessError as error:
        print(
            f"Setting up failed: {error}. On Debian and Ubuntu the venv module is the package python3-venv.",
            file=sys.stderr,
        )
        sys.exit(error.returncode or 1)
