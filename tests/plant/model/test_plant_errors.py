"""Plants that cannot fly are told in one line: the user's file, its line, what was given and what is allowed."""

from math import inf, nan

import pytest

from plant.errors import InputError, ToolError
from plant.law_registry import LAWS
from plant.model.plan import Actuator, plan_loop
from tests.plant.model.plants import FILES, cascade, pid, plant_of, read

MOTOR = FILES["dc_motor"].read_text(encoding="utf-8")
CURRENT = "    current = (input.voltage - p.constant * state.speed) / p.resistance\n"
RATE = "    return State(state.speed, torque / p.inertia)\n"
SEEN = "    return Output(state.angle)\n"

# What is wrong: the lines that stand in the file, what takes their place, the line that is told, words of the message.
WRONG = {
    "an if": (CURRENT, CURRENT + "    if current > 3.0:\n        current = 3.0\n", "if current", "select"),
    "an if in an expression": (CURRENT, CURRENT + "    current = 3.0 if current > 3.0 else current\n", "3.0 if", "select"),
    "an and": (CURRENT, CURRENT + "    on = current > 3.0 and current < 4.0\n", "on =", "both"),
    "a not": (CURRENT, CURRENT + "    off = not current > 3.0\n", "off =", "opposite"),
    "a chained comparison": (CURRENT, CURRENT + "    on = 3.0 < current < 4.0\n", "on =", "both"),
    "a comprehension": (CURRENT, CURRENT + "    current = sum([current for _ in range(2)])\n", "def derivative", "builtin 'sum'"),
    "a match": (CURRENT, CURRENT + "    match current:\n        case 0.0:\n            pass\n", "match", "select"),
    "an assertion": (CURRENT, CURRENT + "    assert current < 3.0\n", "assert", "cannot fail"),
    "a loop": (CURRENT, CURRENT + "    for _ in range(3):\n        current = 0.5 * current\n", "for _", "loop"),
    "a builtin": (CURRENT, CURRENT + "    current = max(current, 0.0)\n", "def derivative", "maximum"),
    "a name of nothing": (CURRENT, CURRENT + "    current = sine(current)\n", "def derivative", "uses 'sine', which the file does not define; take from plant.primitives: absolute, asin"),
    "print": (CURRENT, CURRENT + "    print(current)\n", "def derivative", "builtin 'print'"),
    "NumPy": ("from typing", "import numpy as np\nfrom typing", "def derivative", "plant.primitives"),
    "a NumPy function": ("from typing", "from numpy import sin\nfrom typing", "def derivative", "plant.primitives"),
    "math": ("from typing", "from math import sinh\nfrom typing", "def derivative", "plant.primitives"),
    "a hidden list": ("class State", "LAST = [0.0]\n\n\nclass State", "LAST[0]", "State"),
    "a hidden array": ("class State", "from numpy import zeros\nLAST = zeros(1)\n\n\nclass State", "LAST[0]", "State"),
    "a read list": ("class State", "LAST = [0.0]\n\n\nclass State", "def derivative", "State"),
    "a read object": ("class State", "class K:\n    value = 1.0\n\n\nLAST = K()\n\n\nclass State", "def derivative", "State"),
    "a global": (CURRENT, "    global speed\n" + CURRENT, "global speed", "State"),
    "a default": ("disturbance, p):\n    current", "disturbance, p, last=[0.0]):\n    current", "def derivative", "arguments"),
    "three arguments": ("input, disturbance, p):\n    current", "input, p):\n    current", "def derivative", "4"),
    "no unit": ('speed: Annotated[float, "rad/s"]', "speed: float", "speed: float", "Annotated"),
    "an integer": ('speed: Annotated[float, "rad/s"]', 'speed: Annotated[int, "rad/s"]', "speed: Annotated", "Annotated"),
    "no nominal value": (" = 3.2284e-6", "", "inertia: Annotated", "nominal"),
    "NaN at start": (RATE, RATE.replace("torque /", "(1e309 - 1e309) + torque /"), "def derivative", "finite"),
    "NaN of a parameter": ("= 4.0", '= float("nan")', "def derivative", "finite"),
    "a division by nothing": ("= 4.0", "= 0.0", "current = (", "ZeroDivisionError"),
    "an overflow": (SEEN, SEEN.replace("state.angle", "1e309"), "def output", "finite"),
    "the wrong record": (RATE, RATE.replace("State(", "Output("), "return Output(state.speed", ""),
    "another record": (SEEN, SEEN.replace("Output(state.angle)", "State(state.angle, 0.0)"), "def output", "Output"),
    "a tuple": (SEEN, SEEN.replace("Output(state.angle)", "(state.angle,)"), "def output", "Output"),
    "nothing": (SEEN, "    Output(state.angle)\n", "def output", "Output"),
    "an unknown name": (CURRENT, CURRENT.replace("p.constant", "p.constnt"), "current = (", "constnt"),
    "motion at rest": (RATE, RATE.replace("torque /", "(torque + 1.0) /"), "def derivative", "rest"),
    "rest gives one record": (SEEN, SEEN + "\n\ndef rest(p):\n    return State(0.0, 0.0)\n", "def rest", "State, Input"),
    "rest gives them swapped": (
        SEEN, SEEN + "\n\ndef rest(p):\n    return Input(0.0), State(0.0, 0.0)\n", "def rest", "State, Input",
    ),
    "rest gives no number": (
        SEEN, SEEN + '\n\ndef rest(p):\n    return State(1e309, 0.0), Input(0.0)\n', "def rest", "finite",
    ),
    "no output": ("def output", "def result", "", "given the functions derivative, result; write def output(state, input, "),
    "no state": ("class State", "class Stat", "", "State"),
    "a helper with an if": (
        CURRENT, "    current = flow(input, state, p)\n", "    if state", "select",
    ),
}  # fmt: skip
USES = {
    "NumPy": "np.sin",
    "a NumPy function": "sin",
    "math": "sinh",
    "a hidden list": "LAST[0]",
    "a hidden array": "LAST[0]",
    "a read list": "LAST[0]",
    "a read object": "LAST.value",
}
HELPER = "\n\ndef flow(input, state, p):\n    if state.speed > 0.0:\n        return 0.0\n    return input.voltage / p.resistance\n"


