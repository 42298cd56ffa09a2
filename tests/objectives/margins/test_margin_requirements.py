"""Margins as numbers with limits: what is read, which way is better, and what loops that are not stable are worth."""

from dataclasses import replace

import numpy as np
import pytest

from objectives.margins.block import EVERY
from objectives.margins.describing import DEFAULT_CASES
from objectives.margins.quantities import LIMITABLE, LOOP_QUANTITIES, QUANTITIES, RECORDED, REPORTED
from objectives.margins.requirement import MarginRequirement, requirement_label
from objectives.margins.results import Worst
from objectives.requirements import LARGEST_VIOLATION
from plant.quadrotor.cascade import ATTITUDE_AXES, AXES
from plant.quadrotor.gains import GROUPS
from tests.objectives.margins.designs import H, default_gains, gains_with, model_of, random_gains

PAIR = ("ladrc", "ladrc")
SLOW, UNSTABLE = {"roll__omega_c": 2.0}, {"roll__omega_c": 60.0}


@pytest.fixture(scope="module")
def margins():
    """Default gains, a slower roll loop, and a roll loop that is not stable."""
    rows = [default_gains(*PAIR)[None], gains_with(*PAIR, **SLOW), gains_with(*PAIR, **UNSTABLE)]
    return model_of(*PAIR).evaluate(np.concatenate(rows, axis=0))


def limited(name, limit, axes=AXES, **more):
    return MarginRequirement(LIMITABLE[name], requirement_label(name), axes, limit, **more)


def values(name, margins, axes):
    """Numbers of a quantity in the worst of some axes, in the unit of limits."""
    return limited(name, 1.0, axes).values(margins)


@pytest.mark.parametrize("name", [name for name, quantity in LIMITABLE.items() if not quantity.is_multiloop])
def test_the_worst_of_the_axes_counts(name, margins):
    quantity = LIMITABLE[name]
    single = np.stack([values(name, margins, (axis,)) for axis in AXES], axis=1)
    for group, axes in GROUPS.items():
        chosen = [dict(zip(AXES, row, strict=True)) for row in single]
        pick = min if quantity.sense == "min" else max
        expected = [pick([value for name, value in row.items() if name in axes]) for row in chosen]
        assert values(name, margins, axes).tolist() == expected, group


def test_the_table_is_one():
    assert all(name == entry.name and entry.label and entry.meaning for name, entry in QUANTITIES.items())
    assert {*RECORDED, *REPORTED} <= set(QUANTITIES) and set(QUANTITIES) - set(LIMITABLE) == {"crossover"}
    assert len({entry.field for entry in LOOP_QUANTITIES}) == len(LOOP_QUANTITIES)
    for entry in QUANTITIES.values():
        assert entry.unit in {"1", "rad", "s", "rad/s", "s^-3"} and entry.sense in {"min", "max"}
        # A value of a file, as a limit and back; shown and limited in the same unit, but for delays, which are limited in s.
        assert entry.from_limit(entry.to_limit(1.7)) == pytest.approx(1.7, rel=1e-12)
        assert entry.shown_unit == entry.limit_unit or (entry.shown_unit, entry.limit_unit) == ("ms", "s")


def test_files_hold_what_the_margins_are(margins):
    """In SI units whatever a person is shown: factors, radians and seconds of the record itself."""
    for entry in LOOP_QUANTITIES:
        np.testing.assert_array_equal(entry.values(margins), getattr(margins, entry.field).value)
    for name, unit, shown in (("phase_margin", "rad", "deg"), ("gain_up", "1", "dB"), ("ms", "1", None)):
        asked = limited(name, 2.0, ("roll",)).requirement
        assert asked.units() == ({"unit": unit} if shown is None else {"unit": unit, "shown_unit": shown})
        stored = asked.in_file(values(name, margins, ("roll",)))
        np.testing.assert_allclose(stored[:2], QUANTITIES[name].values(margins)[:2, AXES.index("roll")], rtol=1e-12)


def test_units_are_those_of_a_person(margins):
    roll = AXES.index("roll")
    up, down = margins.gain_up.value[0, roll], margins.gain_down.value[0, roll]
    both = values("gain_margin", margins, ("roll",))[0]
    # A factor is what 10 to a twentieth of its decibels gives back; the lesser of the two is on the way to none.
    assert 10.0 ** (both / 20.0) == pytest.approx(min(up, down), rel=1e-12)
    assert 10.0 ** (values("gain_up", margins, ("roll",))[0] / 20.0) == pytest.approx(up, rel=1e-12)
    assert 10.0 ** (values("gain_down", margins, ("roll",))[0] / 20.0) == pytest.approx(down, rel=1e-12)
    phase = values("phase_margin", margins, ("roll",))[0]
    assert np.exp(1j * np.pi * phase / 180.0) == pytest.approx(np.exp(1j * margins.phase.value[0, roll]), rel=1e-12)
    delay = values("delay_margin", margins, ("roll",))[0]
    assert values("delay_periods", margins, ("roll",))[0] * H == pytest.approx(delay, rel=1e-12)
    # Between the delay margin and the phase margin stands the crossover at which it is met.
    assert delay * margins.delay.frequency[0, roll] >= np.radians(phase) - 1e-9


