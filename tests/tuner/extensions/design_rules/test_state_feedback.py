"""State feedback against python-control: LQR, LQI and poles of a two-input arm, and the loop that flies them."""

from collections.abc import Collection

import control
import numpy as np
import pytest
from rich.console import Console

import tuner
from objectives.margins.plant_period import PlantPeriod
from tuner.cli.printers.margins import both_margins
from tuner.extensions.design_rules.process import NoProcessError
from tuner.extensions.design_rules.state_feedback import SampledPlant, lqr, poles, propose, with_gains
from tuner.study.plant_study import PlantStudy

H = 0.02
# Two joints with inertia coupling, a spring and friction: accelerations by torques are coupled both ways.
A = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [-4.0, -0.5, -0.5, 0.1], [1.5, -3.0, 0.2, -0.4]])
B = np.array([[0.0, 0.0], [0.0, 0.0], [2.0, 0.6], [0.8, 3.0]])
STATES, INPUTS = ("shoulder", "elbow", "shoulder_rate", "elbow_rate"), ("first", "second")
LIMITS = {"shoulder": 0.5, "elbow": 1.0, "shoulder_rate": 3.0, "elbow_rate": 4.0}


def study(
    negative: Collection[tuple[str, str]] = (), integral=0.0, without: Collection[tuple[str, str]] = (), delay=0.0
):
    channels = [
        {
            "name": f"{state}_{name}", "law": "pid_parallel", "output": state, "to": name, "lost_beyond": LIMITS[state],
            "b0": -1.0 if (state, name) in negative else 1.0,
        }
        for state in STATES for name in INPUTS if (state, name) not in without
    ]  # fmt: skip
    gains = {}
    for channel in channels:
        ki = integral if channel["output"] in ("shoulder", "elbow") else 0.0
        gains |= {
            f"{channel['name']}.{gain}": value for gain, value in (("kp", 1.0), ("ki", ki), ("kd", 0.0), ("t_f", 0.0))
        }
    gains["shoulder_first.kp"] = {"low": 0.1, "high": 100.0, "default": 1.0}
    made = tuner.make_study(
        {
            "title": "Arm", "seed": 1,
            "plant": {
                "state_space": {"A": A.tolist(), "B": B.tolist(), "C": np.eye(4).tolist()}, "control_period": H,
                "inputs": list(INPUTS), "outputs": list(STATES),
            },
            "actuator": [{"name": name, "scale": scale, "delay": delay} for name, scale in zip(INPUTS, (2.0, 5.0), strict=True)],
            "channel": channels, "gains": gains,
            "scenario": [{"name": "rest", "duration": 1.0, "search": 2, "held_out": 2}],
            "objective": [{"metric": "rms.shoulder_first"}],
            # Automatic limits would fly the default, whose kernel takes 8 s to compile.
            "mission": {"off": [f"rms.{channel['name']}" for channel in channels]},
        }
    )  # fmt: skip
    assert isinstance(made, PlantStudy)
    return made


def sampled():
    system = control.c2d(control.ss(A, B, np.eye(4), np.zeros((4, 2))), H)
    return np.asarray(system.A), np.asarray(system.B)


Q, R = np.diag([1.0 / LIMITS[name] ** 2 for name in STATES]), np.diag([1.0 / 4.0, 1.0 / 25.0])


def test_lqr_is_that_of_python_control():
    wanted, _, _ = control.dlqr(*sampled(), Q, R)
    np.testing.assert_allclose(lqr(SampledPlant(study()), None), wanted, rtol=1e-9, atol=1e-9)


def test_lqi_is_that_of_python_control_with_the_integrals_of_the_law():
    a, b = sampled()
    picked = np.eye(4)[:2]
    wide = np.block([[a, np.zeros((4, 2))], [-H * picked, np.eye(2)]])
    lasting = 2.0
    weights = np.diag([*np.diag(Q), *(1.0 / (lasting * LIMITS[name]) ** 2 for name in STATES[:2])])
    wanted, _, _ = control.dlqr(wide, np.vstack([b, np.zeros((2, 2))]), weights, R)
    np.testing.assert_allclose(lqr(SampledPlant(study(integral=1.0)), lasting), wanted, rtol=1e-9, atol=1e-9)


def test_placed_poles_are_where_they_were_asked_for():
    sampled_plant = SampledPlant(study())
    closed = sampled_plant.a - sampled_plant.b @ poles(sampled_plant, 0.5)
    wanted = np.exp(-H / 0.5 * np.array([1.0, 1.1, 1.2, 1.3]))
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(closed).real), np.sort(wanted), rtol=1e-9)


