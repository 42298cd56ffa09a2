"""The schema: that of the registries, and judged alike by two implementations of JSON Schema that share no code."""

import copy
import json
from collections import Counter

import jsonschema_rs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from plant.law_registry import LAWS
from tests.tuner.gains.making import SECTIONS, document, neighbour, whole_document
from tuner.gains.schema import gains_schema, schema_text, validator

OTHER = jsonschema_rs.Draft202012Validator(gains_schema())
VALUES = [
    None,
    True,
    0,
    -1.5,
    3,
    1e9,
    "",
    "NaN",
    "1.0",
    "rad",
    "Nm",
    [],
    [1],
    {},
    {"value": 1},
    {"value": 1, "unit": "1"},
]


def accepted(made):
    """The verdict of both, which must be one."""
    ours, other = validator().is_valid(made), OTHER.is_valid(made)
    assert ours == other, json.dumps(made)[:3000]
    return ours


def refused(made):
    """The verdict of the faster one, for variations of a document that `accepted` has judged."""
    return not OTHER.is_valid(made)


def places(value, path=()):
    """Paths of all values inside a document, outer ones first; what is free (x-*) apart."""
    if path:
        yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, part in inner:
        if not (isinstance(key, str) and key.startswith("x-")):
            yield from places(part, (*path, key))


def at(made, path):
    for part in path:
        made = made[part]
    return made


def changed(made, path, value):
    """A document with another value at a place; all other parts are those of the given one."""
    key, *inner = path
    made = copy.copy(made)
    made[key] = changed(made[key], inner, value) if inner else value
    return made


def without(made, path):
    *outer, key = path
    part = copy.copy(at(made, outer))
    del part[key]
    return changed(made, outer, part) if outer else part


def objects(made):
    return [path for path in [(), *places(made)] if isinstance(at(made, path), dict)]


def test_the_text_for_other_programs_is_the_schema_and_made_once():
    assert json.loads(schema_text()) == gains_schema()
    assert gains_schema() is gains_schema() and validator() is validator()


def test_it_is_a_schema_and_closed_everywhere():
    schema = gains_schema()
    Draft202012Validator.check_schema(schema)
    assert jsonschema_rs.meta.is_valid(schema)
    for path in [(), *places(schema)]:
        part = at(schema, path)
        # What is in "properties" and "$defs" is a table of schemas, and those of "if" and "then" only choose.
        if (
            isinstance(part, dict)
            and "properties" in part
            and isinstance(part.get("required"), list)
            and "if" not in path
        ):
            assert part["additionalProperties"] is False, path
    # "gains" alone is closed by the choice of the laws.
    open_ones = [
        path
        for path in places(schema)
        if isinstance(at(schema, path), dict)
        and at(schema, path).get("type") == "object"
        and "additionalProperties" not in at(schema, path)
        and "if" not in path
    ]
    assert open_ones == [("properties", "gains")]


@pytest.mark.parametrize("attitude", LAWS)
def test_every_law_is_accepted_in_either_place(attitude):
    # The schema chooses the gains of either place by the law there alone.
    for position in sorted({attitude, "pid", neighbour(attitude)}):
        made = document(position, attitude)
        assert accepted(made)
        for other in ("pid", "adrc", "hybrid_gsta"):
            if {gain.name for gain in LAWS[other].gains} != {gain.name for gain in LAWS[attitude].gains}:
                assert not accepted(changed(made, ("controller", "attitude"), other))


def test_a_whole_document_is_accepted_and_so_is_one_without_what_is_optional():
    made = whole_document()
    assert accepted(made)
    for key in (*SECTIONS, "sha256"):
        assert accepted(without(made, (key,)))
    for path in [
        ("airframe", "sha256"),
        ("objectives", 0, "interval"),
        ("margins", 0, "amplitude"),
        ("cost", 0, "bytes"),
    ]:
        assert accepted(without(made, path))


