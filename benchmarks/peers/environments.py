"""One environment for each peer that needs one: made once, kept, and explained where it cannot be made."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MAX_SECONDS = 1200
"""How long an installation may take: torch and jax are large."""


class NotInstalled(Exception):
    """A peer's environment could not be made; says why."""


def python_of(name: str, requires: tuple[str, ...], envs: Path) -> str:
    """Return the interpreter of an environment, made and filled if it is not there yet; name "" for that of the package."""
    if not name:
        return sys.executable
    folder = envs / name
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    done = folder / "installed"
    wanted = " ".join(requires)
    if done.exists() and done.read_text() == wanted:
        return str(python)
    _run([sys.executable, "-m", "venv", str(folder)])
    _run([str(python), "-m", "pip", "install", "-q", *requires])
    done.write_text(wanted)
    return str(python)


def worker_environment() -> dict[str, str]:
    """Return the environment of a worker: our packages from the source tree, whatever else is installed."""
    return os.environ | {"PYTHONPATH": str(ROOT)}


def _run(command: list[str]) -> None:
    try:
        subprocess.run(command, check=True, capture_output=True, text=True, timeout=MAX_SECONDS)
    except (OSError, subprocess.SubprocessError) as error:
        message = getattr(error, "stderr", None) or str(error)
        # What a command wrote before it ran out of time is left undecoded.
        message = message.decode(errors="replace") if isinstance(message, bytes) else message
        lines = [line for line in message.strip().splitlines() if "WARNING" not in line]
        raise NotInstalled(lines[-1] if lines else str(error)) from error
