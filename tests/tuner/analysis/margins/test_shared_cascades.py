"""Cascades of the same laws are one, so that studies share its derivatives; of other laws each is its own."""

from dataclasses import replace

import pytest

import tuner
from plant.law_registry import LAWS
from plant.quadrotor import cascade
from plant.quadrotor.cascade import close_cascade
from tests.tuner.conftest import QUICKSTART
from tuner.study.build import load_study


@pytest.fixture(autouse=True)
def _no_cascade_of_an_earlier_test(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cascade, "_CLOSED", {})


def test_studies_and_gains_of_the_same_laws_share_a_cascade() -> None:
    first, second = (load_study(QUICKSTART).system.cascade for _ in range(2))
    assert first is second is tuner.default_gains("hybrid", "ladrc").quadrotor("").cascade


def test_position_loops_of_another_rate_have_a_cascade_of_their_own() -> None:
    law = LAWS["pid"]
    prompt, slow = close_cascade(law, law), close_cascade(law, law, 4)
    assert slow is close_cascade(law, law, 4) is not prompt
    assert slow.at_one_rate is prompt and slow.position_every == 4


def test_laws_that_compare_equal_have_cascades_of_their_own() -> None:
    """Ranges and words of a law have no part in its equality, and a cascade carries them."""
    law = LAWS["pid"]
    other = replace(law, winds_up=not law.winds_up)
    assert law == other
    assert close_cascade(other, other).attitude is other and close_cascade(law, law).attitude is law


def test_the_oldest_cascade_gives_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cascade, "MAX_CLOSED", 2)
    laws = [LAWS[name] for name in ("pid", "ladrc", "hybrid")]
    oldest, middle, latest = (close_cascade(law, law) for law in laws)
    assert close_cascade(laws[1], laws[1]) is middle and close_cascade(laws[2], laws[2]) is latest
    assert close_cascade(laws[0], laws[0]) is not oldest and len(cascade._CLOSED) == 2
