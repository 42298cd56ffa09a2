"""The way to tuned gains: its steps, the margins that fall short on it, and its folder."""

import json
from dataclasses import replace

import numpy as np
import pytest

import tuner
from plant.errors import InputError
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.nominal import ControlOptions
from tests.tuner.exchange.controllers import pid
from tests.tuner.in_process import tuner as typed
from tuner.api.gains import QuadrotorGains, gains_of
from tuner.extensions.first_flights import approach_api as approaching
from tuner.extensions.first_flights.approach import (
    MAX_FACTOR,
    MAX_STEPS,
    factors_between,
    rows_between,
    steps_between,
    steps_of_size,
)
from tuner.extensions.first_flights.approach_api import option_notes


def test_options_that_differ_are_given_in_the_units_of_a_study():
    one, other = (replace(pid(), options=ControlOptions(tilt_limit=np.radians(angle))) for angle in (45.0, 30.0))
    (note,) = option_notes(one, other)
    assert note.startswith("controller.tilt_limit_deg is 45 in what flies now and 30 in the tuned gains")


def test_gains_go_by_equal_factors_and_those_that_change_sign_by_equal_differences():
    present, tuned = np.array([1.0, 8.0, -1.0, 0.0, 3.0]), np.array([8.0, 1.0, 1.0, 0.4, 3.0])
    rows = rows_between(present, tuned, 3)
    assert rows[:, 0] == pytest.approx([1.0, 2.0, 4.0, 8.0]) and rows[:, 1] == pytest.approx([8.0, 4.0, 2.0, 1.0])
    assert rows[:, 2] == pytest.approx([-1.0, -1 / 3, 1 / 3, 1.0]) and rows[:, 3] == pytest.approx(
        [0.0, 0.4 / 3, 0.8 / 3, 0.4]
    )
    assert np.array_equal(rows[[0, -1]], [present, tuned]) and np.all(rows[:, 4] == 3.0)


@pytest.mark.parametrize("ratio", [1.0, 1.2, 1.5, 1.51, 4.0, 100.0])
def test_as_many_steps_as_keep_every_change_small(ratio):
    present, tuned = np.array([2.0, 5.0]), np.array([2.0 * ratio, 5.0])
    steps = steps_between(present, tuned)
    assert steps == min(max(int(np.ceil(np.log(ratio) / np.log(MAX_FACTOR) - 1e-6)), 1), MAX_STEPS)
    factors = [
        factors_between(a, b).max()
        for a, b in zip(*(rows_between(present, tuned, steps)[i:] for i in (0, 1)), strict=False)
    ]
    assert factors == pytest.approx([ratio ** (1 / steps)] * steps)


@pytest.mark.parametrize("share", [0.2, 0.25, 0.3])
def test_steps_of_a_size_change_no_gain_by_more(share):
    present, tuned = np.array([2.0, 5.0, 0.5]), np.array([7.0, 2.0, 0.5])
    steps = steps_of_size(present, tuned, share)
    rows = rows_between(present, tuned, steps)
    worst = max(factors_between(a, b).max() for a, b in zip(rows[:-1], rows[1:], strict=True))
    assert worst <= 1.0 + share + 1e-9
    fewer = rows_between(present, tuned, steps - 1)
    assert max(factors_between(a, b).max() for a, b in zip(fewer[:-1], fewer[1:], strict=True)) > 1.0 + share


def test_a_step_that_is_none_or_takes_too_many_is_refused(present):
    after = scaled(present, omega_c=1.2)
    for step, words in ((0.01, "0.05 to 1"), (5.0, "0.05 to 1")):
        with pytest.raises(InputError, match=words):
            tuner.approach(present, after, step=step)
    with pytest.raises(InputError, match="give a larger step"):
        steps_of_size(np.array([1.0]), np.array([100.0]), 0.05)
    with pytest.raises(InputError, match="--steps or --step"):
        tuner.approach(present, after, step=0.25, steps=3)
    assert len(tuner.approach(present, after, step=0.1, flights=2).gains) == 3


def scaled(gains: QuadrotorGains, **factors: float) -> QuadrotorGains:
    """Gains with those of some names, in every axis, times a factor."""
    from dataclasses import replace

    from plant.quadrotor.gains import gain_addresses

    addresses = [gain.address for gain in gain_addresses(gains.controller.cascade)]
    row = [
        value * factors.get(address.rpartition(".")[2], 1.0)
        for address, value in zip(addresses, gains.controller.gains, strict=True)
    ]
    return gains_of(replace(gains.controller, gains=tuple(row)), {})


@pytest.fixture(scope="module")
def present():
    return tuner.default_gains("hybrid")


