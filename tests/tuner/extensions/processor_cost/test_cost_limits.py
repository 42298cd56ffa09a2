"""Cost in studies, contests, reports and gains.json: the same number everywhere, and a limit on it."""

import json
import re
from typing import Any

import jsonschema
import numpy as np
import pytest

from plant.errors import InputError
from tests.tuner.extensions.contests.experiments.contest_text import CONTEST, changed, write
from tests.tuner.study.loading import load_contest
from tuner import extension
from tuner.experiments.compare.cost import step_cost
from tuner.experiments.compare.words import cost_words
from tuner.extensions.processor_cost.cost import cost_text, gains_rows, tabled
from tuner.extensions.processor_cost.requirement import QUANTITIES
from tuner.gains.schema import COST
from tuner.study import step_costs
from tuner.study.build import load_study

STUDY = CONTEST[: CONTEST.index("[[contender]]")].replace("# A second", "# A flight of a second")
HYBRID = tabled("ladrc", "hybrid")


def study(tmp_path, text):
    return load_study(write(tmp_path, STUDY + text, "study.toml"))


def limit(quantity, most, hard=True):
    return f'\n[[cost]]\nquantity = "{quantity}"\nmax = {most}\nhard = {str(hard).lower()}\n'


@pytest.mark.parametrize(
    ("quantity", "value", "unit"),
    [
        ("instructions", "instructions_step", "1"),
        ("text", "text_bytes", "byte"),
        ("state", "state_bytes", "byte"),
        ("stack", "stack_bytes", "byte"),
    ],
)
def test_a_limit_is_a_requirement_that_all_gains_keep_or_break_alike(quantity, value, unit, tmp_path):
    asked = study(tmp_path, limit(quantity, 10000.0))
    (screen,), (requirement,) = asked.screens, asked.requirements
    known = getattr(HYBRID, value)
    assert np.array_equal(screen.analyse(np.zeros((3, len(asked.space.base)))), np.full((3, 1), float(known)))
    assert (requirement.label, requirement.unit, requirement.sense, requirement.hard) == (
        f"cost({quantity})",
        unit,
        "max",
        True,
    )
    assert bool(requirement.is_satisfied(np.array([known]))[0])
    # No gains keep a limit below what the laws take: refused where it is hard, told where it is soft.
    below = 0.99 * known
    with pytest.raises(InputError, match="no candidate can keep this: raise it") as caught:
        study(tmp_path, limit(quantity, below))
    assert caught.value.key == "cost[0].max"
    (soft,) = study(tmp_path, limit(quantity, below, hard=False)).requirements
    assert not soft.is_satisfied(np.array([known]))[0]


def test_instructions_a_second_depend_on_the_period(tmp_path):
    text = STUDY.replace('attitude = "hybrid"\n', 'attitude = "hybrid"\ncontrol_period = 0.002\n', 1)
    slow, fast = (
        load_study(write(tmp_path, base + limit("instructions_per_second", 1e6, hard=False), name))
        for base, name in ((STUDY, "slow.toml"), (text, "fast.toml"))
    )
    rates = [one.screens[0].analyse(np.zeros((1, 1)))[0, 0] for one in (slow, fast)]
    assert HYBRID is not None and rates == pytest.approx(
        [250.0 * HYBRID.instructions_step, 500.0 * HYBRID.instructions_step]
    )
    assert slow.requirements[0].unit == "1/s" and not slow.requirements[0].hard


def test_a_limit_needs_the_extension_that_counts_and_what_it_lacks_stays_empty(tmp_path, monkeypatch):
    plain = study(tmp_path, "")
    row = plain.default_row
    document: Any = plain.gains_document(row, {})
    assert [entry["target"] for entry in document["cost"]] == ["Cortex-M4F"]
    monkeypatch.setattr(extension, "extensions", dict)
    with pytest.raises(
        InputError, match="comes with the extension processor_cost of gainproof, which is not"
    ) as caught:
        study(tmp_path, limit("text", 1e5))
    assert caught.value.key == "cost[0]"
    assert "cost" not in plain.gains_document(row, {})
    assert step_cost(plain.system).processor is None and step_costs.cost_text("ladrc", "hybrid", 0.004) == ""


def test_a_study_without_a_limit_on_cost_keeps_its_digest(tmp_path):
    plain, limited = study(tmp_path, ""), study(tmp_path, limit("text", 1e5))
    assert "cost" not in plain.comparable() and plain.digest() != limited.digest()


@pytest.mark.parametrize(
    ("text", "message", "key"),
    [
        (limit("instruction", 1.0), "did you mean 'instructions'", "cost[0].quantity"),
        (limit("text", 0.0), "given 0; a limit must be finite and above 0", "cost[0].max"),
        (limit("text", 9e3) + limit("text", 8e3), r"'cost\(text\)' occurs twice", "cost[1]"),
    ],
)
def test_what_is_wrong_is_named(text, message, key, tmp_path):
    with pytest.raises(InputError, match=message) as caught:
        study(tmp_path, text)
    assert caught.value.key == key


def test_instructions_are_no_metric_of_a_flight(tmp_path):
    with pytest.raises(InputError, match="instructions"):
        load_study(write(tmp_path, changed('metric = "travel"', 'metric = "instructions"', STUDY), "study.toml"))


def test_contenders_are_told_with_their_instructions(tmp_path):
    contest = load_contest(write(tmp_path))
    costs = [step_cost(contender.study.system) for contender in contest.contenders]
    rows = [cost.processor for cost in costs]
    for row, laws in zip(rows, (("pid", "pid"), ("ladrc", "hybrid"), ("ladrc", "ladrc")), strict=True):
        known = tabled(*laws)
        assert row is not None and known is not None
        assert row.instructions_step == known.instructions_step and row.text_bytes == known.text_bytes
        assert row.instructions_per_second == pytest.approx(250.0 * known.instructions_step)
        json.dumps(row.content(), allow_nan=False)

    class Found:
        names = [contender.name for contender in contest.contenders]

    found = Found()
    found.costs = costs  # pyright: ignore[reportAttributeAccessIssue]
    _, counted = cost_words(found)  # pyright: ignore[reportArgumentType]
    assert counted.startswith("Instructions of the whole control step on a Cortex-M4F, mean in flight, counted: ")
    assert HYBRID is not None and f"{HYBRID.instructions_step:.0f} with The hybrid, v1.0" in counted


def test_report_line_and_gains_file_say_the_same_in_their_units():
    assert HYBRID is not None
    text = cost_text("ladrc", "hybrid", 0.004)
    assert text is not None and text.startswith(f"{HYBRID.instructions_step:.0f} instructions on a Cortex-M4F, ")
    (rate,) = re.findall(r", ([\d.]+) million a second", text)
    assert float(rate) == pytest.approx(250e-6 * HYBRID.instructions_step, rel=5e-3)
    assert cost_text("ladrc", "of tomorrow", 0.004) is None
    (row,) = gains_rows(HYBRID)
    jsonschema.validate(row, COST)
    assert row["instructions"]["value"] == HYBRID.instructions_step and gains_rows(None) == []


def test_every_quantity_is_told_with_its_unit():
    assert set(QUANTITIES) == {"instructions", "instructions_per_second", "text", "state", "stack"}
    assert all(quantity.unit and quantity.about for quantity in QUANTITIES.values())
