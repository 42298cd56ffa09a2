"""Contract violations of a user's file in the terminal: each kind once, however many cases show it."""

import pytest

from tuner.cli.printers.check import grouped_violations, print_own


def violation(message, place="law.py:36", part="step"):
    return {"place": place, "part": part, "message": message}


CASES = [
    "commands -0.425 at rest at 1.7 without an error, in the position loop with the rate measured; it must command 0",
    "commands 75 at rest at -300 without an error, in the attitude loop with the rate from an observer; it must command 0",
    "commands 1e-05 at rest at 1.7 without an error, in the position loop with the rate measured and kp = 0.2; it must command 0",
]


def test_cases_of_one_clause_are_one_violation():
    ((first, others),) = grouped_violations([violation(text) for text in CASES])
    assert first["message"] == CASES[0] and others == 2


@pytest.mark.parametrize(
    "other",
    [
        violation("hardly commands anything on inputs of order one, in the position loop with the rate measured"),
        violation(CASES[1], part="start"),
        violation(CASES[1], place="law.py:40"),
    ],
    ids=["clause", "part", "line"],
)
def test_another_clause_part_or_line_is_another_violation(other):
    assert grouped_violations([violation(CASES[0]), other]) == [(violation(CASES[0]), 0), (other, 0)]


def test_the_number_of_cases_alike_is_printed(capsys):
    content = {"file": "law.py", "kind": "law", "name": "mine", "digest": "0"}
    print_own({**content, "breaches": [violation(text) for text in CASES]})
    assert capsys.readouterr().out == f"law.py:36: step: {CASES[0]} (and in two more cases alike; --json has all)\n"
    print_own({**content, "breaches": [violation(CASES[0])]})
    assert capsys.readouterr().out == f"law.py:36: step: {CASES[0]}\n"
