"""What a margin says, flown: with 0.98 of a margin taken the loop still comes to rest, with 1.02 it swings up."""

from typing import NamedTuple

import numpy as np
import pytest

from objectives.margins.describing import Case
from objectives.margins.margins import MarginModel
from objectives.margins.period import CHANNELS, PeriodMap
from objectives.margins.trim import setting_of, smooth_dynamics
from plant.backends import array
from plant.loop import Timing
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.trim import trim_of
from plant.records import paths
from tests.objectives.margins.designs import HUMMINGBIRD, cascade_of, random_gains
from tests.objectives.margins.stepping import Stepper
from tests.tuner.conftest import QUICKSTART
from tuner.study.build import load_study
from tuner.study.trim import steady_states

STUDIES = QUICKSTART.parent
# Deviations this small keep the nonlinear terms at the gain that they have at rest, and 1e4 above rounding.
SMALL, SIZE = (Case(0.0),), 1e-9
# Periods after which deviations are brought back to that size: all loops step together again, those that wait among them.
KEPT = 48
LARGEST = {"gain_up": 30.0, "gain_down": 30.0, "delay": 0.5}


class Lane(NamedTuple):
    """One experiment: gains row, channel, factor on its command, delay in steps, and what must come of it."""

    row: int
    channel: int
    factor: float
    delay: int
    rests: bool


def lanes_of(margins, channels, step):
    """Experiments at both sides of every margin that is not too wide to be flown."""
    found = []
    for row in range(len(margins.stable)):
        for channel in (CHANNELS.index(name) for name in channels if margins.stable[row, CHANNELS.index(name)]):
            up, down, delay = (getattr(margins, what).value[row, channel] for what in LARGEST)
            if up < LARGEST["gain_up"]:
                found += [Lane(row, channel, up**share, 0, share < 1.0) for share in (0.98, 1.02)]
            if down < LARGEST["gain_down"]:
                found += [Lane(row, channel, down**-share, 0, share < 1.0) for share in (0.98, 1.02)]
            if 50 * step < delay < LARGEST["delay"]:
                found.append(Lane(row, channel, 1.0, int(0.98 * delay / step), True))
                found.append(Lane(row, channel, 1.0, int(1.02 * delay / step) + 1, False))
    return found


class Experiment:
    """Lanes flown side by side from a trim with small deviations; the command of each lane's channel is scaled and delayed."""

    def __init__(self, model, knowledge, vehicle, designs, lanes, duration):
        cascade, timing = model.flown, model.timing
        self.inner = not {CHANNELS.index(name) for name in ("x", "y")} & {lane.channel for lane in lanes}
        rows, self.channel, self.factor, self.delay, self.rests = (np.array(part) for part in zip(*lanes, strict=True))
        self.lane = np.arange(len(lanes))
        self.gains = designs[rows].T
        self.stepper = Stepper(cascade, knowledge, timing, smooth_dynamics(vehicle), model.trim, names=array.NAMES)
        setting, balance = setting_of(model.trim, knowledge, vehicle), trim_of(vehicle, model.trim.air, model.trim.yaw)
        (rest,) = PeriodMap(cascade, timing).at_rest(
            balance.body[0], self.gains.T, setting.nominal, setting.reference, setting.dynamics
        )
        self.rest = rest.T
        for _ in range(KEPT if cascade.position_every > 1 else 0):
            self.rest, _, _ = self.stepper.step(self.rest, self.gains)
        self.steps = timing.steps if self.inner else 1
        self.periods = round(duration / timing.control_period)
        self.history = np.zeros((self.periods * self.steps + 1, len(lanes)))
        _, command, _ = self.stepper.step(self.rest, self.gains)
        self.balance = np.array(np.broadcast_arrays(*command, self.factor)[:-1])[self.channel, self.lane]

    def altered(self, commands, now):
        """What each lane's own command lacks of the one that is scaled and comes late."""
        own = np.array(np.broadcast_arrays(*commands, self.factor)[:-1])[self.channel, self.lane] - self.balance
        self.history[now] = own
        late = np.where(now >= self.delay, self.history[np.maximum(now - self.delay, 0), self.lane], 0.0)
        return self.factor * late - own

    def start(self):
        """Hover, with a small velocity or rate in the lane's channel alone: other modes would hide the one in question."""
        state = self.rest.copy()
        names = paths(self.stepper.state)
        for i, part in enumerate(("velocity.x", "velocity.y", "velocity.z", "rate.x", "rate.y", "rate.z")):
            state[names.index(f"body.{part}")] += SIZE * (self.channel == i)
        return state

    def fly(self):
        """ln of the growth of each lane's command, root mean square, from the middle half of the flight to the last.

        Both are seen through a window that rises and falls smoothly, so that no oscillation counts for growth.
        """
        state, scale = self.start(), np.zeros(len(self.lane))
        energy = np.zeros((2, len(self.lane)))
        for k in range(self.periods):

            def push(x, y, k=k):
                added = self.altered([x, y, 0.0, 0.0, 0.0, 0.0], k)
                return np.where(self.channel == 0, added, 0.0), np.where(self.channel == 1, added, 0.0)

            def twist(lift, torque, sub_step, k=k):
                added = self.altered([0.0, 0.0, lift, *torque], k * self.steps + sub_step)
                return [np.where(self.channel == i, added, 0.0) for i in (2, 3, 4, 5)]

            state, _, _ = self.stepper.step(state, self.gains, *((None, twist) if self.inner else (push, None)))
            phase = np.clip(4.0 * k / self.periods - np.array([1.0, 2.0]), 0.0, 2.0) * np.pi
            energy += np.outer((1.0 - np.cos(phase)) ** 2, np.exp(2.0 * scale) * self.history[k * self.steps] ** 2)
            if (k + 1) % KEPT == 0:
                size = np.sqrt(np.sum((state - self.rest) ** 2, axis=0))
                scale = scale + np.log(size / SIZE)
                state = self.rest + (state - self.rest) * SIZE / size
                self.history *= SIZE / size
        return 0.5 * np.log(energy[1] / energy[0])


