"""`tuner check my_law.py` tells what a law breaks, with file and line; each way of breaking it is told as such."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from plant.contract import law_behaviour as behaviour
from plant.contract.law_contract import FLIES, violations_of_law
from plant.contract.violation import ContractViolation, violations_of
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.laws.channel import Measured
from plant.own_code import run_own_code
from tests.plant.own_files import LAW, edited, line_of

ERROR = "error, rate = setpoint.value - measured.value, setpoint.rate - measured.rate"
RETURN = "return demand / channel.b0, Memory(integral + h * constants.ki * error)"


def told(file: Path) -> list[ContractViolation]:
    """Return what the contract tells of a file."""
    return violations_of_law(run_own_code(file).names["LAW"], str(file))


def test_the_shipped_law_keeps_it() -> None:
    assert told(LAW) == []


# What is written, what the message holds, and a text of the line that it points at.
STATEMENTS = {
    "if": (ERROR, f"{ERROR}\n    if error > 1.0:\n        error = 1.0", "`if` on a value", "if error"),
    "conditional": (ERROR, f"{ERROR}\n    error = error if error < 1.0 else 1.0", "select(condition", "error if"),
    "and": (ERROR, f"{ERROR}\n    small = error > 0.0 and rate > 0.0", "both(a, b)", "and rate"),
    "chain": (ERROR, f"{ERROR}\n    small = 0.0 < error < 1.0", "chain of comparisons", "0.0 < error"),
    "loop": (ERROR, f"{ERROR}\n    for _ in range(3):\n        error = error", "a loop", "for _"),
    "hidden": (ERROR, f"global LAST\n    {ERROR}\n    LAST = error", "keep it in Memory", "global LAST"),
    "stored": (ERROR, f"{ERROR}\n    step.last = error", "'step.last'", "step.last"),
    "builtin": (ERROR, f"{ERROR}\n    error = abs(error)", "write absolute", "def step"),
    "arguments": ("    applied: Applied,\n", "", "must take 7", "def step"),
}  # fmt: skip


@pytest.mark.parametrize("way", STATEMENTS)
def test_a_statement_that_no_model_function_has_is_told_with_its_line(way: str, tmp_path: Path) -> None:
    old, new, message, line = STATEMENTS[way]
    file = edited(LAW, tmp_path, (old, new))
    first = told(file)[0]
    assert message in first.message and first.part == "step"
    assert first.place == f"{file}:{line_of(file, line)}"


OTHER = {
    "numpy": (
        "from typing import NamedTuple\n",
        "from typing import NamedTuple\nimport numpy as np\n",
        "plant.primitives",
    ),
    "list": ("SOURCE = ", "SEEN = []\nSOURCE = ", "'SEEN'"),
}
USES = {"numpy": "np.sign(error)", "list": "SEEN[0]"}


@pytest.mark.parametrize("way", OTHER)
def test_what_backends_cannot_replace_is_told(way: str, tmp_path: Path) -> None:
    old, new, message = OTHER[way]
    file = edited(LAW, tmp_path, (old, new), (ERROR, f"{ERROR}\n    error = error * {USES[way]}"))
    assert message in told(file)[0].message


# Behaviour: what is written instead, the function that breaks it, and what the message holds.
BEHAVIOUR = {
    "nan at start": ("return Memory(held)", "return Memory(held * float_nan)", "start", "nan"),
    "wrong record": ("return Memory(held)", "return constants", "start", "must give Memory"),
    "not a pair": (RETURN, "return demand / channel.b0", "step", "must give (command, Memory)"),
    "sign": ("demand = setpoint.acceleration + constants.kp * error", "demand = setpoint.acceleration - constants.kp * error",
             "step", "its sign is wrong"),
    "absolute": ("constants.kp * error + integral", "constants.kp * error + integral + 0.5 * measured.value", "step", "moved by 64"),
    "units of u": (RETURN, RETURN.replace("demand / channel.b0", "demand"), "step", "1/channel.b0"),
    "integral off": ("h * constants.ki * error)", "0.0 * h * constants.ki * error)", "step", 'promises "rejects"'),
    "acceleration": ("demand = setpoint.acceleration + ", "demand = ", "step", 'promises "tracks"'),
    "windup": (" * applied.excess", " * applied.excess * 0.0", "step", "winds up"),
    "amplitude": ("constants.kp * error + integral", "constants.kp * error * (1.0 + error * error) + integral", "step",
                  "depends on an amplitude"),
    "range": ("Span(60.0, 5.0, 400.0)", "Span(60.0, 80.0, 400.0)", "Gains", "does not hold its default 60"),
    "empty range": ("Span(60.0, 5.0, 400.0)", "Span(60.0, 60.0, 60.0)", "Gains", "is empty"),
    "zero on a logarithm": ("Span(60.0, 0.1, 2000.0)", "Span(60.0, 0.0, 2000.0)", "Gains", "logarithmic"),
    "unit": ('"kd", "kd", "s^-1"', '"kd", "kd", ""', "Gains", "has no unit"),
    "order": ('"ki", "ki"', '"kp", "ki"', "Gains", "in this order"),
    "promise": ("sampling=", 'promises=frozenset({"wins"}), sampling=', "promises", "'wins'"),
    "silent promise": ("sampling=", 'promises=frozenset({"rejects"}), sampling=', "promises", 'promise "tracks"'),
    "word of C": ("integral: float", "double: float", "Memory", "word of C"),
    "name": ('name="pid_plain"', 'name="PID plain"', "name", "small letter"),
}  # fmt: skip


ASKED = {
    "sign": behaviour.commands_point_the_right_way,
    "absolute": behaviour.only_the_error_counts,
    "units of u": behaviour.commands_scale_with_the_channel,
    "integral off": behaviour.disturbances_are_rejected_as_promised,
    "acceleration": behaviour.references_are_flown_as_promised,
    "windup": behaviour.saturation_is_listened_to,
    "amplitude": behaviour.amplitude_counts_only_as_told,
    "silent promise": behaviour.references_are_flown_as_promised,
}


def test_what_is_asked_alone_here_is_in_the_contract() -> None:
    assert set(ASKED.values()) <= set(FLIES)


@pytest.mark.parametrize("way", BEHAVIOUR)
def test_what_a_law_does_wrong_is_told_with_the_function(way: str, tmp_path: Path) -> None:
    old, new, part, message = BEHAVIOUR[way]
    changes = [(old, new), ("SOURCE = ", 'float_nan = float("nan")\nSOURCE = ')]
    if way == "word of C":
        changes.append(("memory.integral", "memory.double"))
    file = edited(LAW, tmp_path, *changes)
    # A clause of flying is asked alone: all of them take a second.
    clause = ASKED.get(way)
    law = run_own_code(file).names["LAW"]
    all_told = told(file) if clause is None else violations_of(lambda: clause(law), law, str(file))
    matching = [violation for violation in all_told if message in violation.message]
    assert matching and matching[0].part == part, all_told
    assert matching[0].place.startswith(f"{file}")
    if part in ("start", "step", "Gains"):
        assert matching[0].place == f"{file}:{line_of(file, f'def {part}(' if part != 'Gains' else 'class Gains')}"


def test_a_state_that_hides_where_no_look_at_the_source_finds_it_shows_in_the_commands(tmp_path: Path) -> None:
    counter = "class Counter:\n    def __init__(self):\n        self.calls = 0\n\n    def next(self):\n        self.calls += 1\n"
    counter += "        return 1e-3 * self.calls\n\n\nCOUNTER = Counter()\n"
    file = edited(
        LAW, tmp_path, ("SOURCE = ", f"{counter}SOURCE = "), (ERROR, f"{ERROR}\n    error = error + COUNTER.next()")
    )
    law = run_own_code(file).names["LAW"]
    assert any("hides between calls" in violation.message for violation in behaviour.same_inputs_give_the_same(law))
    assert behaviour.same_inputs_give_the_same in FLIES


DIFFERENCED = (
    ("    integral: float\n\n\ndef", "    integral: float\n    last: float\n\n\ndef"),
    ("return Memory(held)", "return Memory(held, measured.value)"),
    (
        ERROR,
        "slope = select(channel.rate_from_observer > 0.5, (measured.value - memory.last) / h, measured.rate)\n"
        "    error, rate = setpoint.value - measured.value, setpoint.rate - slope",
    ),
    (RETURN, RETURN.replace("error)", "error, measured.value)")),
    ("from plant.laws.law import", "from plant.primitives import select\nfrom plant.laws.law import"),
)
WEIGHTED = (
    ("return Memory(held)", "return Memory(held + 0.3 * constants.kp * measured.value)"),
    ("constants.kp * error + integral", "constants.kp * (0.7 * setpoint.value - measured.value) + integral"),
)


def test_a_law_that_differences_by_itself_where_nothing_measures_the_rate_keeps_it(tmp_path: Path) -> None:
    law = run_own_code(edited(LAW, tmp_path, *DIFFERENCED)).names["LAW"]
    assert list(behaviour.commands_point_the_right_way(law)) == []
    assert list(behaviour.disturbances_are_rejected_as_promised(law)) == []


def test_what_is_told_of_a_pi_law_leads_out(tmp_path: Path) -> None:
    """PI holds no double integrator; followed, the messages end in the empty promise, and none asks for what another forbids."""
    pi = [
        ("    kd: float\n", ""),
        (" + constants.kd * rate", ""),
        (ERROR, "error = setpoint.value - measured.value"),
        (re.findall(r" +GainInfo\(\n +\"kd\".*?\n        \),\n", LAW.read_text(encoding="utf-8"), re.DOTALL)[0], ""),
    ]
    left = {"tracks", "rejects"}
    for _ in range(3):
        words = ", ".join(repr(each) for each in sorted(left))
        promised = (
            ("    sampling=", f"    promises=frozenset({{{words}}}),\n    sampling=")
            if left
            else ("    sampling=", "    promises=frozenset(),\n    sampling=")
        )
        law = run_own_code(edited(LAW, tmp_path, *pi, promised)).names["LAW"]
        clauses = (behaviour.references_are_flown_as_promised, behaviour.disturbances_are_rejected_as_promised)
        messages = [violation.message for clause in clauses for violation in clause(law)]
        assert not any("; promise " in text for text in messages)
        dropped = {each for each in left if any(f'leave "{each}" out' in text for text in messages)}
        assert bool(dropped) == bool(messages)
        left -= dropped
        if not messages:
            break
    assert left == set()


def test_a_law_that_brakes_only_by_a_rate_that_it_is_not_given_is_told_once(tmp_path: Path) -> None:
    """With the rate left out where nothing measures it, there is no derivative: two signs, two loops, one line each."""
    without = "select(channel.rate_from_observer > 0.5, 0.0, measured.rate)"
    changes = [(ERROR, ERROR.replace("measured.rate", without)), DIFFERENCED[-1]]
    law = run_own_code(edited(LAW, tmp_path, *changes)).names["LAW"]
    lines = [each.message for each in violations_of(lambda: behaviour.commands_point_the_right_way(law), law, "")]
    assert len(lines) == len(set(lines)) == 2
    assert all("does not brake a motion" in line and "from an observer" in line for line in lines)


def test_a_weighted_set_point_rests_within_rounding_and_a_share_of_a_billionth_of_it_is_told(tmp_path: Path) -> None:
    law = run_own_code(edited(LAW, tmp_path, *WEIGHTED)).names["LAW"]
    assert list(behaviour.at_rest_nothing_changes(law)) == []
    off = edited(LAW, tmp_path, *WEIGHTED, ("held + 0.3 *", "held + 0.300000001 *"), name="off.py")
    told_of = list(behaviour.at_rest_nothing_changes(run_own_code(off).names["LAW"]))
    # At both places that are not 0, with default gains and with each at the ends of its range.
    assert len(told_of) == 2 * len(list(behaviour.cases_at_ends(law)))
    assert all("it must command 0" in each.message for each in told_of)


def test_a_law_that_rests_with_default_gains_alone_is_refused() -> None:
    pid = LAWS["pid"]
    usual = pid.defaults("attitude")["kp"]

    def start(constants: Any, measured: Measured, held: float) -> Any:
        return pid.start(constants, measured, held + 0.1 * (constants.kp - usual) * measured.value)

    texts = [each.message for each in behaviour.at_rest_nothing_changes(replace(pid, start=start))]
    assert texts and all("attitude" not in text or " and kp = " in text for text in texts)
    assert list(behaviour.at_rest_nothing_changes(pid)) == []


def test_an_error_inside_a_function_is_told_with_its_line(tmp_path: Path) -> None:
    file = edited(LAW, tmp_path, (ERROR, f"{ERROR}\n    error = error * measured.speed"))
    first = told(file)[0]
    assert "no attribute 'speed'" in first.message
    assert first.place == f"{file}:{line_of(file, 'measured.speed')}"


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("x = 1\ndef (:\n", 2, "invalid syntax"),
        ("x = 1\n\ny = 1 / 0\n", 3, "ZeroDivisionError"),
        ("exit(3)\n", 1, "SystemExit"),
        ("from plant.nowhere import x\n", 1, "No module named"),
    ],
)
def test_a_file_that_cannot_be_run_is_one_line_with_its_place(
    text: str, line: int, message: str, tmp_path: Path
) -> None:
    file = tmp_path / "broken.py"
    file.write_text(text)
    with pytest.raises(InputError, match=message) as error:
        run_own_code(file)
    assert error.value.file == f"{file}:{line}"


def test_the_digest_is_that_of_the_file_and_of_what_it_imports_from_beside_it(tmp_path: Path) -> None:
    (tmp_path / "half.py").write_text("def half(a):\n    return 0.5 * a\n")
    changes = [
        ("SOURCE = ", "from half import half\nSOURCE = "),
        (ERROR, f"{ERROR}\n    error = half(error) + half(error)"),
    ]
    first = run_own_code(edited(LAW, tmp_path, *changes))
    assert first is run_own_code(edited(LAW, tmp_path, *changes, name="same_code_elsewhere.py"))
    assert violations_of_law(first.names["LAW"], str(first.file)) == []
    (tmp_path / "half.py").write_text("def half(a):\n    return a * 0.5\n")
    assert run_own_code(first.file).digest != first.digest
    with pytest.raises(ImportError):
        __import__("half")