def broken(name):
    old, new, _, _ = WRONG[name]
    assert MOTOR.count(old) == 1
    text = MOTOR.replace(old, new)
    if name in ("a hidden list", "a hidden array"):
        return text.replace(CURRENT, CURRENT + "    LAST[0] = current\n")
    if name in USES:
        used = f"{USES[name]}(state.angle)" if name in ("NumPy", "a NumPy function", "math") else USES[name]
        return text.replace(CURRENT, CURRENT + f"    current = current + {used}\n")
    return text + HELPER if name == "a helper with an if" else text


@pytest.mark.parametrize("name", WRONG)
def test_a_plant_that_cannot_fly_is_told_with_file_and_line(name, tmp_path):
    _, _, line, word = WRONG[name]
    file = tmp_path / "broken.py"
    file.write_text(broken(name), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read(file)
    said = str(caught.value)
    assert "\n" not in said and word in said, said
    place = str(file)
    if line:
        number = next(i for i, each in enumerate(broken(name).splitlines(), 1) if line in each)
        place += f":{number}"
    assert said.startswith(place), said


def motor_plan(*channels, actuators=()):
    return plan_loop(plant_of("dc_motor"), channels, actuators)


PID = LAWS["pid"]
PLANS = {
    "an algebraic loop": (lambda: motor_plan(pid("a", "angle", "b"), pid("b", "angle", "a")), "a -> b"),
    "a ring behind a good channel": (
        lambda: motor_plan(pid("good", "angle", "voltage"), pid("a", "angle", "b"), pid("b", "angle", "a")), "algebraic loop",
    ),
    "a channel that commands itself": (lambda: motor_plan(pid("a", "angle", "a")), "voltage"),
    "two that command one": (
        lambda: motor_plan(pid("a", "angle", "c"), pid("b", "angle", "c"), pid("c", "angle", "voltage")), "two channels",
    ),
    "rates that do not divide": (
        lambda: motor_plan(pid("a", "angle", "b", every=3), pid("b", "angle", "voltage", every=2)), "every",
    ),
    "an inner channel slower than its outer one": (
        lambda: motor_plan(pid("a", "angle", "b"), pid("b", "angle", "voltage", every=2)), "every",
    ),
    "an unknown output": (lambda: motor_plan(pid("a", "angel", "voltage")), "angle"),
    "an unknown input": (lambda: motor_plan(pid("a", "angle", "volts")), "voltage"),
    "an unknown actuator": (lambda: motor_plan(pid("a", "angle", "voltage"), actuators=[Actuator("valve")]), "voltage"),
    "an actuator twice": (
        lambda: motor_plan(pid("a", "angle", "voltage"), actuators=[Actuator("voltage"), Actuator("voltage", -1.0, 1.0)]), "twice",
    ),
    "no channel": (lambda: motor_plan(), "at least one"),
    "a name twice": (lambda: motor_plan(pid("a", "angle", "voltage"), pid("a", "angle", "voltage")), "twice"),
    "a name that is none": (lambda: motor_plan(pid("a b", "angle", "voltage")), "letters"),
    "a name of the language": (lambda: motor_plan(pid("lambda", "angle", "voltage")), "letters"),
    "a name that records have": (lambda: motor_plan(pid("time", "angle", "voltage")), "time"),
    "no gain": (lambda: pid("a", "angle", "voltage", b0=0.0), "not 0"),
    "NaN as gain": (lambda: pid("a", "angle", "voltage", b0=nan), "finite"),
    "no period": (lambda: pid("a", "angle", "voltage", every=0), "1 or more"),
    "NaN as limit": (lambda: pid("a", "angle", "voltage", limit=nan), "positive"),
    "limits the wrong way": (lambda: Actuator("voltage", 1.0, -1.0), "below"),
    "NaN limits": (lambda: Actuator("voltage", nan, 1.0), "below"),
    "a negative delay": (lambda: Actuator("voltage", delay=-0.001), "0 s or more"),
    "an infinite lag": (lambda: Actuator("voltage", lag=inf), "0 s or more"),
    "a delay that does not divide": (lambda: Actuator("voltage", delay=0.0015).periods(0.001), "whole number"),
    "a delay too long": (lambda: Actuator("voltage", delay=1.2).periods(0.001), "up to 1024, a control period from 0.00117 s"),
}  # fmt: skip


@pytest.mark.parametrize("name", PLANS)
def test_a_loop_that_cannot_close_is_told_in_a_line(name):
    make, word = PLANS[name]
    with pytest.raises(ToolError) as caught:
        make()
    assert "\n" not in str(caught.value) and word in str(caught.value)


def test_what_is_good_is_read():
    """The table above would prove nothing if the file that it breaks were refused itself."""
    assert plant_of("dc_motor").unit("Parameters.resistance") == "Ohm"
    assert cascade().plan.names == ("angle", "speed")
