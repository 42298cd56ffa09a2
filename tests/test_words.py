"""Names and first lines of docstrings keep to the rules: the counts of `tests/words.json` may only fall."""

import ast

import pytest

from tests import words

CHAINED = '"""Fly.\n\n law: flown; gains: of it; seed: of the air.\n """'
LISTED = '"""Fly.\n\n Args:\n    law: flown.\n    gains: of it.\n    seed: of the air.\n """'
# Rule, a text that breaks it, one that keeps to it.
EXAMPLES = [
    ("banned name", "told = 1", "total = 1"),
    ("banned name", "def fly(_own): ...", "def fly(user): ..."),
    ("banned name", "self.KEPT = 1", "self.state = self.kept"),
    ("banned name", "import casadi as here", "from . import told"),
    ("banned class", "class _Hope: ...", "class FeasibilityAcquisition: ..."),
    ("British spelling", "def normalise(): ...", "def noise(): ..."),
    ("British spelling", "class LinearisedLoop: ...", "class PromisedLoop: ..."),
    ("Return what", 'def f(): "Return what flies."', 'def f(): "Return the flights: what flies."'),
    ("long first line", f'"""{"word " * 13}."""', f'"""{"word " * 12}: {"word " * 9}"""'),
    ("chained parameters", f"def fly(law, gains, seed): {CHAINED}", f"def fly(law, gains, seed): {LISTED}"),
    ("chained parameters", f"class A:\n {CHAINED}\n law: int\n gains: int\n seed: int", f"class A:\n {LISTED}"),
]


@pytest.mark.parametrize(("rule", "bad", "good"), EXAMPLES)
def test_each_rule_names_what_breaks_it_and_nothing_else(rule, bad, good):
    assert [place.rule for place in words.places(ast.parse(bad))] == [rule]
    assert not list(words.places(ast.parse(good)))


def test_counts_are_those_of_the_table():
    assert not (lines := words.differences(words.recorded(), words.counts(), words.places_by_room())), "\n".join(lines)


def test_a_count_that_rose_is_refused_with_its_places_and_one_that_fell_asks_for_a_lower_table():
    table, counted = {"rule": {"a": 2, "b": 2, "c": 1}}, {"rule": {"a": 1, "b": 3, "c": 1}, "new": {"d": 1}}
    places = {("rule", "b"): ["b/x.py:7: told"], ("new", "d"): ["d/y.py:1: Hope"]}
    assert words.differences(table, counted, places) == [
        "new in d: 1, at most 0 allowed:\n  d/y.py:1: Hope",
        "rule in a: 1, down from 2; run `python -m tests.words`",
        "rule in b: 3, at most 2 allowed:\n  b/x.py:7: told",
    ]
