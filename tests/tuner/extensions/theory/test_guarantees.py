"""[[guarantee]] tables: what they become, where their numbers come from, and how wrong ones are refused."""

import json

import numpy as np
import pytest

from objectives.requirements import known_values
from plant.errors import InputError, UnknownNameError
from tests.tuner.study.study_text import STUDY, changed, write
from tuner import extension
from tuner.extensions.theory.theorems import THEOREMS, Setting
from tuner.extensions.theory.theorems.disturbance_rate import disturbance_rates, worst_rates
from tuner.extensions.theory.theorems.guarantee import channel_gains
from tuner.study.build import load_study
from tuner.study.requirement_kinds import choices_of

HYBRID = '[[guarantee]]\ntheorem = "ultimate_error"\naxis = "tilt"\nmax = 0.1\n'
TWISTING = changed('attitude = "hybrid"', 'attitude = "supertwisting"').replace(
    '"roll.k1" = 20.0', '"attitude.k1" = 10.0\n"attitude.k2" = 40.0'
)
BORNE = '[[guarantee]]\ntheorem = "sta_seeber_horn"\naxis = "attitude"\n'
SEVERE = '[[scenario]]\nname = "severe"\nduration = 3.0\nair = { intensity = "severe", mean_wind = false }\n'


def study(folder, lines, text=STUDY):
    return load_study(write(folder, f"{text}\n{lines}"))


def test_a_study_without_any_requires_nothing(tmp_path):
    assert study(tmp_path, "").screens == () == study(tmp_path, "").requirements


def test_a_guarantee_needs_an_extension_that_has_it(tmp_path, monkeypatch):
    monkeypatch.setattr(extension, "extensions", dict)
    with pytest.raises(InputError, match="comes with the extension theory of gainproof, which is not") as caught:
        study(tmp_path, HYBRID)
    assert caught.value.key == "guarantee[0]"
    assert choices_of("guarantee") == {}


def test_a_bound_is_worked_out_for_the_measured_rate_of_the_worst_axis(tmp_path):
    asked = study(tmp_path, HYBRID)
    (requirement,) = asked.requirements
    assert (requirement.label, requirement.unit, requirement.limit) == ("ultimate_error(tilt)", "rad", 0.1)
    assert (requirement.sense, requirement.hard) == ("max", True)
    vehicle, timing = asked.system.vehicle, asked.system.timing
    rates = disturbance_rates(asked.scenarios[0].spec, vehicle, timing, asked.seed)
    rows = np.stack([asked.default_row, 1.3 * asked.default_row])
    cascade, value = asked.system.cascade, THEOREMS["ultimate_error"].values["hybrid"]
    each = [
        value(channel_gains(cascade, axis, rows), Setting(0.004, rates[i])) for i, axis in ((3, "roll"), (4, "pitch"))
    ]
    np.testing.assert_allclose(known_values(asked.screens, rows)[:, 0], np.max(each, axis=0), rtol=1e-12)
    assert f"{rates[3]:.3g} / {rates[4]:.3g} rad/s^3" in requirement.quantity
    assert "99 % quantile of its change over 0.004 s in scenario gusts" in requirement.quantity


def test_a_rate_that_is_borne_is_held_against_that_of_each_axis(tmp_path):
    asked = study(tmp_path, BORNE + "level = 0.9\nwindow = 0.02\nhard = false\n" + SEVERE, TWISTING)
    assert [entry.label for entry in asked.requirements] == [
        f"sta_seeber_horn({axis})" for axis in ("roll", "pitch", "yaw")
    ]
    vehicle, timing = asked.system.vehicle, asked.system.timing
    rates = worst_rates(tuple(entry.spec for entry in asked.scenarios), vehicle, timing, asked.seed, 0.9, 0.02)
    assert [entry.limit for entry in asked.requirements] == [rates[axis] for axis in ("roll", "pitch", "yaw")]
    assert {entry.sense for entry in asked.requirements} == {"min"}
    assert {entry.unit for entry in asked.requirements} == {"rad/s^3"}
    assert not any(entry.hard for entry in asked.requirements)
    assert "the worst scenario" in asked.requirements[0].quantity
    # k1 = 10, k2 = 40: Seeber and Horn's condition gives 40.
    assert known_values(asked.screens, asked.default_row[None]).tolist() == [[40.0, 40.0, 40.0]]


def test_numbers_may_be_given_instead(tmp_path):
    (own,) = study(tmp_path, BORNE + "min = 12.5\n", TWISTING).requirements
    assert (own.label, own.limit) == ("sta_seeber_horn(attitude)", 12.5)
    given = study(tmp_path, HYBRID + "disturbance_rate = 8\n")
    gains = channel_gains(given.system.cascade, "roll", given.default_row[None])
    expected = THEOREMS["ultimate_error"].values["hybrid"](gains, Setting(0.004, 8.0))
    assert known_values(given.screens, given.default_row[None])[0, 0] == pytest.approx(float(expected[0]), rel=1e-14)
    assert "8 rad/s^3: as given" in given.requirements[0].quantity
    each = study(tmp_path, BORNE + "disturbance_rate = 8\n", TWISTING).requirements
    assert [entry.limit for entry in each] == [8.0] * 3


