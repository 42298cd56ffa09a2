"""Quick exports for tests that look at something else in them."""

from functools import partial

import pytest

from tuner.exchange.c99.golden import golden


@pytest.fixture
def few_golden_vectors(monkeypatch):
    """Have bundles of C hold 16 golden vectors of each kind, not 200."""
    monkeypatch.setattr("tuner.exchange.c99.export.golden", partial(golden, steps=16))


@pytest.fixture
def unflown(monkeypatch):
    """Fly nothing before and after rounding: each pair of laws of an autopilot takes 10 s of compilation."""
    monkeypatch.setattr("tuner.exchange.verification.fly_both", lambda *_: ([], (0, 0)))


@pytest.fixture
def uncompiled(monkeypatch):
    """Have mock-up units hold no binary."""
    monkeypatch.setattr("tuner.exchange.fmi.export.compiler", lambda: None)
