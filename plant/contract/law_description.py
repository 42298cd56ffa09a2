"""Clauses on a law's description: gains with symbols, units and ranges, its promises, and names that have to agree."""

import re
from collections.abc import Iterator
from typing import Any

from plant.contract.axis import LOOPS
from plant.contract.violation import ContractViolation
from plant.errors import InputError
from plant.laws.law import PROMISES, GainInfo, Law
from plant.model.functions import check_model_function
from plant.records import is_record
from plant.texts import check_text, check_title

NAME = r"[a-z][a-z0-9_]{0,39}"
# Arguments of the functions of a law.
ARGUMENTS = {"prepare": 2, "start": 3, "step": 7}
RECORDS = ("Gains", "Constants", "Memory")
# Names that C has taken; records become structs.
TAKEN = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if inline int long register restrict "
    "return short signed sizeof static struct switch typedef union unsigned void volatile while".split()
)


def parts_are_there(law: Law) -> Iterator[ContractViolation]:
    """Records of floats, and model functions of the right number of arguments."""
    for name in RECORDS:
        yield from _record(name, getattr(law, name))
    for name, arguments in ARGUMENTS.items():
        try:
            check_model_function(getattr(law, name), name, arguments, _file(law), "Memory")
        except InputError as error:
            yield ContractViolation(error.key or name, error.message, error.file or "")


def _file(law: Law) -> str:
    return "" if law.origin is None else law.origin.place


def _record(name: str, record: Any) -> Iterator[ContractViolation]:
    if not is_record(record):
        yield ContractViolation(name, f"given {record!r}; write class {name}(NamedTuple) with a float for every field")
        return
    if not record.__annotations__:
        yield ContractViolation(name, "has no field; C has no empty struct, so give it one, such as unused: float")
    for field, part in record.__annotations__.items():
        nested = is_record(part)
        if isinstance(part, str):
            yield ContractViolation(
                name,
                f"the field '{field}' is the text {part!r}; take `from __future__ import annotations` out of the file",
            )
        elif part is not float and not nested:
            yield ContractViolation(name, f"the field '{field}' is {part!r}; it must be float or another such record")
        elif nested:
            yield from _record(f"{name}.{field}", part)
        if field in TAKEN:
            yield ContractViolation(
                name, f"the field '{field}' has the name of a word of C; give it another, such as {field}_"
            )


def words_are_there(law: Law) -> Iterator[ContractViolation]:
    """A name that can stand in addresses and in C, a title, a source, how it is sampled."""
    if not re.fullmatch(NAME, law.name):
        yield ContractViolation(
            "name", f"given '{law.name}'; a name is a small letter and then small letters, digits and _, up to 40"
        )
    for key in ("title", "source", "sampling"):
        try:
            check_title(getattr(law, key), key=key)
        except InputError as error:
            yield ContractViolation(key, error.message)
    if unknown := sorted(set(law.promises) - PROMISES):
        yield ContractViolation(
            "promises", f"given {', '.join(map(repr, unknown))}; allowed: {', '.join(sorted(PROMISES))}"
        )


def every_gain_is_described(law: Law) -> Iterator[ContractViolation]:
    """One entry for each field of Gains, in their order, with symbol, unit, meaning and source."""
    names = tuple(gain.name for gain in law.gains)
    if names != law.Gains._fields:
        yield ContractViolation(
            "Gains",
            f"gains describes {', '.join(names)}; it must describe {', '.join(law.Gains._fields)}, in this order",
        )
    if len({gain.symbol for gain in law.gains}) != len(law.gains):
        yield ContractViolation("Gains", "two gains have the same symbol; give each its own")
    for gain in law.gains:
        for key in ("symbol", "unit", "meaning", "source"):
            if not getattr(gain, key):
                yield ContractViolation("Gains", f"the gain '{gain.name}' has no {key}")
            else:
                check_text(getattr(gain, key), key="Gains")
        check_text(gain.term, key="Gains")
        if gain.term and (gain.exclusive or gain.least != 0.0):
            yield ContractViolation("Gains", f"the gain '{gain.name}' has a term that is off at 0, which it cannot be")
        if gain.scale not in ("log", "linear"):
            yield ContractViolation(
                "Gains", f'the gain \'{gain.name}\' has the scale {gain.scale!r}; allowed: "log", "linear"'
            )
        if "{" in gain.unit_in("attitude") + gain.unit_in("position"):
            yield ContractViolation(
                "Gains", f"the gain '{gain.name}' has the unit {gain.unit!r}; only {{y}} is replaced by rad or m"
            )


def ranges_hold_their_defaults(law: Law) -> Iterator[ContractViolation]:
    """In both loops the range of a gain holds its default and nothing that is meaningless."""
    for gain in law.gains:
        for loop in LOOPS:
            if problem := _range_problem(gain, loop):
                yield ContractViolation("Gains", f"the {loop} range of '{gain.name}', {_span(gain, loop)}, {problem}")


def _span(gain: GainInfo, loop: str) -> str:
    span = gain.span(loop)
    return f"{span.low:g} to {span.high:g}"


def _range_problem(gain: GainInfo, loop: str) -> str:
    span = gain.span(loop)
    if not span.low < span.high:
        return "is empty; give low below high"
    if not span.low <= span.default <= span.high:
        return f"does not hold its default {span.default:g}"
    if span.low < gain.least or (gain.exclusive and span.low == gain.least):
        return f"reaches below its least meaningful value {gain.least:g}"
    if gain.scale == "log" and span.low <= 0.0:
        return "reaches 0, which a logarithmic scale cannot"
    return ""


def what_proofs_ask_for_agrees(law: Law) -> Iterator[ContractViolation]:
    """A sector belongs to a continuous form, and the gains of a super-twisting term are gains."""
    if law.sector is not None and law.continuous is None:
        yield ContractViolation("sector", "is given without continuous, the form that it is about")
    if law.super_twisting is not None:
        term = law.super_twisting
        for name in {term.k1, term.k2, term.mu or term.k1} - set(law.Gains._fields):
            yield ContractViolation(
                "super_twisting", f"names '{name}', which is no gain; gains: {', '.join(law.Gains._fields)}"
            )
