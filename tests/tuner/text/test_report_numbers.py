"""Numbers and units as text, against examples written by hand."""

from math import pi

import pytest

from tuner.documents.parts import Estimate, in_shown_units
from tuner.documents.summary import ComparedState, RequiredRow
from tuner.text.numbers import count, duration, estimate, ordinal, per_cent, significant
from tuner.text.units import bracketed, in_degrees, marked_up, plain

THIN = "\u202f"


@pytest.mark.parametrize(
    ("numbers", "shown"),
    [
        ((0.43217, 0.4112, 0.4507), ("0.432", "[0.411, 0.451]")),
        ((12.3456, 10.9, 13.4), ("12.3", "[10.9, 13.4]")),
        ((1234.5, 1100.0, 1400.0), ("1234", "[1100, 1400]")),
        ((123456.0, 110000.0, 140000.0), (f"123{THIN}456", f"[110{THIN}000, 140{THIN}000]")),
        ((-0.222, -0.239, -0.2061), ("−0.222", "[−0.239, −0.206]")),
        ((0.0, 0.0, 0.0), ("0", "[0, 0]")),
        ((0.5, 0.5, 0.5), ("0.5000", "[0.5000, 0.5000]")),
        # Too fine for five decimals: a common power of ten.
        ((1.234e-6, 1.20e-6, 1.27e-6), ("1.234 × 10⁻⁶", "[1.200, 1.270] × 10⁻⁶")),
        ((2.5e7, 2.4e7, 2.6e7), ("2.50 × 10⁷", "[2.40, 2.60] × 10⁷")),
        ((-1e-4, -0.02, 0.02), ("0.000", "[−0.020, 0.020]")),
        ((None, None, None), ("–", "–")),
        ((0.25, float("nan"), 1.0), ("0.25", "–")),
    ],
)
def test_digits_follow_the_interval(numbers, shown):
    assert estimate(*numbers) == shown


def test_signed_numbers_carry_a_plus_but_zero_does_not():
    assert estimate(0.05, -0.01, 0.11, signed=True) == ("+0.05", "[−0.01, +0.11]")
    assert estimate(0.0, 0.0, 0.0, signed=True) == ("0", "[0, 0]")


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (5.0, "5"),
        (0.1, "0.1"),
        (6.10349, "6.103"),
        (20000.0, f"20{THIN}000"),
        (-3.5, "−3.5"),
        (0.0, "0"),
        (1.5e-7, "1.5 × 10⁻⁷"),
        (3e9, "3 × 10⁹"),
        (999999.0, f"999{THIN}999"),
        (None, "–"),
    ],
)
def test_significant_digits_without_trailing_zeros(value, shown):
    assert significant(value) == shown


def test_spans_counts_and_shares():
    assert [duration(t) for t in (0.84, 42.4, 252.0, 7500.0)] == ["0.84 s", "42 s", "4 min 12 s", "2 h 5 min"]
    assert [ordinal(n) for n in (1, 2, 3, 4, 11, 12, 22, 111, 1003)] == [
        "", "2nd ", "3rd ", "4th ", "11th ", "12th ", "22nd ", "111th ", "1,003rd ",
    ]  # fmt: skip
    assert [duration(t) for t in (59.7, 3599.8)] == ["1 min 0 s", "1 h 0 min"]
    assert [count(n) for n in (9999, 16896.0)] == ["9999", f"16{THIN}896"]
    assert [per_cent(s) for s in (0.0, 0.0123, 0.38, None)] == ["0 %", "1.2 %", "38 %", "–"]


@pytest.mark.parametrize(
    ("unit", "shown", "factor"),
    [
        ("rad", "°", 180 / pi),
        ("rad s", "° s", 180 / pi),
        ("rad^2 s", "°^2 s", (180 / pi) ** 2),
        ("rad/s", "°/s", 180 / pi),
        ("m", "m", 1.0),
        ("1/s", "1/s", 1.0),
        ("1", "", 1.0),
        ("1/rad", "1/rad", 1.0),
        ("rad^(1/2) s^(-3/2)", "rad^(1/2) s^(-3/2)", 1.0),
        ("grad", "grad", 1.0),
    ],
)
def test_angles_become_degrees(unit, shown, factor):
    assert in_degrees(unit) == (shown, pytest.approx(factor, rel=1e-15))


def test_exponents_are_raised():
    assert plain("°^2 s^-1") == "°² s⁻¹"
    assert marked_up("rad^(1/2) s^(-3/2)") == "rad<sup>1/2</sup> s<sup>−3/2</sup>"
    assert marked_up("<b>^2") == "&lt;b&gt;<sup>2</sup>"
    assert (bracketed("x", "m^2"), bracketed("x", "")) == ("x [m²]", "x")


def test_a_row_of_a_document_is_printed_in_its_shown_unit():
    """Factors as dB, the difference as that of levels; what is infinite stays so, what has no other unit stays as it is."""
    nothing = Estimate(None, None, None)
    row = RequiredRow(
        label="gain_margin",
        quantity="",
        unit="1",
        shown_unit="dB",
        kind="requirement",
        limit=10.0,
        sense="min",
        verdict="kept",
        default=Estimate(2.0, None, None),
        tuned=Estimate(4.0, None, None),
        difference=Estimate(2.0, None, None),
        states=[ComparedState(state="hover", default=2.0, tuned=None)],
    )
    shown = in_shown_units(row)
    assert (shown.unit, shown.limit) == ("dB", pytest.approx(20.0))
    assert shown.tuned.value == pytest.approx(12.0412, abs=1e-4) and shown.tuned.low is None
    assert shown.difference.value == pytest.approx(6.0206, abs=1e-4)
    assert (shown.states[0].default, shown.states[0].tuned) == (pytest.approx(6.0206, abs=1e-4), None)
    angle = in_shown_units(
        row.model_copy(update={"shown_unit": "deg", "limit": pi / 4.0, "tuned": nothing, "difference": nothing})
    )
    assert (angle.unit, angle.limit, angle.tuned) == ("deg", pytest.approx(45.0), nothing)
    plain_row = row.model_copy(update={"shown_unit": None})
    assert in_shown_units(plain_row) is plain_row