def test_one_scenario_may_be_chosen(tmp_path):
    asked = study(tmp_path, HYBRID + 'scenario = "severe"\n' + SEVERE)
    assert asked.requirements[0].label == "ultimate_error(tilt)@severe"
    alone = study(tmp_path, HYBRID + SEVERE)
    # The severe one is the worst of the two anyway.
    row = asked.default_row[None]
    assert np.array_equal(known_values(asked.screens, row), known_values(alone.screens, row))


def test_resolved_and_digest_know_them(tmp_path):
    plain, asked, harder = study(tmp_path, ""), study(tmp_path, HYBRID), study(tmp_path, HYBRID.replace("0.1", "0.2"))
    assert len({plain.digest(), asked.digest(), harder.digest()}) == 3
    resolved = json.loads(json.dumps(asked.resolved(), allow_nan=False))
    assert resolved["guarantee"][0] | {"most": 0.1, "level": 0.99, "hard": True} == resolved["guarantee"][0]
    assert resolved["requirements"][0]["label"] == "ultimate_error(tilt)"


# Text after the study, key, what the message must say.
BAD = [
    (HYBRID.replace("ultimate_error", "ultimate_eror"), "guarantee[0].theorem", "did you mean 'ultimate_error'?"),
    (HYBRID.replace("tilt", "tild"), "guarantee[0].axis", "did you mean 'tilt'?"),
    (HYBRID.replace("max =", "maxx ="), "guarantee[0].maxx", "did you mean 'max'?"),
    (HYBRID.replace("max = 0.1", ""), "guarantee[0].max", "write max = ... in rad or m"),
    (HYBRID.replace("max = 0.1", "min = 0.1"), "guarantee[0].min", "smaller values are better; give max instead"),
    (HYBRID.replace("max = 0.1", "max = inf"), "guarantee[0].max", "a finite number"),
    (HYBRID + HYBRID, "guarantee[1]", "'ultimate_error(tilt)' is required by guarantee[0] too"),
    (HYBRID + 'scenario = "gust"\n', "guarantee[0].scenario", "did you mean 'gusts'?"),
    (HYBRID + "level = 1.0\n", "guarantee[0].level", "between 0 and 1"),
    (HYBRID + "window = 0.001\n", "guarantee[0].window", "the control period of 0.004 s to below 2 s"),
    (HYBRID + "window = 2.0\n", "guarantee[0].window", "the control period of 0.004 s to below 2 s"),
    (HYBRID + "disturbance_rate = -1.0\n", "guarantee[0].disturbance_rate", "finite and not negative"),
    (HYBRID + 'disturbance_rate = "mesured"\n', "guarantee[0].disturbance_rate", 'write "measured" or a number'),
    (HYBRID + "hard = 1\n", "guarantee[0].hard", "true or false"),
    ('[[guarantee]]\ntheorem = "ultimate_error"\n', "guarantee[0].axis", 'write axis = "attitude"'),
    ('[[guarantee]]\naxis = "tilt"\n', "guarantee[0].theorem", 'write theorem = "ultimate_error"'),
    (HYBRID.replace("tilt", "position"), "guarantee[0].theorem",
     "says nothing about 'ladrc', the law of x, but about hybrid; theorems for it: observer_value, observer_rate, observer"),
    (BORNE, "guarantee[0].theorem", "says nothing about 'hybrid', the law of roll, but about supertwisting"),
    (HYBRID.replace("[[guarantee]]", "[guarantee]"), "guarantee", "double brackets: [[guarantee]]"),
]  # fmt: skip


@pytest.mark.parametrize(("lines", "key", "says"), BAD, ids=[f"{row[1]}: {row[2]:.30}" for row in BAD])
def test_a_bad_guarantee_is_refused(lines, key, says, tmp_path):
    path = write(tmp_path, f"{STUDY}\n{lines}")
    with pytest.raises(InputError) as caught:
        load_study(path)
    assert (caught.value.file, caught.value.key) == (str(path), key)
    assert says in caught.value.message
    if "did you mean" in says:
        assert isinstance(caught.value, UnknownNameError)


def test_a_rate_that_is_borne_has_no_upper_limit_and_doubles_are_found_axis_by_axis(tmp_path):
    with pytest.raises(InputError, match="larger values are better; give min instead"):
        study(tmp_path, BORNE + "max = 3.0\n", TWISTING)
    with pytest.raises(InputError, match=r"guarantee\[1\]: 'sta_seeber_horn\(yaw\)' is required by guarantee\[0\]"):
        study(tmp_path, BORNE + BORNE.replace("attitude", "yaw"), TWISTING)


def test_a_law_on_estimated_rates_is_told_which_option_to_change(tmp_path):
    text = changed('attitude = "hybrid"', 'attitude = "hybrid"\nattitude_rate = "observer"')
    with pytest.raises(
        InputError, match='with measured rates only; set attitude_rate = "measured"; theorems for it: observer'
    ):
        study(tmp_path, HYBRID, text)
    study(tmp_path, HYBRID.replace("ultimate_error", "observer_value"), text)


def test_a_law_that_theory_has_nothing_on_says_none(tmp_path):
    with pytest.raises(InputError, match="theorems for it: none"):
        study(
            tmp_path,
            BORNE.replace("attitude", "x"),
            changed('attitude = "hybrid"', 'attitude = "hybrid"\nposition = "pid"'),
        )
