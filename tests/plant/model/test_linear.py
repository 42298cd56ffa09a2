"""Linear plants by their numbers against python-control: steps, flights, margins; and what is refused, with its key."""

import re
from typing import Any, cast

import control
import numpy as np
import pytest
from scipy import signal

from objectives.margins.plant_margins import PlantMargins
from objectives.plant_system import PlantSystem
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.laws.channel import Applied, Measured, Setpoint
from plant.laws.channel import Channel as Known
from plant.loop import Timing
from plant.model.closing import resting, stepping
from plant.model.linear import SignalNames, linear_plant, numbers_of
from plant.model.plan import Actuator, Channel, plan_loop
from plant.model.plant_model import PlantModel
from plant.model.scenario import PlantScenario
from plant.model.signals import Step
from plant.records import pack
from tests.objectives.margins.plant_parts import law_blocks
from tests.objectives.margins.test_plant_margin_control import check
from tests.plant.model.plants import stepped

S: Any = control.tf("s")
H, WAIT = 0.02, 3
PLANTS: dict[str, Any] = {
    "first order": control.tf([3.0], [0.5, 1.0]),
    "integrators": control.tf([2.0], [1.0, 0.0, 0.0]),
    "resonance and zero": control.tf([4.0, 10.0], [1.0, 0.3, 9.0]),
    "unstable": control.tf([1.0, 3.0], [1.0, 1.0, -0.5]),
    "output at once": control.tf([0.5, 2.0, 3.0], [1.0, 2.5, 4.0]),
    "far apart": 2e4 / ((S + 40.0) * (S + 20.0) * (S + 0.01) * (S + 5.0)),
    "tiny coefficients": control.tf([1e-9], [1e-9, 3e-9, 2e-9]),
    "three states": control.ss(
        [[-1.0, 2.0, 0.0], [0.0, -3.0, 1.0], [0.5, 0.0, -2.0]], [[0.0], [1.0], [4.0]], [[1.0, 0.5, 0.0]], [[0.0]]
    ),
    "state space, output at once": control.ss([[0.0, 1.0], [-4.0, -0.8]], [[0.0], [1.0]], [[1.0, 0.0]], [[0.25]]),
}
GAINS = {
    "integrators": [2.0, 0.5, 2.0, 0.05],
    "unstable": [3.0, 1.0, 0.5, 0.05],
    "output at once": [0.3, 0.4, 0.01, 0.1],
}
each = pytest.mark.parametrize("name", PLANTS)


def plant_of(name, names=None):
    return linear_plant("linear", numbers_of(PLANTS[name]), *([names] if names else []))


def system_of(name, delay=WAIT * H, steps=40):
    plant = plant_of(name)
    channel = Channel("loop", LAWS["pid"], "y", "u", limit=1e6)
    return PlantSystem(
        plant, plan_loop(plant, [channel], [Actuator("u", delay=delay)]), plant.parameters, Timing(H, H / steps)
    )


def gains_of(name):
    return np.array(GAINS.get(name, [0.3, 0.4, 0.02, 0.05]))


@each
def test_steps_in_open_loop_are_those_of_python_control(name):
    system, count, fine = system_of(name), 150, 32
    advance = stepping(cast(PlantModel, system.plant), system.plan)
    constants, body = resting(system.loop, system.parameters)
    quiet, command = pack(system.plant.Disturbance, [0.0, 0.0]), system.plant.Input(1.0)
    seen = []
    for _ in range(count):
        for _ in range(fine):
            body = advance(body, command, quiet, constants, H / fine)
        seen.append(body.shown.y)
    wanted = control.step_response(control.ss(PLANTS[name]), np.arange(count + 1) * H).outputs
    np.testing.assert_allclose(seen, wanted[1:], rtol=1e-6, atol=1e-6 * np.abs(wanted).max())
    assert np.ptp(wanted) > 0.0


