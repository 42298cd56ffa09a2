"""State feedback as gains of channels: LQR, LQI and pole placement.

All states are outputs, measured or estimated by the observer of the study. Commands of several channels on one input add
up, so a channel from every output to every input is
u = -K x: kp of a channel is an entry of K, kd one for its `rate_output`, ki one for the integral of its output's error. The plant
is sampled exactly with its commands held, and integrals are those of the law, so the sampled loop has the designed poles.

G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., chapters 8 and 9; weights by Bryson's
rule: an error as large as `lost_beyond` counts like a command as large as its scale.
"""

from collections.abc import Callable
from math import inf, isfinite

import numpy as np
from scipy.linalg import block_diag, solve_discrete_are

from objectives.design.plant_design import ChannelDesign
from plant.model.plan import Channel
from plant.model.slope import LinearEquations, linear_equations
from plant.records import paths
from tuner.api.designing import Proposal
from tuner.extensions.design_rules.peaks import judged
from tuner.extensions.design_rules.process import NoProcessError
from tuner.extensions.design_rules.sampling import sampled_outputs, spaced_poles
from tuner.study.plant_study import PlantStudy

Array = np.ndarray
LAW = "pid_parallel"
# Errors that last so many control periods count in an integral as much as they do at once.
INTEGRAL_PERIODS = 100
# Relative size below which an entry of K is no gain.
NOTHING = 1e-9
# A proportional gain of nothing, which must be above 0.
MIN_GAIN = 1e-300


class SampledPlant:
    """A sampled plant with the signals that its channels feed back.

    signals: outputs, then integrals of the error of those whose channels have ki above 0. a, b: from the signals now and the
    commands to the signals a period later. entries: by signal and input, the gain of the channel that feeds it back.
    """

    def __init__(self, study: PlantStudy) -> None:
        system = study.system
        self.h, self.plan, self.plant = system.timing.control_period, system.plan, system.plant
        for channel in self.plan.channels:
            self._check(channel)
        values = dict(zip((gain.address for gain in system.gains), study.default_row, strict=True))
        self.inputs = tuple(dict.fromkeys(channel.to for channel in self.plan.channels))
        self.entries = dict[tuple[str, str], tuple[Channel, str]]()
        for channel in self.plan.channels:
            self._enter(channel.output, channel, "kp")
            if channel.rate_output:
                self._enter(channel.rate_output, channel, "kd")
            if values[f"{channel.name}.ki"] > 0.0:
                self._enter(f"integral of {channel.output}", channel, "ki")
        names = dict.fromkeys(signal for signal, _ in self.entries)
        self.outputs = [name for name in names if name in self.plant.Output._fields]
        self.integrals = [name for name in names if name not in self.outputs]
        self.a, self.b = self._sampled(linear_equations(system.equations, system.parameters))

    @property
    def signals(self) -> list[str]:
        """Names of the outputs and integrals."""
        return [*self.outputs, *self.integrals]

    def _check(self, channel: Channel) -> None:
        actuator = next(each for each in self.plan.actuators if each.name == channel.to)
        if channel.law.name != LAW:
            raise NoProcessError(f"state feedback is flown by the law {LAW}, and it has '{channel.law.name}'")
        if channel.every > 1 or actuator.delay > 0.0 or actuator.lag > 0.0:
            raise NoProcessError(
                "state feedback takes channels that step together, and actuators without delay and lag"
            )

    def _enter(self, signal: str, channel: Channel, gain: str) -> None:
        if self.entries.setdefault((signal, channel.to), (channel, gain))[0] is not channel:
            raise NoProcessError(f"two channels feed {signal} back to {channel.to}; leave one")

    def _sampled(self, equations: LinearEquations) -> tuple[Array, Array]:
        """Return the matrices of one period, from signals and commands to signals."""
        n = len(equations.a)
        if len(self.outputs) != n:
            raise NoProcessError(
                f"state feedback needs every state as an output: the plant has {n} states, its channels feed back "
                f"{len(self.outputs)} outputs ({', '.join(self.outputs)}); give each state an output and a channel, and name "
                "those with a sensor in [observer]"
            )
        rows = [self.plant.Output._fields.index(name) for name in self.outputs]
        columns = [paths(self.plant.Input).index(name) for name in self.inputs]
        sampled = sampled_outputs(equations, rows, columns, self.h)
        if sampled is None:
            raise NoProcessError("its outputs are not independent; give each state an output of its own")
        picked = np.array([[float(f"integral of {name}" == each) for name in self.outputs] for each in self.integrals])
        wide = np.asarray(block_diag(sampled[0], np.eye(len(self.integrals))))
        if len(self.integrals):
            wide[n:, :n] = -self.h * picked
        return wide, np.concatenate([sampled[1], np.zeros((len(self.integrals), len(columns)))])

    def weights(self, time: float | None) -> tuple[Array, Array]:
        """Return the weights of signals and of commands.

        time: how long an error counts in its integral as much as it does at once [s].
        """
        limits = {channel.output: channel.limit for channel in self.plan.channels if isfinite(channel.limit)}
        lasting = INTEGRAL_PERIODS * self.h if time is None else time
        scales = [limits.get(name, inf) for name in self.outputs]
        scales += [lasting * limits.get(name.removeprefix("integral of "), 1.0) for name in self.integrals]
        sizes = [self.plan.scales[name] for name in self.inputs]
        return np.diag([1.0 / each**2 for each in scales]), np.diag([1.0 / each**2 for each in sizes])


