"""Names, docstrings, messages and pages keep to the rules: the counts of `tests/words.json` may only fall."""

import ast

import pytest

from tests import sentences, words

CHAINED = '"""Fly.\n\n law: flown; gains: of it; seed: of the air.\n """'
LISTED = '"""Fly.\n\n Args:\n     law: flown.\n     gains: gains of it.\n     seed: root seed.\n """'
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
    ("constant without noun", "MOST_TRIES = 3", "MAX_TRIES = 3"),
    ("constant without noun", "class A:\n SMALL: float = 1e-9", "class A:\n MIN_STEP: float = 1e-9"),
    ("constant without noun", "BALANCED = 1e-12", 'COMPLETED = "completed"; TILTED = Status.TILTED; SPEED = 2.0'),
    ("constants together", 'A, B = 1, 2\n"Limits."', 'A, B = 1, 2\nC = 3\n"Limit."'),
    ("headless description", 'TRIES = 3\n"Of a fit."', 'TRIES = 3\n"Number of fits."'),
    ("headless description", f"def f(law): {LISTED.replace('flown', 'that flies')}", f"def f(law): {LISTED}"),
    (
        "headless description",
        f"class A: {LISTED.replace('Args', 'Attributes').replace('gains of it', 'whose')}",
        "class A: ...",
    ),
    ("free relative", '"""Air.\n\nWhat is drawn is kept."""', '"""Air.\n\nThe draws are kept. What now?"""'),
    ("passive of speech", 'raise E(f"{x} was told before as {y}")', 'raise E(f"{x} was submitted before as {y}")'),
    ("figure of speech", 'print("the log tells nothing of it")', 'print("the pilot tells the log by its name")'),
    ("old sense", 'print(f"begin {x} anew with --out")', 'print(f"begin {x} again with --out")'),
    (
        "old sense",
        'print("leave it out, for a contest has none")',
        'print("one file for a contest, for flights that are short")',
    ),
    ("old sense", 'print("Where none is given, it is 0.")', 'print("Place where it is written: X.")'),
]
PAGE = """# What is shown

- nobody reads this
- a list
  that is told

    What is typed is code.

| what | `it is told` |
|---|---|
| What is drawn | [whoever](a.md) |

```sh
echo anew
```
"""


@pytest.mark.parametrize(("rule", "bad", "good"), EXAMPLES)
def test_each_rule_names_what_breaks_it_and_nothing_else(rule, bad, good):
    assert [place.rule for place in words.places(ast.parse(bad))] == [rule]
    assert not list(words.places(ast.parse(good)))


def test_markdown_is_read_without_headings_and_code_cell_by_cell():
    faults = list(sentences.faults(sentences.markdown_prose(PAGE)))
    assert faults == [
        ("old sense", "nobody reads this"),
        ("passive of speech", "a list that is told"),
        ("free relative", "What is drawn"),
        ("old sense", "whoever"),
    ]


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
