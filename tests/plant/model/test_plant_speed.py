"""Compiled lanes against the same loop written in NumPy by hand: the same numbers, and at least ten times as many of them."""

from time import process_time

import numpy as np
import pytest

from plant.backends.flyer import Flyer
from plant.loop import Timing
from plant.model.plan import Actuator
from plant.model.scenario import PlantScenario
from plant.model.signals import Coloured, Step
from tests.plant.model.plants import pid, system_of

GAINS = np.array([10.0, 20.0, 0.2, 0.001])
FLIGHTS, H = 1024, 0.001
SPEC = PlantScenario("turn", 0.4, {"angle": Step(1.0)}, {"torque": Coloured(0.001, 0.05)}, spread={"inertia": 0.2})


def motor():
    channel = pid("angle", "angle", "voltage", limit=10.0)
    return system_of("dc_motor", [channel], [Actuator("voltage", -12.0, 12.0, delay=H, lag=H)], Timing(H, H))


def by_hand(inertia, torque):
    """All flights at once, one array for each number, as one writes it in NumPy: the integrals of |e| and of |e| t."""
    friction, constant, resistance = 3.5077e-6, 0.0274, 4.0
    kp, ki, kd, t_f = GAINS
    smoothing = 1.0 - np.exp(-H / t_f)
    angle, speed, lagged = np.zeros((3, len(inertia)))
    rate, integral, excess, waiting = np.zeros((4, len(inertia)))
    before, iae, itae = np.zeros((3, len(inertia)))

    def moving(angle, speed, lagged, command, push):
        current = (lagged - constant * speed) / resistance
        return speed, (constant * current - friction * speed + push) / inertia, (command - lagged) / H

    for k, push in enumerate(torque):
        error = 1.0 - angle
        iae += H * np.abs(error)
        itae += H * (k * H) * np.abs(error)
        rate += smoothing * ((angle - before) / H - rate)
        before = angle
        integral = integral + H * ki / kp * excess
        asked = kp * error + integral - kd * rate
        integral = integral + H * ki * error
        command, force = np.clip(asked, -12.0, 12.0), waiting
        excess, waiting = command - asked, command
        k1 = moving(angle, speed, lagged, force, push)
        k2 = moving(*(x + 0.5 * H * d for x, d in zip((angle, speed, lagged), k1, strict=True)), force, push)
        k3 = moving(*(x + 0.5 * H * d for x, d in zip((angle, speed, lagged), k2, strict=True)), force, push)
        k4 = moving(*(x + H * d for x, d in zip((angle, speed, lagged), k3, strict=True)), force, push)
        angle, speed, lagged = (
            x + H / 6.0 * (a + 2.0 * b + 2.0 * c + d)
            for x, a, b, c, d in zip((angle, speed, lagged), k1, k2, k3, k4, strict=True)
        )
    return iae, itae


def timed(work):
    begin = process_time()
    result = work()
    return result, process_time() - begin


@pytest.mark.slow
def test_lanes_fly_ten_times_as_fast_as_numpy():
    """Processor time of one thread each, the median of five rounds side by side; the lanes keep all their meters besides."""
    system = motor()
    drawn = system.sample(SPEC, 3, "search", range(FLIGHTS))
    flyer = Flyer(system.loop, system.limits, system.timing, 1)
    flyer.fly(GAINS[None], system.nominal, drawn)
    inertia = drawn.dynamics[:, 0].ravel()
    torque = np.ascontiguousarray(np.moveaxis(drawn.disturbances[:, :, 0], 0, 1).reshape(len(drawn.references), -1))
    rounds = [
        (timed(lambda: flyer.fly(GAINS[None], system.nominal, drawn)), timed(lambda: by_hand(inertia, torque)))
        for _ in range(5)
    ]
    ratios = [slow / fast for (_, fast), (_, slow) in rounds]
    (ours, _), ((iae, itae), _) = rounds[-1]
    names = system.loop.Meters.__annotations__["angle"]._fields
    np.testing.assert_allclose(ours[0, :, names.index("iae")], iae, rtol=1e-9)
    np.testing.assert_allclose(ours[0, :, names.index("itae")], itae, rtol=1e-9)
    print(f"\nlanes over NumPy, one thread: {np.median(ratios):.1f}")
    assert np.median(ratios) > 10.0