def test_inequalities_between_margins_hold(margins):
    ms = values("ms", margins, AXES)[:2]
    phase, up = values("phase_margin", margins, AXES)[:2], values("gain_up", margins, AXES)[:2]
    assert np.all(np.sin(np.radians(phase) / 2.0) >= 0.5 / ms - 1e-9)
    assert np.all(10.0 ** (up / 20.0) >= ms / (ms - 1.0) - 1e-9)
    disk, together = (
        values("disk", margins, ("z", *ATTITUDE_AXES)),
        values("multiloop_disk", margins, ()),
    )
    assert np.all(together <= disk + 1e-9)
    assert np.all(disk[:2] <= 2.0)


@pytest.mark.parametrize("name", LIMITABLE)
def test_a_loop_that_is_not_stable_keeps_no_limit_and_violations_are_finite(name, margins):
    quantity = LIMITABLE[name]
    limit = 1.001 * quantity.low if quantity.low else 1e-3
    asked = limited(name, limit if quantity.sense == "min" else 1e6, () if quantity.is_multiloop else ("roll",))
    values = asked.values(margins)
    assert not np.isnan(values).any()
    violations = asked.requirement.violations(values)
    assert violations[:2].tolist() == [0.0, 0.0]
    assert 0.0 < violations[2] <= LARGEST_VIOLATION
    assert margins.stable[:, AXES.index("roll")].tolist() == [True, True, False]


def test_violations_are_shares_of_the_limit(margins):
    asked = limited("phase_margin", 90.0, ("roll",))
    value = asked.values(margins)
    np.testing.assert_allclose(asked.requirement.violations(value), 1.0 - value / 90.0, rtol=1e-12)
    peak = limited("ms", 1.01, ("roll",))
    value = peak.values(margins)[:2]
    np.testing.assert_allclose(peak.requirement.violations(value), value / 1.01 - 1.0, rtol=1e-12)


def test_a_requirement_says_what_it_is():
    every = limited("phase_margin", 35.0, ("roll", "pitch"), hard=False, spread=True).requirement
    assert (every.unit, every.sense, every.limit, every.hard) == ("deg", "min", 35.0, False)
    assert every.quantity.endswith("worst of roll, pitch; worst vehicle of the spread")
    assert "worst" not in limited("ms", 2.0, ("yaw",)).requirement.quantity
    assert "worst" not in limited("multiloop_disk", 0.5, ()).requirement.quantity


def test_labels_tell_apart_what_differs():
    given = [
        requirement_label("ms", axis, hard=hard, spread=spread, amplitude=amplitude)
        for axis in (None, "tilt", "yaw")
        for hard in (True, False)
        for spread in (True, False)
        for amplitude in (0.0, 0.1)
    ]
    assert len(set(given)) == len(given)
    assert requirement_label("ms") == "ms"
    assert requirement_label("ms", "tilt") == "ms(tilt)"
    assert requirement_label("ms", "tilt", hard=False, spread=True, amplitude=0.1) == "ms(tilt, from 0.1, spread, soft)"


LIMITS = {
    "quickstart": (("phase_margin", "gain_margin", "ms", "delay_periods"), AXES),
    "every quantity": (tuple(LIMITABLE), AXES),
    "an axis that mirrors another": (("disk", "load_index"), ("roll", "yaw")),
    "a linear axis": (("ms",), ("z",)),
}


@pytest.mark.parametrize("limits", LIMITS.values(), ids=LIMITS)
def test_limits_alone_have_the_bits_of_all_margins_in_any_batch(limits):
    """Of candidates that are stable and not, with shared gains, where loops are mirrors, and with own ones."""
    names, axes = limits
    asked = [limited(name, 1.0, () if QUANTITIES[name].is_multiloop else axes) for name in names]
    model = model_of("ladrc", "hybrid", cases=DEFAULT_CASES)
    gains = np.concatenate([random_gains("ladrc", "hybrid", 24, 3, 0.8), default_gains("ladrc", "hybrid")[None]])
    margins = model.evaluate(gains)
    assert 5 < margins.stable.all(axis=1).sum(axis=0) < 24
    wanted = np.stack([entry.values(margins) for entry in asked], axis=1)
    for size in (25, 7, 1):
        found = [model.limited(gains[i : i + size], asked) for i in range(0, len(gains), size)]
        np.testing.assert_array_equal(np.concatenate(found), wanted)
    assert model.limited(gains[:0], asked).shape == (0, len(asked))


def test_a_limit_reads_the_fields_that_it_says(margins):
    """A quantity that was not asked for is empty, so whoever reads it by mistake fails."""
    for entry in QUANTITIES.values():
        nothing = Worst(*[column[:0] for column in margins.multiloop])
        bare = replace(margins, **{name: nothing for name in EVERY if name not in entry.fields})
        np.testing.assert_array_equal(entry.values(bare), entry.values(margins))
