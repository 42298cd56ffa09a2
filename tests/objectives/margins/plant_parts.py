"""Plants and laws as systems of python-control, from the user's derivative and the law alone.

A plant is sampled with its input held; a law is asked what each of its inputs does.
"""

from typing import Any

import control
import numpy as np

from plant.laws.channel import Applied, Measured, Setpoint
from plant.laws.channel import Channel as Known
from plant.records import flatten, pack
from plant.records import size as length


def plant_blocks(system, actuator) -> dict[str, Any]:
    """Systems of python-control from the command of an input to every output, sampled with the command held."""
    plant = system.plant
    state, held = plant.rest(system.parameters)
    quiet = pack(plant.Disturbance, [0.0] * len(plant.Disturbance._fields))
    point = np.array([*state, held[plant.Input._fields.index(actuator.name)]])

    def rate(x):
        force = held._replace(**{actuator.name: x[-1]})
        return np.array(plant.derivative(plant.State(*x[:-1]), force, quiet, system.parameters))

    units = np.eye(len(point)) * 1e-4
    slope = np.array([(rate(point + e) - rate(point - e)) / 2e-4 for e in units]).T
    n = len(state)
    if actuator.lag > 0.0:
        a = np.vstack([slope, np.append(np.zeros(n), -1.0 / actuator.lag)])
        b = np.append(np.zeros(n), 1.0 / actuator.lag)
    else:
        a, b = slope[:, :n], slope[:, n]
    outputs = np.array(plant.output(plant.State(*np.eye(n)), held, quiet, system.parameters))
    period = system.timing.control_period
    return {
        name: control.c2d(control.ss(a, b[:, None], np.append(row, np.zeros(len(a) - n))[None], 0.0), period)
        for name, row in zip(plant.Output._fields, outputs, strict=True)
    }


def law_blocks(channel, gains, h) -> dict[str, Any]:
    """Systems from set point, measurement, measured rate and effect to the command of a linear law, asked input by input."""
    law, constants = channel.law, channel.law.prepare(channel.law.Gains(*gains), h)
    known = Known(channel.b0, 0.0 if channel.rate_output else 1.0)
    size = length(law.Memory)

    def step(x):
        memory = pack(law.Memory, x[:size].tolist())
        goal, seen, rate, effect = x[size:]
        command, after = law.step(
            memory, constants, known, Setpoint(goal, 0.0, 0.0), Measured(seen, rate), Applied(effect, 0.0), h
        )
        return np.array([*flatten(after), command])

    slope = np.array([step(unit) for unit in np.eye(size + 4)]).T
    a, b, c, d = slope[:size, :size], slope[:size, size:], slope[size:, :size], slope[size:, size:]
    names = ("goal", "seen", "rate", "effect")
    return {name: control.ss(a, b[:, [i]], c, d[:, [i]], h) for i, name in enumerate(names)}


def feedback(channel, law, plant, z):
    """Response of a channel's command to its measurement, per unit of the force that moves the plant."""
    seen = law["seen"](z) * plant[channel.output](z)
    return seen + (law["rate"](z) * plant[channel.rate_output](z) if channel.rate_output else 0.0)