def lqr(sampled_plant: SampledPlant, time: float | None) -> Array:
    """Return K (inputs, signals) of the linear quadratic regulator of the sampled plant."""
    a, b, (q, r) = sampled_plant.a, sampled_plant.b, sampled_plant.weights(time)
    try:
        p = solve_discrete_are(a, b, q, r)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise NoProcessError(
            "no regulator exists: a state that is not stable has no weight, or no command moves it; give the channels of the "
            "outputs that matter lost_beyond"
        ) from error
    return np.linalg.solve(r + b.T @ p @ b, b.T @ p @ a)


def poles(sampled_plant: SampledPlant, time: float | None) -> Array:
    """Return K (inputs, signals) that places the poles of the sampled plant at -(1 + 0.1 i)/time."""
    from scipy.signal import place_poles

    if time is None:
        raise NoProcessError("poles needs --time, the slowest time constant of the closed loop [s]")
    placed = spaced_poles(time, sampled_plant.h, len(sampled_plant.a))
    try:
        return np.asarray(vars(place_poles(sampled_plant.a, sampled_plant.b, placed))["gain_matrix"])
    except ValueError as error:
        raise NoProcessError(f"the poles cannot be placed: {error}") from error


def propose(method: Callable[[SampledPlant, float | None], Array], study: PlantStudy, time: float | None) -> Proposal:
    """Return the gains of state feedback, or the default with a reason.

    time: see the method [s].
    """
    row = np.array(study.default_row, dtype=float)
    try:
        sampled_plant = SampledPlant(study)
        row = with_gains(study, row, sampled_plant, method(sampled_plant, time))
    except NoProcessError as error:
        return Proposal(row, dict.fromkeys(study.system.plan.names, ChannelDesign(False, str(error))))
    return Proposal(row, judged(study, row))


def with_gains(study: PlantStudy, row: Array, sampled_plant: SampledPlant, k: Array) -> Array:
    """Return a gains row with the entries of K; NoProcessError for one that no channel can fly."""
    columns = {gain.address: gain.column for gain in study.system.gains}
    row, least, wrong, signs = row.copy(), NOTHING * np.abs(k).max(), list[str](), dict[str, set[bool]]()
    for signal, of_signal in zip(sampled_plant.signals, k.T, strict=True):
        for name, value in zip(sampled_plant.inputs, of_signal.tolist(), strict=True):
            # Integrals are of r - y, and u = -K x has them with the other sign than the outputs.
            value = -value if signal in sampled_plant.integrals else value
            if (signal, name) not in sampled_plant.entries:
                if abs(value) <= least:
                    continue
                raise NoProcessError(f"no channel feeds {signal} back to {name}; K has {value:.4g} there: add one")
            channel, gain = sampled_plant.entries[signal, name]
            scaled = value * channel.b0
            if abs(scaled) > least:
                signs.setdefault(channel.name, set()).add(scaled > 0.0)
            if scaled < -least:
                wrong.append(_wrong_sign(channel, gain, value))
            row[columns[f"{channel.name}.{gain}"]] = max(scaled, MIN_GAIN if gain == "kp" else 0.0)
            if gain == "kd":
                row[columns[f"{channel.name}.t_f"]] = 0.0
    if mixed := [name for name, both in signs.items() if len(both) > 1]:
        raise NoProcessError(
            f"entries of K for one channel differ in sign ({', '.join(mixed)}); change the weights, or give its rate or integral "
            "to no channel"
        )
    if wrong:
        raise NoProcessError("; ".join(wrong))
    return row


def _wrong_sign(channel: Channel, gain: str, value: float) -> str:
    """Return the reason why a channel cannot fly an entry of K."""
    if gain == "kd":
        return f"{channel.name}.kd is {value:.4g}; give {channel.rate_output} a channel of its own, with b0 = {-channel.b0:g}"
    return f"{channel.name}.{gain} is {value:.4g}; write b0 = {-channel.b0:g} for the channel"