def test_poles_of_one_input_are_those_of_ackermann():
    plant = control.c2d(control.ss([[0.0, 1.0], [-2.0, -0.3]], [[0.0], [1.5]], np.eye(2), np.zeros((2, 1))), H)
    placed = np.exp(-H / 0.4 * np.array([1.0, 1.1]))
    made = tuner.make_study(
        {
            "title": "Mass", "seed": 1,
            "plant": {
                "state_space": {"A": [[0.0, 1.0], [-2.0, -0.3]], "B": [[0.0], [1.5]], "C": [[1.0, 0.0], [0.0, 1.0]]},
                "control_period": H, "outputs": ["place", "speed"],
            },
            "channel": [{"name": "mass", "law": "pid_parallel", "output": "place", "rate_output": "speed", "to": "u", "lost_beyond": 2.0}],
            "gains": {"mass.kp": {"low": 0.1, "high": 50.0}, "mass.ki": 0.0, "mass.kd": 1.0, "mass.t_f": 0.1},
            "scenario": [{"name": "step", "duration": 4.0, "search": 2, "held_out": 2, "reference": {"mass": {"kind": "step"}}}],
            "objective": [{"metric": "itae.mass"}],
        }
    )  # fmt: skip
    wanted = np.asarray(control.acker(plant.A, plant.B, placed)).ravel()
    designed = tuner.design(made, method="poles", time=0.4)
    found = [designed.gains[f"mass.{name}"] for name in ("kp", "kd", "t_f")]
    assert found == pytest.approx([*wanted, 0.0], rel=1e-9)


def closed_by_flight(made, row):
    """Poles of one control period of the loop that flies, with the integral and filter states of all channels."""
    (loops,) = PlantPeriod(made.system).phases(row[None])
    return np.linalg.eigvals(loops.a[0])


@pytest.mark.parametrize("integral", [0.0, 1.0], ids=["LQR", "LQI"])
def test_the_flown_loop_has_the_designed_poles(integral):
    k = lqr(SampledPlant(study(integral=integral)), 2.0)
    negative = {(state, name) for j, name in enumerate(INPUTS) for i, state in enumerate(STATES) if k[j, i] < 0.0}
    made = study(negative, integral)
    sampled_plant = SampledPlant(made)
    row = with_gains(made, np.array(made.default_row), sampled_plant, k)
    wanted = np.linalg.eigvals(sampled_plant.a - sampled_plant.b @ k)
    flown = closed_by_flight(made, row)
    for pole in wanted:
        assert np.abs(flown - pole).min(axis=0) < 1e-9


def test_a_negative_entry_asks_for_the_other_sign_of_b0():
    sampled_plant = SampledPlant(made := study())
    k = np.where(np.arange(4) == 2, -1.0, 1.0) * np.ones((2, 1))
    with pytest.raises(NoProcessError, match=r"shoulder_rate_first.kp is -1; write b0 = -1 for the channel"):
        with_gains(made, np.array(made.default_row), sampled_plant, k)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"without": {("elbow", "first")}}, "no channel feeds elbow back to first"),
        (
            {"without": {("elbow_rate", "first"), ("elbow_rate", "second")}},
            "has 4 states, its channels feed back 3 outputs",
        ),
        ({"delay": H}, "without delay and lag"),
    ],
)
def test_a_study_that_lacks_something_keeps_its_gains_and_says_why(options, reason):
    made = study(**options)
    # Not by `tuner.design`, whose margins compile a kernel of 10 s for each of these loops.
    proposal = propose(lqr, made, None)
    assert np.array_equal(proposal.row, made.default_row)
    assert all(reason in each.why and not each.designed for each in proposal.channels.values())


def test_margins_of_an_unstable_default_are_dashes_next_to_the_design():
    made = tuner.make_study(
        {
            "title": "Cart", "seed": 1,
            "plant": {
                "state_space": {"A": [[0.0, 1.0], [0.0, 0.0]], "B": [[0.0], [1.0]], "C": [[1.0, 0.0], [0.0, 1.0]]},
                "control_period": H, "outputs": ["place", "speed"],
            },
            "channel": [{"name": "cart", "law": "pid_parallel", "output": "place", "rate_output": "speed", "to": "u", "lost_beyond": 2.0}],
            "gains": {"cart.kp": {"low": 0.1, "high": 50.0}, "cart.ki": 0.0, "cart.kd": 0.0, "cart.t_f": 0.0},
            "scenario": [{"name": "rest", "duration": 1.0, "search": 2, "held_out": 2}],
            "objective": [{"metric": "rms.cart"}],
            "mission": {"off": ["rms.cart"]},
        }
    )  # fmt: skip
    console = Console(width=100)
    with console.capture() as capture:
        console.print(both_margins(tuner.design(made, method="lqr").margins))
    rows = [line.split() for line in capture.get().splitlines()]
    default, design = (next(row for row in rows if who in row)[-1] for who in ("default", "design"))
    assert default == "-!" and design not in ("-", "-!")
