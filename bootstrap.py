"""Set up and run, with nothing but Python 3.11 to 3.14: make .venv, install this project into it, run a command there.

    python3 bootstrap.py tuner run studies/quickstart.toml
    python3 bootstrap.py pytest
    python3 bootstrap.py docs

The first call downloads and installs 300 MB; later calls start at once unless the lock files changed. uv installs the packages:
the one on the machine, else one that pip brings, else pip installs them itself. TUNER_VENV names another folder than .venv.
"""

import hashlib
import os
import platform
import shutil
import ssl
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = Path(os.environ.get("TUNER_VENV") or ROOT / ".venv").absolute()
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")
STAMP = VENV / "installed"
BROUGHT_UV = VENV / "uv"
OLDEST, NEWEST = (3, 11), (3, 14)
"""Versions of Python for which every package has a wheel."""
SUPPORTED = "Python 3.11 to 3.14 on Linux (x86-64, arm64), macOS (arm64) and Windows (x86-64)"
LOCKS = {"tuner": "core.txt"}
"""Packages of a command, by their versions and hashes; every other command is one of development."""
PIP_INSTALL = ["install", "--quiet", "--disable-pip-version-check"]
SCRIPTS = {
    "pytest": ["-m", "pytest"],
    "ruff": ["-m", "ruff"],
    "pyright": ["-m", "pyright"],
    "docs": ["docs/generator/build.py"],
}


class SetUpError(Exception):
    """A step of setting up failed; the text is one line for the user."""


def main() -> int:
    """Install what is missing, then run the command given."""
    if len(sys.argv) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    if not is_supported(sys.version_info[:2]):
        return run_with_another()
    command, arguments = sys.argv[1], sys.argv[2:]
    install(LOCKS.get(command, "develop.txt"))
    program = [str(PYTHON), *SCRIPTS[command]] if command in SCRIPTS else [str(BIN / command)]
    return subprocess.call([*program, *arguments], cwd=ROOT if command in SCRIPTS else None, env=activated())


def is_supported(version: "tuple[int, ...]") -> bool:
    """Return True if every package has a wheel for a version of Python on this machine."""
    has_wheels = platform.system() != "Darwin" or platform.machine() == "arm64"
    return has_wheels and OLDEST <= version <= NEWEST


def run_with_another() -> int:
    """Run this file with the newest supported interpreter of the machine, else with one that uv brings."""
    python = find_interpreter() if is_supported(NEWEST) else None
    if python is None:
        this = f"Python {sys.version.split()[0]} on {platform.system()} ({platform.machine()})"
        print(f"Supported: {SUPPORTED}. This is {this}; no supported interpreter was found.", file=sys.stderr)
        return 2
    print(f"Using {python}, since Python {sys.version.split()[0]} is not supported", flush=True)
    return subprocess.call([python, *sys.argv])


def find_interpreter() -> "str | None":
    """Return the newest supported Python on PATH, among pyenv's or that uv finds or brings."""
    versions = [f"3.{minor}" for minor in range(NEWEST[1], OLDEST[1] - 1, -1)]
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv") / "versions"
    for version in versions:
        places = [
            shutil.which(f"python{version}"),
            *sorted(map(str, pyenv.glob(f"{version}.*/bin/python")), reverse=True),
        ]
        for place in places:
            if place and answers(place, version):
                return place
    uv = shutil.which("uv")
    if uv and subprocess.call([uv, "python", "install", "--quiet", versions[0]]) == 0:
        found = subprocess.run([uv, "python", "find", versions[0]], stdout=subprocess.PIPE)
        return found.stdout.decode().strip() or None
    return None