def test_a_missing_key_is_an_error_wherever_it_is_required():
    made, tally = whole_document(), Counter()
    for path in places(made):
        if isinstance(path[-1], str):
            tally[accepted(without(made, path))] += 1
            if path[0] in ("airframe", "controller", "gains", "conventions") and path != ("airframe", "sha256"):
                assert not accepted(without(made, path)), path
    assert tally[False] > 150 and tally[True] > 15


def test_an_unknown_key_is_an_error_at_every_level():
    made = whole_document()
    assert accepted(made | {"x-mine": 1})
    for path in objects(made):
        assert not accepted(changed(made, (*path, "valeu"), 1.0)), path
        for key in ("", "roll.kp", "yaw.kp", "yaw", "x"):
            assert refused(changed(made, (*path, key), 1.0)), (path, key)
        if path:
            assert refused(changed(made, (*path, "x-mine"), 1.0)), path


def test_a_wrong_unit_is_an_error_everywhere():
    made = whole_document()
    units = [path for path in places(made) if path[-1] == "unit"]
    assert len(units) > 60
    for path in units:
        assert not accepted(changed(made, path, "Nm")), path
        for unit in ("s^-1", "kg m2", None):
            assert refused(changed(made, path, unit)), path
    named = [path for path in units if path[0] != "objectives"]
    assert all(refused(changed(made, path, "dB")) for path in named)


@pytest.mark.parametrize("law", LAWS)
def test_a_law_without_one_of_its_gains_is_refused(law):
    for made, axes in ((document(law, "pid"), ("x", "y", "z")), (document("pid", law), ("roll", "pitch", "yaw"))):
        own = [address for address in made["gains"] if address.split(".")[0] in axes]
        assert {axis for axis in axes if any(address.startswith(f"{axis}.") for address in own)} == set(axes)
        for address in own:
            assert refused(without(made, ("gains", address))), address
        for address in (own[0], own[-1]):
            assert not accepted(without(made, ("gains", address))), address
        # One too many, by a name that is nearly right.
        assert not accepted(changed(made, ("gains", f"{own[0]}0"), made["gains"][own[0]]))


@pytest.mark.parametrize(
    ("path", "value", "good"),
    [
        (("sha256",), 64 * "a", True),
        (("sha256",), 64 * "a" + "\n", False),
        (("sha256",), 64 * "A", False),
        (("study", "seed"), "9223372036854775807", True),
        (("study", "seed"), "9007199254740993\n", False),
        (("study", "seed"), 2**53, False),
        (("study", "seed"), 7.5, False),
        (("study", "seed"), 7.0, True),
        (("gains", "roll.k2", "value"), 0, True),
        (("gains", "roll.lambda", "value"), 0, False),
        (("gains", "roll.k2", "value"), "NaN", False),
        (("objectives", 0, "interval", "n"), 1, False),
        (("airframe", "actuation", "rotors", 3, "spin"), "ccw", False),
        (("x-note",), [[[1e300]]], True),
    ],
)
def test_ends_of_ranges_and_patterns(path, value, good):
    assert accepted(changed(whole_document(), path, value)) is good


@settings(max_examples=80, database=None, deadline=None)
@given(st.data())
def test_broken_documents_are_judged_alike(data):
    made = whole_document()
    for _ in range(data.draw(st.integers(1, 3))):
        path = data.draw(st.sampled_from(list(places(made))))
        how = data.draw(st.sampled_from(["set", "set", "drop", "add", "swap"]))
        if how == "set":
            made = changed(made, path, data.draw(st.sampled_from(VALUES) | st.floats(-1e3, 1e3) | st.text(max_size=5)))
        elif how == "drop":
            made = without(made, path)
        elif how == "add" and isinstance(at(made, path), dict):
            made = changed(made, (*path, data.draw(st.sampled_from(["unti", "x-", "value", "roll.kp"]))), 1.0)
        elif how == "swap":
            other = data.draw(st.sampled_from(list(places(made))))
            made = changed(made, path, copy.deepcopy(at(made, other)))
    accepted(made)
