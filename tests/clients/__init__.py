"""Where tests find the programs that nobody here wrote (`install.py` puts them there)."""

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

CLIENTS = Path(__file__).resolve().parents[2] / ".clients"


def program(name: str) -> str:
    """Return the path of a program; skips the test where it is not installed."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is not installed; python3 tests/clients/install.py installs it where it can be had")
    return found


def client(group: str) -> str:
    """Return the Python of a group of clients; skips the test where it is not installed."""
    python = CLIENTS / group / "bin" / "python"
    if not (CLIENTS / group / "installed.txt").exists():
        pytest.skip(f"the clients '{group}' are not installed; python3 tests/clients/install.py installs them")
    return str(python)


def ask(group: str, script: str, *arguments: str) -> Any:
    """Run a script in a client's environment; its standard output, JSON, is returned."""
    command = [client(group), "-c", script, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-3000:]
    return json.loads(done.stdout.splitlines()[-1])
