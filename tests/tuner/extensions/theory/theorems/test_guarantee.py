"""Theorems on the axes of a cascade: the right gains go to the right axis, and the worst axis counts."""

import numpy as np
import pytest

from plant.law_registry import LAWS
from plant.quadrotor.cascade import AXES, close_cascade
from plant.quadrotor.gains import gain_addresses
from tuner.extensions.theory.theorems import THEOREMS, Setting
from tuner.extensions.theory.theorems.guarantee import Guarantee, channel_gains, law_of, loop_of

CASCADE = close_cascade(LAWS["supertwisting"], LAWS["hybrid"])
ROWS = np.random.default_rng(6).uniform(0.5, 9.0, (4, len(gain_addresses(CASCADE))))


def one(row, axis):
    """The gains of one axis by their addresses."""
    return {gain.info.name: row[gain.column] for gain in gain_addresses(CASCADE) if gain.axis == axis}


@pytest.mark.parametrize("axis", AXES)
def test_each_axis_has_its_own_gains(axis):
    gains = channel_gains(CASCADE, axis, ROWS)
    assert isinstance(gains, law_of(CASCADE, axis).Gains)
    for k, row in enumerate(ROWS):
        assert {name: float(leaf[k]) for name, leaf in gains._asdict().items()} == one(row, axis)
    assert loop_of(axis) == ("position" if axis in "xyz" else "attitude")


@pytest.mark.parametrize(
    ("name", "axes", "pick"), [("ultimate_error", ("roll", "yaw", "pitch"), max), ("sta_seeber_horn", ("z", "x"), min)]
)
def test_each_axis_is_worked_out_in_its_setting_and_the_worst_counts(name, axes, pick):
    settings = {axis: Setting(0.004, 10.0 + i) for i, axis in enumerate(axes)}
    guarantee, theorem = Guarantee(THEOREMS[name], CASCADE, settings), THEOREMS[name]
    values = guarantee.values(ROWS)
    for k, row in enumerate(ROWS):
        for i, axis in enumerate(axes):
            law = law_of(CASCADE, axis)
            alone = law.Gains(**{key: np.array(value) for key, value in one(row, axis).items()})
            assert values[k, i] == pytest.approx(float(theorem.values[law.name](alone, settings[axis])), rel=1e-14)
        assert guarantee.worst(ROWS)[k].tolist() == [pick(values[k].tolist())]


@pytest.mark.parametrize("name", THEOREMS)
@pytest.mark.parametrize("loop", ["position", "attitude"])
def test_every_theorem_gives_numbers_over_the_whole_range_of_the_gains(name, loop):
    # A search meets every corner; a value is never NaN, never negative, and infinite only where no gain acts.
    for law in THEOREMS[name].laws:
        infos = LAWS[law].gains
        ends = [(info.span(loop).low, info.span(loop).high) for info in infos]
        corners = np.stack([corner.ravel() for corner in np.meshgrid(*ends)])
        value = THEOREMS[name].values[law](LAWS[law].Gains(*corners), Setting(0.004, 30.0))
        assert value.shape == (2 ** len(infos),) and np.isfinite(value).all() and (value >= 0.0).all()


def test_theorems_are_complete_sentences_of_data():
    for name, theorem in THEOREMS.items():
        assert theorem.name == name and theorem.sense in ("max", "min") and set(theorem.laws) <= set(LAWS)
        assert "{y}" in theorem.unit and theorem.title and theorem.source and theorem.quantity and theorem.assumes