@each
def test_flights_behind_dead_time_are_those_of_the_sampled_plant(name):
    system, gains, count = system_of(name), gains_of(name), 200
    spec = PlantScenario("step", count * H, {"loop": Step(1.0, 0.0)})
    bodies, _ = stepped(system, gains, system.sample(spec, 1, "search", [0]))
    law = LAWS["pid"]
    constants = law.prepare(law.Gains(*gains), H)
    sampled: Any = control.c2d(control.ss(PLANTS[name]), H)
    x, y, wanted, queue = np.zeros(sampled.nstates), 0.0, [], [0.0] * WAIT
    memory = law.start(constants, Measured(0.0, 0.0), 0.0)
    for _ in range(count):
        wanted.append(y)
        command, memory = law.step(
            memory, constants, Known(1.0, 1.0), Setpoint(1.0, 0.0, 0.0), Measured(y, 0.0), Applied(queue[0], 0.0), H
        )
        queue.append(command)
        force = queue.pop(0)
        x = sampled.A @ x + sampled.B[:, 0] * force
        y = float((sampled.C @ x)[0] + sampled.D[0, 0] * force)
    shown = bodies[:, -1]
    np.testing.assert_allclose(shown, wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max())
    assert np.abs(wanted).max() > 1e-3


@each
def test_margins_are_those_of_python_control(name):
    system, gains = system_of(name), gains_of(name)
    channel = system.plan.channels[0]
    plant: Any = control.ss(PLANTS[name])
    law, sampled = law_blocks(channel, gains, H), control.c2d(plant, H)

    def loop(z):
        # What the output shows at once it shows of the command of the period before.
        moved = sampled(z) - plant.D[0, 0] * (1.0 - 1.0 / z)
        return -(z ** -float(WAIT)) * law["seen"](z) * moved / (1.0 - z ** -(WAIT + 1.0) * law["effect"](z))

    model = PlantMargins(system, 0.9 * gains, 1.1 * gains)
    check(loop, model, model.evaluate(gains[None]), gains, "loop")


def test_one_plant_in_every_form_is_one_plant():
    above, below = [4.0, 10.0], [1.0, 0.3, 9.0]
    forms = (
        control.tf(above, below),
        control.ss(control.tf(above, below)),
        signal.TransferFunction(above, below),
        signal.lti(above, below),
        signal.StateSpace(*signal.tf2ss(above, below)),
        signal.ZerosPolesGain(*signal.tf2zpk(above, below)),
    )
    same: Any = forms[0]
    responses = [same(1j * w) for w in (0.1, 3.0, 30.0)]
    for form in forms:
        plant = linear_plant("form", numbers_of(form))
        p, none = plant.parameters, plant.Disturbance(0.0, 0.0)

        def column(function, at, count=2, plant=plant, p=p, none=none):
            state, force = plant.State(*at[:count]), plant.Input(at[count])
            return np.array(function(state, force, none, p))

        a, c = ([column(f, unit) for unit in np.eye(3)] for f in (plant.derivative, plant.output))
        whole, seen = np.array(a).T, np.array(c).T
        model = control.ss(whole[:, :2], whole[:, 2:], seen[:, :2], seen[:, 2:])
        np.testing.assert_allclose([model(1j * w) for w in (0.1, 3.0, 30.0)], responses, rtol=1e-9)


