"""Wrong arguments of public functions are refused in a line that names what is allowed and what to do."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tuner as interface
from plant.errors import InputError, ToolError, UnknownNameError
from tests.tuner.conftest import QUICKSTART
from tuner.api.border import accepts, checked

tuner: Any = interface
MOTOR = QUICKSTART.with_name("dc_motor.toml")


class Designed:
    """A class with gains, such as a design."""

    gains = ()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: tuner.fly("gains.json", seeds=4), "fly: unknown argument 'seeds'; in Python it is flights"),
        (
            lambda: tuner.margins("gains.json", yew=4),
            "unknown argument 'yew'; did you mean 'yaw'\\? valid: certificates, .*",
        ),
        (
            lambda: tuner.fly({"kp": 1.0}),
            "fly: gains: given dict with 1.0; allowed: Gains, .*default_gains.study..replace",
        ),
        (lambda: tuner.fly(tuner.load_study(MOTOR)), "give tuner.default_gains.study."),
        (lambda: tuner.fly(None), "given None; allowed: Gains, text, a path"),
        (lambda: tuner.fly(MOTOR, flights="a"), "flights: given 'a'; allowed: int"),
        (lambda: tuner.fly(MOTOR, flights=0), "flights: given 0; allowed: 1 or more"),
        (lambda: tuner.fly(), "missing a required argument: 'gains'; arguments: gains, study, "),
        (lambda: tuner.compare("one.json"), "allowed: a list of text or a path or Results or Gains"),
        (lambda: tuner.compare(["one.json", Designed()]), "give design.gains"),
        (lambda: tuner.compare(tuner.default_gains("pid")), "give a list of them, .gains."),
        (lambda: tuner.run({"title": "x"}), "allowed: a study, text, a path; give tuner.make_study.tables."),
        (lambda: tuner.make_study("x"), "tables: given 'x'; allowed: a dict"),
        (lambda: tuner.default_gains("pid").replace(kp="a"), "replace: kp: given 'a'; allowed: float"),
        (
            lambda: tuner.default_gains("pid").replace({"roll.kp": "a"}),
            "given dict with 'a'; allowed: a dict of float, None",
        ),
        (lambda: tuner.default_gains(3), "attitude: given 3; allowed: text, a study, a path|a study, text, a path"),
    ],
)
def test_a_wrong_argument_is_refused_with_what_is_allowed(call, said):
    with pytest.raises(ToolError, match=said) as refused:
        call()
    assert "\n" not in str(refused.value)


def test_default_gains_of_a_study_are_those_of_its_file():
    given = [MOTOR, str(MOTOR), tuner.load_study(MOTOR)]
    kinds = [dict(tuner.default_gains(each)) for each in given]
    assert kinds == [dict(tuner.read_gains(MOTOR))] * 3 and kinds[0]["angle.kp"] == 10.0


@pytest.mark.parametrize(
    ("value", "hint", "is_included"),
    [
        (1, int, True),
        (np.int64(1), int, True),
        (np.float64(1), float, True),
        (1, float, True),
        (True, int, False),
        (1.0, int, False),
        ("a", str | Path, True),
        (None, int | None, True),
        ("ab", Sequence[str], False),
        (["a"], Sequence[str], True),
        ([1], Sequence[str], False),
        (np.zeros(2), Sequence[float], True),
        ({"a": 1}, Mapping[str, float], True),
        ({"a": "b"}, Mapping[str, float], False),
        (3, "Watcher", True),
    ],
)
def test_a_type_includes_what_python_says(value, hint, is_included):
    assert accepts(value, hint) == is_included


def test_a_function_of_any_keywords_takes_them():
    def keywords(**named: float) -> dict[str, float]:
        return named

    call: Any = checked(keywords)
    assert call(a=1.0) == {"a": 1.0}
    with pytest.raises(InputError, match="keywords: a: given 'b'; allowed: float"):
        call(a="b")


def test_every_function_of_the_interface_is_checked():
    functions = [getattr(tuner, name) for name in tuner.__all__ if callable(getattr(tuner, name))]
    for function in functions:
        if not isinstance(function, type):
            with pytest.raises(UnknownNameError, match="argument 'not_an_argument'"):
                function(not_an_argument=1)
