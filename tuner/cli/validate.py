"""`tuner validate`: is this a gains.json, whole and as it was written? Exit code 0, or 2 with one line for each problem."""

import json
import sys
from pathlib import Path
from typing import Any

import typer

from tuner.gains.examining import Examined, examine
from tuner.gains.sections import VERSIONS
from tuner.text.errors import USER_ERROR


def validate_command(path: Path, as_json: bool) -> None:
    """Examine a file and say what it is, or all that is wrong with it."""
    examined = examine(path)
    if as_json:
        print(json.dumps(verdict(examined), indent=2, allow_nan=False))
    elif examined.problems:
        for problem in examined.problems:
            print(f"Error: {problem}", file=sys.stderr)
    else:
        print(f"{path}: valid: {sentence(examined)}")
    if examined.problems:
        raise typer.Exit(USER_ERROR)


def verdict(examined: Examined) -> dict[str, Any]:
    """Return the verdict for a program."""
    return {
        "file": str(examined.path),
        "valid": not examined.problems,
        "version": examined.given["version"],
        "hash": hash_state(examined),
        "sha256": None if examined.problems else examined.digest,
        "problems": [{"key": problem.key, "message": problem.message} for problem in examined.problems],
    }


def hash_state(examined: Examined) -> str:
    """Return "missing", "wrong" or "ok"."""
    if "sha256" not in examined.given:
        return "missing"
    return "wrong" if any(problem.key == "sha256" for problem in examined.problems) else "ok"


def sentence(examined: Examined) -> str:
    """Say what a valid file holds."""
    document, given = examined.document, examined.given
    laws = f"{document['controller']['position']} / {document['controller']['attitude']}"
    words = [
        f"holdfast-gains {given['version']}",
        f"{laws} for airframe {document['airframe']['name']}",
        f"{len(document['gains'])} gains",
    ]
    if given["version"] not in VERSIONS:
        words.append(f"no hash and no numbers of the airframe before version {VERSIONS[0]}")
    else:
        words.append("hash ok" if "sha256" in given else f"no hash given (it would be {examined.digest})")
    return ", ".join(words)
