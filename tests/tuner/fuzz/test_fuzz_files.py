"""Any study, contest, inference or gains file either loads or is refused in one line that names a place in it.

Hypothesis changes the bundled files in their structure and breaks them as text. The whole proof, 2,500 files:
pytest -m slow tests/tuner/fuzz.
"""

import json
import shutil
import signal
import tomllib
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st

from plant.errors import InputError, ToolError
from tests.tuner.conftest import QUICKSTART
from tests.tuner.fuzz.hostile import broken, mutated
from tests.tuner.fuzz.hostile_text import json_of, toml_of
from tuner.contest import is_contest, load_contest
from tuner.gains_file import read_gains
from tuner.inference import is_inference
from tuner.inference.reading import load_inference
from tuner.study import load_study

STUDIES = QUICKSTART.parent
# Seconds that reading may take; the slowest good file takes 0.4 s, most 0.01 s.
PATIENCE = 20
LONGEST_MESSAGE = 1500


def fuzzed(examples):
    """The settings of a test: the same files whenever and wherever it runs."""
    return settings(
        max_examples=examples, derandomize=True, database=None, deadline=None, report_multiple_bugs=False,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip


@contextmanager
def patience(seconds=PATIENCE):
    def ring(*_):
        raise AssertionError(f"not done after {seconds} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def load_any(path):
    """Read a file as `tuner check` does."""
    if is_inference(path):
        return load_inference(path)
    return load_contest(path) if is_contest(path) else load_study(path)


def outcome(load, path):
    """Return "accepted", or "refused" where the error is what a person can use."""
    try:
        with patience():
            load(path)
    except ToolError as error:
        assert_helpful(error)
        return "refused"
    return "accepted"


def assert_helpful(error):
    text = str(error)
    assert isinstance(error, InputError), repr(error)
    assert text.isprintable(), repr(text)
    assert len(text) <= LONGEST_MESSAGE, text[:200]
    assert error.file is not None, text
    assert error.key or any(word in text for word in ("line ", "byte ", "not JSON", "nested")), text
