"""Annotations of tools by observation: the files below the root before a call, after it, and after the same call again."""

import hashlib
import shutil
from typing import Any

import anyio
import pytest

from tests.golden.steps import LOG, STUDIES
from tests.tuner.extensions.agents.test_agent_places import no_progress
from tuner.extensions.agents.answers import meaning_of
from tuner.extensions.agents.child import run_command
from tuner.extensions.agents.tools import TOOLS, Effect, command_line, commands, tools

LOGS = [f"{LOG.name}@70:85"]
CALLS = (
    ("list", {"what": "laws"}),
    ("new", {"name": "mine"}),
    ("new", {"name": "airframe", "mass": 1.4, "wheelbase": 0.45, "propeller": "10x4.5", "kv": 920, "cells": 3}),
    ("check", {"file": "tuning.toml"}),
    ("plan", {"study": "tuning.toml"}),
    ("design", {"study": "tuning.toml"}),
    ("run", {"study": "tuning.toml", "out": "run"}),
    ("show", {"results": "run"}),
    ("check", {"file": "run/gains.json", "requirements": "tuning.toml", "seeds": 8}),
    ("rejudge", {"results": "run", "set": ["objective.0.level=0.25"], "out": "again"}),
    ("compare", {"what": ["run", "gains.json"], "out": "comparison"}),
    ("margins", {"gains": "run/gains.json", "study": "tuning.toml", "out": "margins"}),
    ("fly", {"gains": "run/gains.json", "study": "tuning.toml", "seeds": 8, "plot": "flown.png"}),
    ("export", {"gains": "run/gains.json", "to": "c99", "flights": 2}),
    ("run", {"study": "contest.toml", "out": "contest"}),
    ("export", {"gains": "contest/contenders/pid/gains.json", "to": "px4", "flights": 2, "out": "px4"}),
    ("import", {"parameters": "px4/gainproof.params", "from": "px4", "airframe": "f450"}),
    ("judge", {"after": "px4/gainproof.params", "airframe": "f450", "flights": 8, "out": "opinion"}),
    ("tail", {"gains": ["run"], "study": "tuning.toml", "event": ["failure"], "to": 0.05, "width": 5, "most": 300, "out": "tail"}),
    ("identify", {"logs": LOGS, "airframe": "crazyflie-pybullet", "out": "found.toml", "report": "found.html"}),
    ("resume", {"results": "run"}),
)  # fmt: skip
NOT_CALLED = {"autotune"}
"""Takes minutes; its folder is its own, and a second call writes index.html in it again."""


def files_below(root):
    """Digest of each file by its place."""
    return {
        path.relative_to(root).as_posix(): hashlib.blake2b(path.read_bytes()).hexdigest()
        for path in root.rglob("*")
        if path.is_file()
    }


def call(root, name, given):
    outcome = anyio.run(run_command, command_line(name, given, root), root, False, no_progress)
    assert outcome.code in (0, 1, 2, 3), outcome
    return outcome


def observe(root, name, given):
    """Effect of a call and of the same call after it: the files that were made, and those that were changed or removed."""
    before = files_below(root)
    outcome = call(root, name, given)
    assert meaning_of(outcome).startswith("done"), outcome
    after = files_below(root)
    call(root, name, given)
    last = files_below(root)
    changed = {file for file in before if before[file] != after.get(file)} | {
        file for file in after if after[file] != last.get(file)
    }
    return set(last) - set(before), changed


def check_effects(root, calls):
    """Hold each call against the tool's annotations."""
    hints: Any = {tool.name: tool.annotations for tool in tools()}
    for name, given in calls:
        made, changed = observe(root, name, given)
        assert not (hints[name].read_only_hint and made), (name, made)
        assert hints[name].destructive_hint or not changed, (name, changed)
        if TOOLS[name].effect is Effect.NEW:
            assert made, name


@pytest.fixture
def root(tmp_path):
    for file in STUDIES.iterdir():
        shutil.copy(file, tmp_path)
    shutil.copy(LOG, tmp_path)
    return tmp_path.resolve()


@pytest.mark.slow
def test_tools_that_take_a_moment_do_as_they_are_annotated(root):
    check_effects(root, CALLS[:2])


@pytest.mark.slow
def test_every_tool_does_as_it_is_annotated(root):
    assert {name for name, _ in CALLS} | NOT_CALLED == set(commands())
    check_effects(root, CALLS)
