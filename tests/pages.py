"""The blocks of pages as a reader types them: files that a page shows are written, commands and Python are run, top to bottom."""

import contextlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import pytest

import tuner
from plant.texts import PlainTable
from tests.plant.own_files import forget
from tests.tuner.in_process import called
from tuner.study.files import study_file

ROOT = Path(__file__).parents[1]
TYPED = ("sh", "console", "python")
"""Languages of blocks that a reader types."""
FENCE = re.compile(r"^```(?P<language>\w+)\n(?P<text>.*?)^```", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"`(?P<name>[\w./]+\.\w+)`(?:, instead of its `(?P<table>.+?)`)?[^`]*:$")
_RUN = tuner.run
JUDGES = ("check", "judge", "margins", "export", "approach", "compare-logs")
"""Commands whose exit code 1 is a verdict on gains, here those of a small search."""


@dataclass(frozen=True)
class Block:
    """A block of a page; `name` where it is the content of a file, `table` what it replaces there."""

    language: str
    text: str
    name: str = ""
    table: str = ""


def blocks(page: str) -> list[Block]:
    """Return the blocks of a page in their order; a line that begins with a file's name makes one a file."""
    out = []
    for match in FENCE.finditer(page):
        file = FILE.match(page[: match.start()].rstrip("\n").rpartition("\n")[2])
        name, table = (file["name"], file["table"] or "") if file else ("", "")
        out.append(Block(match["language"], match["text"], name, table))
    return out


def lines(block: Block) -> list[str]:
    """Return the commands of a shell block, without comments; those of several lines in one."""
    joined = block.text.replace("\\\n", " ").splitlines()
    stripped = [re.sub(r"(^|\s)#.*", "", line).strip() for line in joined]
    return [line for line in stripped if line]


def commands(block: Block) -> list[str]:
    """Return the typed commands of a block: lines of a shell, or a piece of Python as one."""
    return lines(block) if block.language in ("sh", "console") else [block.text]


def small_changes(study: str) -> PlainTable:
    """Return changes that make the search of a study small and its flights few."""
    tables = tomllib.loads(study_file(Path(study)).read_text(encoding="utf-8"))
    changes: PlainTable = {"search.population": 8, "search.generations": 2}
    for i, scenario in enumerate(tables.get("scenario", ())):
        changes |= {f"scenario.{i}.search": 4, f"scenario.{i}.held_out": 16}
        if "plant" not in tables and scenario.get("duration", 10.0) > 2.0:
            changes[f"scenario.{i}.duration"] = 2.0
    # Two generations seldom satisfy limits; whether limits are read is tested elsewhere.
    return changes | {"margin": [], "constraint": [], "mission.followed": 1.0, "mission.held": 1.0}


def small_options(study: str) -> list[str]:
    """Return `small_changes` as options of a command."""
    return [word for key, value in small_changes(study).items() for word in ("--set", f"{key}={value}")]


def run_small(study, out=None, **options):
    """Stand in for `tuner.run` in Python blocks: a study by its name gets a small search."""
    small = tuner.load_study(study, small_changes(study)) if isinstance(study, str) else study
    return _RUN(small, out, **options)


class Typist:
    """Type the blocks of a page in a folder; `folder` holds what the page says that the reader has."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._names = folder, {"__name__": "page"}

    def type(self, block: Block, omitted: re.Pattern[str]) -> None:
        """Write a file, or run each command that is not omitted."""
        if block.name:
            self._write(block)
        elif block.language in TYPED:
            for command in commands(block):
                if not omitted.search(command):
                    self._run(command, block.language)

    def _write(self, block: Block) -> None:
        file = self._folder / block.name
        file.parent.mkdir(parents=True, exist_ok=True)
        text = block.text
        if block.table:
            pattern = rf"^{re.escape(block.table)}.*?\n(?=\n*(?:#[^\n]*\n)*\[|\Z)"
            text, count = re.subn(pattern, lambda _: block.text, file.read_text(), flags=re.DOTALL | re.MULTILINE)
            assert count == 1, f"{block.name} has no table {block.table}"
        file.write_text(text, encoding="utf-8")

    def _run(self, command: str, language: str) -> None:
        with contextlib.chdir(self._folder):
            if language == "python":
                self._python(command)
                return
            words, out = redirection(shlex.split(command))
            if words[0] != "tuner" or set("|&;`$") & set(command):
                shell(command)
            else:
                self._tuner(command, words[1:], out)

    def _python(self, text: str) -> None:
        loaded = set(sys.modules)
        # Files of the page can be imported, as in an interpreter that is started in their folder.
        with patch.object(sys, "path", [str(self._folder), *sys.path]):
            exec(compile(text, "page", "exec"), self._names)
        for name in set(sys.modules) - loaded:
            file = getattr(sys.modules[name], "__file__", None)
            if file and Path(file).is_relative_to(self._folder):
                del sys.modules[name]

    def _tuner(self, command: str, words: list[str], out: str) -> None:
        code, printed, errors = called(*smaller(words))
        forget()
        allowed = (0, 1) if words[0] in JUDGES else (0,)
        assert code in allowed, f"{command}\n{printed}\n{errors}"
        if out:
            Path(out).write_text(printed, encoding="utf-8")
        for option, file in zip(words, words[1:], strict=False):
            assert option not in ("--out", "--plot") or Path(file).exists(), f"{command} has not written {file}"


def redirection(words: list[str]) -> tuple[list[str], str]:
    """Return a command's words without `> FILE` at their end, and the file."""
    return (words[:-2], words[-1]) if len(words) > 2 and words[-2] == ">" else (words, "")


def smaller(words: list[str]) -> list[str]:
    """Return the words of a command with options that make it short."""
    few = ["8" if before == "--seeds" else word for before, word in zip(["", *words], words, strict=False)]
    if words[0] == "run":
        return [*few, *small_options(words[1])]
    return few


def shell(command: str) -> None:
    """Run a line of a shell with this environment's programs."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    program = command.split()[0]
    if shutil.which(program, path=path) is None:
        pytest.skip(f"{program} is not installed")
    done = subprocess.run(
        ["bash", "-c", command],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
