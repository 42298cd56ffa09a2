"""Logs of simulated rate loops: the law around plants of one axis each, integrated exactly between the steps."""

import numpy as np
from numpy.typing import NDArray

from plant.laws.filters import stage_share
from tuner.extensions.betaflight_adrc import equations
from tuner.extensions.betaflight_adrc.identifying import MIX
from tuner.extensions.betaflight_adrc.linear_loop import AxisPlant, Sampling
from tuner.extensions.betaflight_adrc.settings import AXES, Tune
from tuner.extensions.logs.flight_log import FlightLog

Array = NDArray[np.float64]
N_SUBSTEPS, HOVER = 4, 0.35
NOISE, DISTURBANCE, MEMORY = 1.0, 3.0, 0.1
"""Noise of the gyro [deg/s]; disturbance in units of output, and its correlation time [s]."""
IN_FLIGHT = equations.Gate(1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0)


def chirp(period: float, duration: float, amplitude: float) -> Array:
    """Return a sweep from 1 to 60 Hz."""
    time, ratio = np.arange(round(duration / period)) * period, np.log(60.0)
    return amplitude * np.sin(2.0 * np.pi * duration / ratio * (np.exp(ratio * time / duration) - 1.0))


def slow_sticks(period: float, duration: float, amplitude: float, rng: np.random.Generator) -> Array:
    """Return slow turns of a stick: half-second steps behind a lag of 0.3 s."""
    n, held = round(duration / period), round(0.5 / period)
    steps = np.repeat(rng.uniform(-amplitude, amplitude, n // held + 1), held)[:n]
    out, value = np.zeros(n), 0.0
    for i, step in enumerate(steps):
        value += period / 0.3 * (step - value)
        out[i] = value
    return out


def fly_axis(
    tune: Tune,
    axis: str,
    plant: AxisPlant,
    sampling: Sampling,
    setpoint: Array,
    rng: np.random.Generator,
    gate: equations.Gate = IN_FLIGHT,
) -> tuple[Array, Array]:
    """Return output and filtered gyro [deg/s] by loop."""
    period, constants = sampling.period, tune.axis(axis, sampling.period)
    step = period / N_SUBSTEPS
    waiting = [0.0] * round(plant.dead_time / step)
    shares = [stage_share(cutoff, period) for cutoff in sampling.cutoffs]
    stages, memory = [0.0] * len(shares), equations.seeded(0.0)
    decay, rate, thrust, force = np.exp(-step / plant.lag), 0.0, 0.0, 0.0
    outputs, rates = np.zeros(len(setpoint)), np.zeros(len(setpoint))
    kicks = DISTURBANCE * np.sqrt(2.0 * period / MEMORY) * rng.standard_normal(len(setpoint))
    noise = NOISE * rng.standard_normal(len(setpoint))
    for i, wanted in enumerate(setpoint):
        seen = rate + noise[i]
        for j, share in enumerate(shares):
            stages[j] += share * (seen - stages[j])
            seen = stages[j]
        terms, memory = equations.step_axis(memory, constants, gate, seen, wanted, 0.0, period)
        output = float(np.clip(sum(terms), -constants.limit, constants.limit))
        memory = equations.with_output(memory, output)
        outputs[i], rates[i] = output, seen
        force += kicks[i] - force * period / MEMORY
        for _ in range(N_SUBSTEPS):
            waiting.append(output)
            command = waiting.pop(0)
            after = decay * thrust + (1.0 - decay) * command
            turned = command * step + (thrust - command) * plant.lag * (1.0 - decay) + plant.zero * (after - thrust)
            rate += plant.gain * (turned + force * step)
            thrust = after
    return outputs, rates


def flight_log(outputs: Array, rates: Array, setpoints: Array, sampling: Sampling, every: int) -> FlightLog:
    """Return the log of outputs, rates and setpoints (n, 3), with every so many loops."""
    rows = slice(None, None, every)
    time = np.asarray(np.arange(len(outputs))[rows] * sampling.period, dtype=np.float64)
    gravity = np.tile([0.0, 0.0, 9.81], (len(time), 1))
    command = HOVER + outputs @ MIX / 1000.0
    log = "simulated", "simulated", "0" * 64
    return FlightLog(*log, time, np.radians(rates[rows]), gravity, command[rows], setpoint=np.radians(setpoints[rows]))


def fly(
    tune: Tune,
    plants: dict[str, AxisPlant],
    sampling: Sampling,
    setpoints: Array,
    rng: np.random.Generator,
    every: int = 2,
) -> FlightLog:
    """Return the log of the axes in `plants`; the others do not move."""
    flown = {axis: fly_axis(tune, axis, plants[axis], sampling, setpoints[:, AXES.index(axis)], rng) for axis in plants}
    still = np.zeros(len(setpoints)), np.zeros(len(setpoints))
    outputs, rates = (np.column_stack([flown.get(axis, still)[k] for axis in AXES]) for k in (0, 1))
    return flight_log(outputs, rates, setpoints, sampling, every)