CASES = {
    "position": (("ladrc", "hybrid"), ControlOptions(delay=True), Timing(0.008, 0.008), ("x", "y"), 8.0),
    "inner": (("ladrc", "hybrid"), ControlOptions(delay=True), Timing(0.004, 0.001), ("z", "roll", "yaw"), 6.0),
    "without delay": (
        ("pid", "ladrc"),
        ControlOptions(attitude_rate="observer"),
        Timing(0.004, 0.001),
        ("roll", "yaw"),
        9.0,
    ),
}


def experiment_of(case, seed=1):
    """Return an experiment at hover with both sides of every margin of random gains."""
    pair, options, timing, channels, duration = case
    knowledge, designs = (
        nominal(HUMMINGBIRD, options, timing.control_period),
        random_gains(pair[0], pair[1], 2, seed, 0.4),
    )
    model = MarginModel(cascade_of(*pair), knowledge, timing, HUMMINGBIRD, cases=SMALL)
    inner = not {"x", "y"} & set(channels)
    step = timing.plant_step if inner else timing.control_period
    lanes = lanes_of(model.evaluate(designs), channels, step)
    return Experiment(model, knowledge, HUMMINGBIRD, designs, lanes, duration)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_loops_rest_within_their_margins_and_swing_up_beyond(name):
    experiment = experiment_of(CASES[name])
    growth = experiment.fly()
    assert len(growth) >= 12
    assert (growth[experiment.rests] < 0.0).all()
    assert (growth[~experiment.rests] > 0.0).all()


# Shares of a gain margin, as a level, up to which a loop is scaled.
INSIDE, BEYOND = 0.95, 1.05
FLIPPED = {"quickstart": 6.0, "f450": 8.0, "autopilot_pid": 8.0, "figure_eight": 8.0, "px4": 8.0, "betaflight": 6.0}


@pytest.mark.slow
@pytest.mark.parametrize("name", FLIPPED)
def test_in_the_trims_of_studies_loops_rest_at_0_95_of_the_gain_margin_and_swing_up_at_1_05(name):
    """Roll and pitch of the default gains, in the study's trims, as the model flies them: laws of two firmwares among them."""
    study = load_study(STUDIES / f"{name}.toml")
    system, specs = study.system, [entry.spec for entry in study.scenarios]
    trims = [state for state in steady_states(specs, system) if state.wind != (0.0, 0.0, 0.0)]
    for state in (trims[0], trims[-1]):
        model = MarginModel(system.cascade, system.nominal, system.timing, system.vehicle, state.trim, cases=SMALL)
        designs = np.array([study.default_row])
        margins = model.evaluate(designs)
        assert margins.stable.all()
        channels = [CHANNELS.index(axis) for axis in ("roll", "pitch")]
        lanes = [
            Lane(0, channel, float(margins.gain_up.value[0, channel]) ** share, 0, share < 1.0)
            for channel in channels
            for share in (INSIDE, BEYOND)
        ]
        experiment = Experiment(model, system.nominal, system.vehicle, designs, lanes, FLIPPED[name])
        growth = experiment.fly()
        assert (growth[experiment.rests] < 0.0).all(), (state.name, growth)
        assert (growth[~experiment.rests] > 0.0).all(), (state.name, growth)
