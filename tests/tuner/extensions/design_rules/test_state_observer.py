"""An observer between sensors and channels against python-control: gains, poles, margins, flights and C99."""

import ctypes
import json
from typing import Any

import control
import numpy as np
import pytest
from scipy.optimize import brentq

import tuner
from objectives.margins.plant_margins import PlantMargins
from objectives.margins.plant_period import PlantPeriod
from plant.errors import InputError
from plant.model.scenario import PlantScenario, SensorNoise
from plant.model.signals import Step
from tests.plant.model.plants import stepped
from tests.tuner.exchange.c99.test_plant_c99 import STRICT, assert_same_bits, compiled, plant_files, written
from tests.tuner.extensions.design_rules import test_state_feedback as arm
from tests.tuner.extensions.textbook_laws.loops import row_of
from tuner.extensions.design_rules.state_feedback import SampledPlant, lqr, with_gains
from tuner.study.plant_study import PlantStudy

H, INPUTS, STATES = arm.H, arm.INPUTS, arm.STATES
MEASURED = ["shoulder", "elbow"]
NOISE = {"noise": {"shoulder": 1e-3, "elbow": 2e-3}, "input_noise": {"first": 0.5, "second": 0.3}}
C = np.eye(4)[:2]


def arm_study(observer, **options):
    """The arm of the tests of state feedback, whose rates no sensor measures."""
    made = arm.study(**options)
    tables = made.table.model_dump(by_alias=False, exclude_unset=True)
    changed = tuner.make_study({**tables, "observer": {"measured": MEASURED, **observer}})
    assert isinstance(changed, PlantStudy)
    return changed


def matrices(system):
    """A, B and M of an observer, and its record."""
    observer = system.plan.observer
    assert observer is not None
    n, m = len(observer.outputs), len(observer.inputs)
    parts = np.split(np.array(observer.numbers[n + m :]), [n * n, n * n + n * m])
    return *(part.reshape(n, -1) for part in parts), observer


def test_a_kalman_filter_is_that_of_python_control():
    a, b, m, observer = matrices(arm_study(NOISE).system)
    assert observer.outputs == STATES
    q, r = np.diag([0.5**2, 0.3**2]), np.diag([1e-3**2, 2e-3**2])
    predictor, _, _ = control.dlqe(*arm.sampled(), C, q, r)
    np.testing.assert_allclose(a, arm.sampled()[0], rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(b, arm.sampled()[1], rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(a @ m, predictor, rtol=1e-9, atol=1e-9)


def test_errors_of_the_estimates_have_the_poles_that_were_asked_for():
    a, _, m, _ = matrices(arm_study({"time": 0.1}).system)
    wanted = np.exp(-H / 0.1 * np.array([1.0, 1.1, 1.2, 1.3]))
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(a - m @ C @ a).real), np.sort(wanted), rtol=1e-9)


def mass_study(observer, **plant):
    """A mass on a spring whose place alone is measured, under state feedback of place and speed."""
    made = tuner.make_study(
        {
            "title": "Mass", "seed": 1,
            "plant": {
                "state_space": {"A": [[0.0, 1.0], [-2.0, -0.3]], "B": [[0.0], [1.5]], "C": [[1.0, 0.0], [0.0, 1.0]]},
                "control_period": H, "outputs": ["place", "speed"], **plant,
            },
            "actuator": [{"name": "u", "low": -40.0, "high": 40.0}],
            "channel": [{"name": "mass", "law": "pid_parallel", "output": "place", "rate_output": "speed", "to": "u", "lost_beyond": 2.0}],
            "gains": {"mass.kp": {"low": 0.1, "high": 50.0}, "mass.ki": 0.0, "mass.kd": 1.0, "mass.t_f": 0.1},
            "scenario": [{"name": "step", "duration": 4.0, "search": 2, "held_out": 2, "reference": {"mass": {"kind": "step"}}}],
            "objective": [{"metric": "itae.mass"}],
            "mission": {"off": ["rms.mass"]},
            "observer": {"measured": ["place"], **observer},
        }
    )  # fmt: skip
    assert isinstance(made, PlantStudy)
    return made


def test_an_observer_of_one_measurement_is_that_of_ackermann():
    a, b, m, _ = matrices(mass_study({"time": 0.05}).system)
    placed = np.exp(-H / 0.05 * np.array([1.0, 1.1]))
    predictor = np.asarray(control.acker(a.T, np.array([[1.0], [0.0]]), placed)).T
    np.testing.assert_allclose((a @ m).ravel(), predictor, rtol=1e-9)


