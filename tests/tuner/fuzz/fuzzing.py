"""What the fuzz tests share: settings that make the same files everywhere, a clock, and what a refusal must be like."""

import signal
from contextlib import contextmanager

from hypothesis import HealthCheck, configuration, settings

from plant.errors import InputError, ToolError, UnphysicalError
from tests.tuner.conftest import QUICKSTART

STUDIES = QUICKSTART.parent
# Seconds that reading a file may take; the slowest good one takes 0.4 s, most 0.01 s.
PATIENCE = 20
LONGEST_MESSAGE = 1500
# What tells the place where the text is no TOML or JSON at all, or where the numbers of several keys go badly together.
PLACES = ("line ", "byte ", "document", "nested", "can be read")


def fuzzed(examples, home):
    """Return settings under which a test sees the same files whenever and wherever it runs; home: for Hypothesis's own files."""
    configuration.set_hypothesis_home_dir(home)
    return settings(
        max_examples=examples,
        derandomize=True,
        database=None,
        deadline=None,
        report_multiple_bugs=False,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
    )


@contextmanager
def patience(seconds=PATIENCE):
    """Fail where something takes longer than this."""

    def ring(*_):
        raise AssertionError(f"not done after {seconds} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def outcome(load, path):
    """Return "accepted", or "refused" where the error is one that a person can use."""
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
    told = error.key is not None or isinstance(error, UnphysicalError) or any(place in text for place in PLACES)
    assert told, text
