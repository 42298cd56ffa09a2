"""Every unit that the tool can produce has a UCUM code, valid and of the same dimension by an independent implementation."""

import re

import pytest

from objectives.margins.quantities import QUANTITIES as MARGINS
from objectives.metrics import all_addresses, parse
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.quadrotor.airframes.schema import GROUPS, LENGTH, OPTIONAL, SCALARS
from tuner.extensions.processor_cost.requirement import QUANTITIES
from tuner.extensions.theory.theorems import THEOREMS
from tuner.gains.quantities import UCUM, ucum

LOOPS = ("position", "attitude")
OURS = {
    "laws": {gain.unit_in(loop) for law in LAWS.values() for gain in law.gains for loop in LOOPS},
    "nonlinear terms": {term.unit.replace("{y}", y) for law in LAWS.values() for term in law.nonlinear for y in ("rad", "m")},
    "metrics": {parse(address).unit for address in all_addresses()},
    "airframes": {field.unit for field in [*SCALARS.values(), *OPTIONAL.values(), *GROUPS.values(), LENGTH]},
    "margins": {unit for entry in MARGINS.values() for unit in (entry.unit, entry.limit_unit)},
    "theorems": {theorem.unit_in(loop) for theorem in THEOREMS.values() for loop in LOOPS},
    "controller": {"s", "rad", "1", "N", "Hz"},
    "costs": {quantity.unit for quantity in QUANTITIES.values()},
}  # fmt: skip
ROOTS = {"m^(1/2) s^(-3/2)", "rad^(1/2) s^(-3/2)", "m^(-1/2) s^(1/2)", "rad^(-1/2) s^(1/2)"}


@pytest.fixture(scope="module")
def oracle():
    """The units of pint by the grammar of UCUM."""
    return pytest.importorskip("ucumvert").PintUcumRegistry()


def powers(unit):
    """Base units of one of our spellings with their powers: "N s2/m2", "rad^2 s", "m s^-2", "rad^(1/2) s^(-3/2)"."""
    found, sign = {}, 1.0
    for token in re.findall(r"/(?!\d)|[A-Za-z]+\^?\(?-?\d*(?:/\d+\))?", re.sub(r"^1/", "/", unit)):
        if token == "/":
            sign = -1.0
            continue
        [(name, power)] = re.findall(r"^([A-Za-z]+)\^?\(?(-?\d*(?:/\d+)?)\)?$", token)
        top, _, bottom = (power or "1").partition("/")
        found[name] = found.get(name, 0.0) + sign * float(top) / float(bottom or 1)
    return found


def test_powers_reads_our_spellings():
    assert powers("N s2/m2") == {"N": 1, "s": 2, "m": -2}
    assert powers("rad^2 s") == {"rad": 2, "s": 1} and powers("m s^-2") == {"m": 1, "s": -2}
    assert (
        powers("1/s") == {"s": -1} and powers("rad/s^3") == {"rad": 1, "s": -3} and powers("m/s2") == {"m": 1, "s": -2}
    )
    assert powers("rad^(1/2) s^(-3/2)") == {"rad": 0.5, "s": -1.5}


@pytest.mark.parametrize("kind", OURS)
def test_every_unit_has_a_code(kind):
    assert OURS[kind] <= UCUM.keys()
    assert all(ucum(unit) == UCUM[unit] for unit in OURS[kind])


def test_nothing_is_in_the_table_that_nothing_produces():
    # Newtons and newton metres are units of commands, kilograms one of the table of another file.
    assert UCUM.keys() - set().union(*OURS.values()) <= {"N m", "m/s^3", "rad/s^3", "m/s^2", "rad/s^2", "rad s"}


@pytest.mark.parametrize("code", sorted({*UCUM.values(), "By"}))
def test_codes_are_valid(code, oracle):
    parse_ucum = pytest.importorskip("ucumvert").get_ucum_parser().parse
    parse_ucum(code)
    assert not re.search(r"\^(?![^{]*})|\*| ", code)


def test_the_oracle_refuses_what_is_no_code():
    parse_ucum = pytest.importorskip("ucumvert").get_ucum_parser().parse
    for wrong in ("Nm", "N*m", "s^-1", "kg m2"):
        with pytest.raises(Exception, match=r".*"):
            parse_ucum(wrong)


@pytest.mark.parametrize("unit", sorted(UCUM.keys() - ROOTS - {"1", "%", "dB", "byte"}))
def test_code_and_spelling_are_the_same_unit(unit, oracle):
    expected = oracle.from_ucum("1")
    for name, power in powers(unit).items():
        expected = expected * oracle.from_ucum(name) ** power
    found = oracle.from_ucum(UCUM[unit])
    # Radians count: s-1 for rad/s would be told.
    assert found.units == expected.units and found.magnitude == expected.magnitude == 1.0


@pytest.mark.parametrize("unit", sorted(ROOTS))
def test_roots_are_annotations_that_say_the_powers(unit):
    """UCUM has whole exponents only: rad1/2.s-3/2 would be valid and mean rad/2 s^-3/2."""
    code = UCUM[unit]
    assert code[0] == "{" and code[-1] == "}"
    inner = code[1:-1]
    told = {part.split("^")[0]: float(part.split("^")[1]) for part in inner.split(".s^")[:1]}
    told["s"] = float(inner.split(".s^")[1])
    assert told == powers(unit)


def test_an_unknown_unit_says_where_to_add_it():
    with pytest.raises(InputError, match="furlong.*quantities.py"):
        ucum("furlong")