@pytest.mark.parametrize("filtered", [False, True])
@pytest.mark.parametrize("integral", [0.0, 1.0], ids=["LQG", "LQI"])
def test_the_loop_that_flies_has_the_poles_of_regulator_and_observer(integral, filtered):
    """The separation principle: no estimate moves a pole of the regulator, nor the regulator one of the estimates."""
    k = lqr(SampledPlant(arm.study(integral=integral)), 2.0)
    negative = {(state, name) for j, name in enumerate(INPUTS) for i, state in enumerate(STATES) if k[j, i] < 0.0}
    made = arm_study({**NOISE, "filtered": filtered}, negative=negative, integral=integral)
    plant = SampledPlant(made)
    row = with_gains(made, np.array(made.default_row), plant, k)
    a, _, m, _ = matrices(made.system)
    wanted = [*np.linalg.eigvals(plant.a - plant.b @ k), *np.linalg.eigvals(a - m @ C @ a)]
    (loops,) = PlantPeriod(made.system).phases(row[None])
    flown = np.linalg.eigvals(loops.a[0])
    for pole in wanted:
        assert np.abs(flown - pole).min() < 1e-8


def compensator(system, kp, kd, filtered):
    """From the measured place to the command, as python-control has it: z+ = A z + B u + L (y - C z) with u of current estimates."""
    a, b, m, _ = matrices(system)
    c, k = np.array([[1.0, 0.0]]), np.array([[kp, kd]])
    if not filtered:
        # u = -kp y - kd (estimate of the speed)
        k_z, k_y = np.array([[0.0, kd]]), np.array([[kp]])
    else:
        k_z, k_y = k, np.zeros((1, 1))
    # State p: the prediction. z = p + M (y - C p), u = -k_z z - k_y y, p+ = A z + B u.
    z_p, z_y = np.eye(2) - m @ c, m
    u_p, u_y = -k_z @ z_p, -k_z @ z_y - k_y
    return control.ss(a @ z_p + b @ u_p, a @ z_y + b @ u_y, -u_p, -u_y, H)


@pytest.mark.parametrize("filtered", [False, True])
def test_margins_are_those_of_python_control(filtered):
    made = mass_study({"noise": {"place": 1e-3}, "input_noise": {"u": 1.0}, "filtered": filtered})
    kp, kd = 9.0, 4.0
    row = row_of(made.system, kp=kp, ki=0.0, kd=kd, t_f=0.0)
    found = PlantMargins(made.system, 0.99 * row, 1.01 * row).evaluate(row[None])
    plant: Any = control.c2d(control.ss([[0.0, 1.0], [-2.0, -0.3]], [[0.0], [1.5]], [[1.0, 0.0]], 0.0), H)
    loop: Any = compensator(made.system, kp, kd, filtered) * plant

    def value(w):
        return complex(loop(np.exp(1j * w * H)))

    crossover: Any = brentq(lambda w: abs(value(w)) - 1.0, 1.0, 20.0)
    turned: Any = brentq(lambda w: value(w).imag, 1.5 * crossover, 150.0)
    assert found.stable[0, 0]
    assert found.crossover.value[0, 0] == pytest.approx(crossover, rel=1e-6)
    assert found.phase.value[0, 0] == pytest.approx(np.pi + np.angle(value(crossover)), rel=1e-6)
    assert found.gain_up.value[0, 0] == pytest.approx(-1.0 / value(turned).real, rel=1e-6)


def lqi_arm(filtered=False):
    """LQI with observer of the arm by weights, and K."""
    k = lqr(SampledPlant(arm.study(integral=1.0)), 2.0)
    negative = {(state, name) for j, name in enumerate(INPUTS) for i, state in enumerate(STATES) if k[j, i] < 0.0}
    made = arm_study({**NOISE, "filtered": filtered}, negative=negative, integral=1.0)
    return made, k, with_gains(made, np.array(made.default_row), SampledPlant(made), k)


@pytest.mark.parametrize("filtered", [False, True])
def test_margins_of_an_lqi_with_two_inputs_are_those_of_python_control(filtered):
    """Each loop is broken at its input, the other input closed; both channels of an angle integrate its error."""
    made, k, row = lqi_arm(filtered)
    a, b, m, _ = matrices(made.system)
    z_p, z_y, direct = np.eye(4) - m @ C, m, np.zeros((4, 2))
    if not filtered:
        # Channels read angles as they are measured.
        z_p, z_y, direct = np.vstack([np.zeros((2, 4)), z_p[2:]]), np.vstack([np.zeros((2, 2)), z_y[2:]]), C.T
    u_p, u_y, u_i = -k[:, :4] @ z_p, -k[:, :4] @ (z_y + direct), -k[:, 4:]
    # States: prediction p and the integrals, which take -y; p+ = A (p + M (y - C p)) + B u.
    predicted = [a @ (np.eye(4) - m @ C) + b @ u_p, b @ u_i]
    integrated = [-H * C @ z_p if filtered else np.zeros((2, 4)), np.eye(2)]
    enters = np.vstack([a @ m + b @ u_y, -H * C @ z_y if filtered else -H * np.eye(2)])
    law: Any = control.ss(np.block([predicted, integrated]), enters, np.hstack([-u_p, -u_i]), -u_y, H)
    plant: Any = control.ss(a, b, C, np.zeros((2, 2)), H)

    def broken(w, i):
        z = np.exp(1j * w * H)
        loop = law(z) @ plant(z)
        j = 1 - i
        return loop[i, i] - loop[i, j] * loop[j, i] / (1.0 + loop[j, j])

    found = PlantMargins(made.system, 0.99 * row, 1.01 * row).evaluate(row[None])
    assert found.stable.all()
    for i, name in enumerate(("shoulder_first", "shoulder_second")):
        column = found.channels.index(name)
        crossover = found.crossover.value[0, column]
        assert abs(broken(crossover, i)) == pytest.approx(1.0, abs=1e-8)
        turn = np.pi + np.angle(broken(crossover, i))
        assert found.phase.value[0, column] == pytest.approx(turn, rel=1e-6)
        peak = max(1.0 / abs(1.0 + broken(w, i)) for w in np.geomspace(0.1, 100.0, 600))
        assert found.sensitivity.value[0, column] == pytest.approx(peak, rel=1e-3)


