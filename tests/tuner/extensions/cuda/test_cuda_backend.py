"""`tuner run --backend cuda` of a machine without a card."""

from typing import Any

import pytest

from plant.errors import InputError
from tests.tuner.in_process import tuner
from tuner.engines import registry as choice
from tuner.extensions.cuda import card

UNUSED: Any = None


@pytest.mark.parametrize("backend", ["cuda", "cuda-float32"])
@pytest.mark.parametrize("why", [card.NO_CARD, card.NO_COMPILER, card.NO_TOOLKIT])
def test_without_a_card_a_run_on_one_is_refused_in_one_line(monkeypatch, backend, why):
    monkeypatch.setattr(card, "missing", lambda: why)
    with pytest.raises(InputError) as told:
        choice.engine_named(backend, UNUSED, 1)
    assert str(told.value) == f"--backend: given '{backend}', and {why}; leave the option out to fly on the processor"


def test_run_does_not_fly_on_the_processor_instead(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(card, "missing", lambda: card.NO_COMPILER)
    out = tmp_path / "r"
    code, _, error = tuner(
        monkeypatch, capsys, "run", "studies/quickstart.toml", "--backend", "cuda-float32", "--out", out
    )
    assert code == 2 and "pip install" in error and error.count("\n") == 1 and not out.exists()