def answers(python: str, version: str) -> bool:
    """Return True if an interpreter starts and has a version: a shim of pyenv may not."""
    code = "import sys; print('%d.%d' % sys.version_info[:2])"
    try:
        found = subprocess.run([python, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    except OSError:
        return False
    return found.returncode == 0 and found.stdout.decode().strip() == version


def install(lock: str) -> None:
    """Make the environment with the packages of a lock file, unless that was done for these very files.

    Packages are those whose hashes stand in `requirements/`; the project itself comes from this folder, in place.
    """
    installed = STAMP.read_text().split() if STAMP.exists() else []
    # The packages of development hold those of the command.
    if digest(lock) in installed or digest("develop.txt") in installed:
        return
    uv = make_environment()
    print(f"Installing the packages of requirements/{lock} into {VENV.name}", flush=True)
    steps = [
        ["--require-hashes", "-r", str(ROOT / "requirements" / lock)],
        ["--no-deps", "--no-build-isolation", "-e", str(ROOT)],
    ]
    # Each process of a suite would compile what no other has; a first answer needs a part of it.
    ahead = ["--compile-bytecode"] if lock == "develop.txt" else []
    with_uv = [uv, "pip", "install", "--quiet", "--python", str(PYTHON), *ahead] if uv else []
    if not with_uv or not all(is_done([*with_uv, *step]) for step in steps):
        # pip has certificates and settings of its own, and takes three times as long.
        for step in steps:
            run([*pip_of_environment(), *PIP_INSTALL, *step])
    STAMP.write_text(digest(lock) + "\n")


def make_environment() -> "str | None":
    """Make the environment unless it is there; return the uv that installs packages, None for pip."""
    uv, has_pip = find_uv(), succeeds([sys.executable, "-m", "pip", "--version"])
    if not PYTHON.exists():
        print(f"Making {VENV.name}", flush=True)
        # Without pip it takes 0.1 s instead of 3 to 6; uv needs none.
        try:
            run([sys.executable, "-m", "venv", *(["--without-pip"] if uv or has_pip else []), str(VENV)])
        except SetUpError as error:
            raise SetUpError(f"{error}. On Debian and Ubuntu the venv module is the package python3-venv") from None
    return uv or bring_uv(sys.executable if has_pip else str(PYTHON))


def pip_of_environment() -> "list[str]":
    """Return the command of the environment's pip, which is put there if it is missing."""
    pip = [str(PYTHON), "-m", "pip"]
    if not succeeds([*pip, "--version"]):
        run([str(PYTHON), "-m", "ensurepip", "--default-pip"])
    return pip


def succeeds(command: "list[str]") -> bool:
    """Return True if a command ends with exit code 0; its output is dropped."""
    return subprocess.call(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) == 0


def find_uv() -> "str | None":
    """Return the uv of the machine or the one that was brought before, None for neither."""
    for place in (shutil.which("uv"), shutil.which("uv", path=str(BROUGHT_UV / "bin"))):
        # A shim of pyenv is on PATH for versions that have no uv.
        if place and succeeds([place, "--version"]):
            return place
    return None


def bring_uv(python: str) -> "str | None":
    """Install the pinned uv into a folder of its own with an interpreter's pip; None if that fails."""
    lock = ["--require-hashes", "-r", str(ROOT / "requirements" / "uv.txt"), "--target", str(BROUGHT_UV)]
    is_done([python, "-m", "pip", *PIP_INSTALL, "--no-deps", "--only-binary", ":all:", *lock])
    return find_uv()


def is_done(command: "list[str]") -> bool:
    """Run a step of setting up; return True if it ended with exit code 0."""
    return subprocess.call(command, env=environment()) == 0


def run(command: "list[str]") -> None:
    """Run a step of setting up; SetUpError where it fails."""
    if not is_done(command):
        raise SetUpError(f"Setting up failed at: {' '.join(command)}")


def environment() -> "dict[str, str]":
    """Return the environment of installers: uv with pip's index and certificates, and with a cache that can be written."""
    variables = dict(os.environ)
    for theirs, ours in (("PIP_INDEX_URL", "UV_DEFAULT_INDEX"), ("PIP_CERT", "SSL_CERT_FILE")):
        if theirs in variables:
            variables.setdefault(ours, variables[theirs])
    if ssl.get_default_verify_paths().cafile:
        # Certificates of a company's proxy are in the system's store, which uv leaves out by default.
        variables.setdefault("UV_SYSTEM_CERTS", "true")
    cache = Path(
        variables.get("UV_CACHE_DIR") or Path(variables.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "uv"
    )
    try:
        cache.mkdir(parents=True, exist_ok=True)
        is_writable = os.access(cache, os.W_OK)
    except OSError:
        is_writable = False
    if not is_writable:
        variables["UV_CACHE_DIR"] = str(VENV / "cache")
    return variables


def activated() -> "dict[str, str]":
    """Return the environment of a command: its `python` is the one with the packages."""
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONHOME"}
    return {**variables, "VIRTUAL_ENV": str(VENV), "PATH": f"{BIN}{os.pathsep}{os.environ.get('PATH', os.defpath)}"}


def digest(lock: str) -> str:
    """Return the digest of a lock file with the project's own requirements."""
    files = (ROOT / "pyproject.toml", ROOT / "requirements" / lock)
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


if __name__ == "__main__":
    try:
        sys.exit(main())
    except SetUpError as error:
        print(f"{error}.", file=sys.stderr)
        sys.exit(1)