def test_an_lqi_with_observer_brings_both_angles_to_their_set_points_under_a_load():
    made, _, row = lqi_arm()
    steps = {
        f"{name}_{drive}": Step(size, 0.0) for name, size in (("shoulder", 0.2), ("elbow", 0.3)) for drive in INPUTS
    }
    spec = PlantScenario("step", 20.0, steps, {"first_load": Step(0.5, 0.0), "second_load": Step(-0.5, 0.0)})
    bodies, _ = stepped(made.system, row, made.system.sample(spec, 1, "step", [0]))
    np.testing.assert_allclose(bodies[-1, :2], [0.2, 0.3], atol=1e-3)


def test_a_flight_is_that_of_the_equations_with_limits_and_noise():
    """The estimate goes on with the command that came into force, not with the one that the law asked for."""
    system, kp, kd = mass_study({"time": 0.05}).system, 30.0, 5.0
    spec = PlantScenario(
        "step", 2.0, {"mass": Step(1.5, 0.0)}, sensors={"place": SensorNoise(0.01), "speed": SensorNoise(9.0)}
    )
    drawn = system.sample(spec, 1, "step", [0])
    bodies, _ = stepped(system, row_of(system, kp=kp, ki=0.0, kd=kd, t_f=0.0), drawn)
    flown, noise = bodies[:, 0], drawn.noises[0, :, 0, 0]
    a, b, m, _ = matrices(system)
    state, z, u, places, commands = np.zeros(2), np.zeros(2), 0.0, [], []
    for error in noise:
        seen, predicted = state[0] + error, a @ z + b[:, 0] * u
        z = predicted + m[:, 0] * (seen - predicted[0])
        u = float(np.clip(kp * (1.5 - seen) - kd * z[1], -40.0, 40.0))
        places.append(state[0])
        commands.append(u)
        state = a @ state + b[:, 0] * u
    assert max(map(abs, commands)) == 40.0
    np.testing.assert_allclose(flown, places, atol=1e-6)


def test_c_gives_the_bits_of_python_and_measures_the_sensed_outputs_alone(tmp_path):
    made = mass_study({"noise": {"place": 1e-3}, "input_noise": {"u": 1.0}})
    gains = row_of(made.system, kp=9.0, ki=2.0, kd=4.0, t_f=0.0).tolist()
    files = plant_files(made.system, gains, real="double", name="mass")
    written(tmp_path, files)
    measured = files["mass_controller.h"].decode().split("} mass_measured;")[0].rpartition("struct")[2]
    assert "place" in measured and "speed" not in measured
    compiled(tmp_path, "gcc", STRICT, "-shared", "-fPIC", "mass_controller.c", "-o", "mass.so")
    assert_same_bits(ctypes.CDLL(str(tmp_path / "mass.so")), "mass", made.system, gains)


@pytest.mark.parametrize(
    ("observer", "said"),
    [
        ({"time": 0.1, **NOISE}, r"observer.time: given with noise; allowed: time, or noise and input_noise"),
        ({}, r"observer.noise: given no number for shoulder; write one for each of shoulder, elbow, or time"),
        ({"time": -1.0}, r"observer.time: given -1 s; allowed: a finite number above 0"),
        (
            {"measured": ["sholder"], "time": 1.0},
            r"observer.measured\[0\]: unknown output 'sholder'; did you mean 'shoulder'",
        ),
        ({"noise": {"wrist": 1.0}}, r"observer.noise.wrist: unknown signal 'wrist'"),
    ],
)
def test_a_table_that_gives_no_observer_is_refused(observer, said):
    with pytest.raises(InputError, match=said):
        arm_study(observer)


def test_gains_of_another_observer_are_refused(tmp_path):
    one, other = (mass_study({"time": time}) for time in (0.05, 0.1))
    file = tmp_path / "gains.json"
    file.write_text(json.dumps(one.gains_document(np.array(one.default_row), {})))
    assert one.read_row(file) == pytest.approx(one.default_row)
    with pytest.raises(InputError, match=r"observer .*time 0.05.* instead of .*time 0.1"):
        other.read_row(file)


def test_another_process_has_the_same_observer():
    system = mass_study({"time": 0.05}).system
    assert system.parts.system().plan.observer == system.plan.observer
    spec = PlantScenario("step", 2.0, {"mass": Step(1.0, 0.0)})
    assert system.parts.system().content(spec) == system.content(spec)
    assert system.content(spec) != mass_study({"time": 0.06}).system.content(spec)