def test_margins_of_the_steps_are_those_of_their_gains(present):
    found = tuner.approach(present, scaled(present, omega_c=1.2), steps=2, flights=2)
    assert found.passed and len(found.gains) == 3
    for gains, step in zip(found.gains, found.document.steps, strict=True):
        alone = tuner.margins(gains).document.channels
        assert [each.quantities["phase_margin"].value for each in step.channels] == pytest.approx(
            [each.quantities["phase_margin"].value for each in alone], rel=1e-9
        )
    assert found.document.steps[1].factor == pytest.approx(1.2**0.5)


def test_a_margin_that_falls_between_two_good_ends_is_named(present, monkeypatch):
    # A position loop of 2.5 times the bandwidth has little left; it is put between two good ends by hand.
    weak = np.array(scaled(present, omega_c=2.5).controller.gains)
    monkeypatch.setattr(approaching, "rows_between", lambda a, b, n: np.array([a, weak, b]))
    found = tuner.approach(present, scaled(present, omega_c=1.01), flights=2)
    assert not found.passed and [bool(step.short) for step in found.document.steps] == [False, True, False]
    assert all(not row.is_satisfied for row in found.document.steps[1].short)


def test_what_cannot_be_exported_leaves_nothing_behind_and_names_a_gain_that_there_is(tmp_path, monkeypatch):
    # Nothing is flown: these loops would be compiled for this test alone, for 10 s.
    monkeypatch.setattr(approaching, "_flown", lambda _, rows, *rest: [approaching.StepFlights([], 0)] * len(rows))
    present = tuner.default_gains("px4", "px4_position", "f450")
    # PX4 documents 0.2 to 3 for the integral gain of the climb: refused of both ends alike.
    outside = scaled(present, i=0.05)
    with pytest.raises(InputError) as refused:
        tuner.approach(outside, scaled(outside, p=1.1), steps=1, flights=2, to="px4", out=tmp_path / "way")
    said = str(refused.value)
    assert "MPC_Z_VEL_I_ACC" in said and "step 0 of 1" in said and "--previous FILE" in said
    named = said.split("change ")[1].split(";")[0]
    assert named in {gain.address for gain in gain_addresses(present.controller.cascade)}
    assert not (tmp_path / "way").exists()


def test_steps_are_written_with_their_exports_and_other_laws_are_refused(
    present, tmp_path, monkeypatch, capsys, few_golden_vectors
):
    after = scaled(present, omega_c=1.2)
    for name, gains in (("present", present), ("tuned", after), ("pid", tuner.default_gains("pid"))):
        gains.write(tmp_path / f"{name}.json")
    files = [tmp_path / f"{name}.json" for name in ("present", "tuned", "pid")]
    code, out, err = typed(
        monkeypatch, capsys, "approach", *files[:2], "--flights", 2, "--to", "c99", "--out", tmp_path / "way"
    )
    assert code == 0 and "rings first" in out and "Go back by one step" in out, err
    assert {path.name for path in (tmp_path / "way").iterdir()} >= {"approach.json", "step0", "step1"}
    assert dict(tuner.read_gains(tmp_path / "way/step1/gains.json")) == dict(after)
    assert (tmp_path / "way/step1/c99/export.json").exists()
    assert json.loads((tmp_path / "way/approach.json").read_text())["passed"]
    code, _, err = typed(monkeypatch, capsys, "approach", files[0], files[2])
    assert code == 2 and "steps lead between gains of the same laws" in err and err.count("\n") == 1
    with pytest.raises(InputError, match="nothing to approach"):
        tuner.approach(present, present)


def test_factors_are_those_of_gains_that_keep_their_sign():
    before, after = np.array([2.0, 1.0, -4.0, 1.0, 0.0, 0.0]), np.array([1.0, 3.0, -1.0, -1.0, 0.0, 2.0])
    assert factors_between(before, after).tolist() == [2.0, 3.0, 4.0, 1.0, 1.0, 1.0]


@pytest.mark.parametrize(("factor", "steps"), [(1.0, 1), (1.5, 1), (1.51, 2), (2.25, 2), (0.4, 3), (1e6, 8), (1e-9, 8)])
def test_no_step_is_larger_than_half_and_there_are_eight_at_most(factor, steps):
    assert steps_between(np.array([3.0, 1.0]), np.array([3.0 * factor, 1.0])) == steps


def test_both_ends_of_the_way_are_the_gains_to_the_bit():
    draw = np.random.default_rng(9)
    present, tuned = draw.lognormal(size=(2, 1000))
    rows = rows_between(present, tuned, 3)
    assert (rows[0] == present).all() and (rows[-1] == tuned).all()
    np.testing.assert_allclose(rows[1:] / rows[:-1], np.cbrt(tuned / present)[None].repeat(3, axis=0))
