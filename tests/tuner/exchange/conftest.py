"""Quick exports for tests that look at something else in them."""

import pytest


@pytest.fixture
def unflown(monkeypatch):
    """Fly nothing before and after rounding: each pair of laws of an autopilot takes 10 s of compilation."""
    monkeypatch.setattr("tuner.exchange.verification.fly_both", lambda *_: ([], (0, 0)))


@pytest.fixture
def uncompiled(monkeypatch):
    """Have mock-up units hold no binary."""
    monkeypatch.setattr("tuner.exchange.fmi.export.compiler", lambda: None)