def test_names_units_and_parameters():
    names = SignalNames(
        ["voltage"], ["angle"], ["angle_", "speed"], {"voltage": "V", "angle": "rad", "speed": "rad/s", "angle_": "rad"}
    )
    plant = plant_of("resonance and zero", names)
    assert plant.parameters._asdict() == {"b0": 10.0, "b1": 4.0, "a0": 9.0, "a1": 0.3, "a2": 1.0}
    assert [plant.unit(f"Parameters.{key}") for key in ("b0", "b1", "a0", "a1", "a2")] == [
        "rad/V",
        "s rad/V",
        "1",
        "s",
        "s2",
    ]
    assert (
        plant.Disturbance._fields == ("voltage_load", "angle_shift") and plant.unit("Disturbance.voltage_load") == "V"
    )
    space = linear_plant(
        "s", {"state_space": {"A": [[0.0, 1.0], [0.0, -2.0]], "B": [[0.0], [5.0]], "C": [[1.0, 0.0]]}}, names
    )
    units = {key: space.unit(f"Parameters.{key}") for key in space.parameters._fields}
    assert units == {"a_1_2": "1", "a_2_2": "1/s", "b_2_1": "rad/s2/V", "c_1_1": "1"}
    nameless = plant_of("three states")
    assert (nameless.Input._fields, nameless.Output._fields) == (("u",), ("y",))


def numbers(**table):
    return {"state_space" if "A" in table else "transfer_function": table}


REFUSED = {
    "improper": (
        numbers(numerator=[1.0, 0.0, 1.0], denominator=[1.0, 1.0]),
        "transfer_function.numerator: its degree 2 is above 1",
    ),
    "no coefficient": (numbers(numerator=[], denominator=[1.0, 1.0]), "transfer_function.numerator: given []"),
    "leading zero": (
        numbers(numerator=[1.0], denominator=[0.0, 1.0]),
        "transfer_function.denominator: given [0.0, 1.0]; the first",
    ),
    "no state": (
        numbers(numerator=[2.0], denominator=[1.0]),
        "transfer_function: this plant has 0 states; allowed: 1 to 32",
    ),
    "too many states": (
        numbers(numerator=[2.0], denominator=[1.0] * 34),
        "transfer_function: this plant has 33 states",
    ),
    "out of range": (
        numbers(numerator=[1.0], denominator=[1.0, 0.0, 0.0, 1e200]),
        "transfer_function.denominator: its coefficients",
    ),
    "A not square": (numbers(A=[[1.0, 0.0]], B=[[1.0]], C=[[1.0]]), "state_space.A: must have 1 rows of 1 numbers"),
    "ragged B": (
        numbers(A=[[1.0, 0.0], [0.0, 1.0]], B=[[1.0], [1.0, 2.0]], C=[[1.0, 0.0]]),
        "state_space.B: must have 2 rows of 1",
    ),
    "no output": (numbers(A=[[1.0]], B=[[1.0]], C=[]), "state_space.C: must have 0 rows of 1 numbers"),
    "wrong D": (
        numbers(A=[[1.0]], B=[[1.0]], C=[[1.0]], D=[[1.0, 2.0]]),
        "state_space.D: must have 1 rows of 1 numbers",
    ),
    "nothing moves": (numbers(A=[[1.0]], B=[[0.0]], C=[[1.0]]), "state_space.B: all numbers are 0"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_numbers_of_no_plant_are_refused(case):
    given, message = REFUSED[case]
    with pytest.raises(InputError, match=re.escape(message)):
        linear_plant("linear", given)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (SignalNames(inputs=["a", "b"]), "inputs: given 2 names; this plant has 1 inputs"),
        (SignalNames(states=["a", "a"]), "states[1]: given 'a' twice"),
        (SignalNames(outputs=["class"]), "outputs[0]: given 'class'; allowed: letters"),
        (SignalNames(units={"v": "V"}), "units.v: unknown signal 'v'"),
    ],
)
def test_names_that_do_not_fit_are_refused(names, message):
    with pytest.raises(InputError, match=re.escape(message)):
        plant_of("resonance and zero", names)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (control.tf([1.0], [1.0, 1.0], 0.1), "discrete in time"),
        (signal.dlti([1.0], [1.0, 0.5]), "discrete in time"),
        (control.tf([[[1.0], [2.0]]], [[[1.0, 1.0], [1.0, 3.0]]]), "one input and one output"),
        (3.0, "given float; give the names of a plant"),
    ],
)
def test_systems_that_are_no_plant_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        numbers_of(given)
