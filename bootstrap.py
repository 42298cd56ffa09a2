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
LOCKS = {"tuner": "core.txt"}
"""Packages of a command, by their versions and hashes; every other command is one of development."""
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
    install(LOCKS.get(command, "develop.txt"))
    if command in SCRIPTS:
        return subprocess.call([str(PYTHON), *SCRIPTS[command], *arguments], cwd=ROOT)
    return subprocess.call([str(BIN / command), *arguments])


def install(lock: str) -> None:
    """Make the environment with the packages of a lock file, unless that was done for these very files.

    Packages are those whose hashes stand in `requirements/`; the project itself comes from this folder, in place.
    """
    installed = STAMP.read_text().split() if STAMP.exists() else []
    # The packages of development hold those of the command.
    if digest(lock) in installed or digest("develop.txt") in installed:
        return
    if not PYTHON.exists():
        print(f"Making {VENV.name}", flush=True)
        subprocess.check_call([sys.executable, "-m", "venv", str(VENV)])
    print(f"Installing the packages of requirements/{lock} into {VENV.name}", flush=True)
    pip = [str(PYTHON), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.check_call([*pip, "--require-hashes", "-r", str(ROOT / "requirements" / lock)])
    subprocess.check_call([*pip, "--no-deps", "--no-build-isolation", "-e", str(ROOT)])
    STAMP.write_text(digest(lock) + "\n")


def digest(lock: str) -> str:
    """Return the digest of a lock file with the project's own requirements."""
    files = (ROOT / "pyproject.toml", ROOT / "requirements" / lock)
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


if __name__ == "__main__":
    try:
        sys.exit(main())
    except subprocess.CalledProcessError as error:
        print(
            f"Setting up failed: {error}. On Debian and Ubuntu the venv module is the package python3-venv.",
            file=sys.stderr,
        )
        sys.exit(error.returncode or 1)
