"""The hybrid law with the printed estimate of f: f_hat = z2 next to d_hat = z3.

    e = y - r,   S = e' + lambda e,   sat(x) = max(-1, min(1, x))
    b0 u = -z2 - z3 + r'' - lambda e' - k1 |S|^(1/2) sat(S/delta) - k2 S
    z1' = z2 + 3 wo (y - z1),   z2' = z3 + b0 u + 3 wo^2 (y - z1),   z3' = wo^3 (y - z1)

Use it to test the paper's claims alone.

Wu et al., Appl. Sci. 2025, 15(9), 5124, section 2.3.3. z2 estimates the rate of y (rad/s), not an acceleration, and z3
estimates f + d already; the sum adds quantities of different units. Its effect is rate feedback with a gain of 1 1/s:
a little damping, and an error on every ramp. At the rate v it holds S = lambda e with k1 |S|^(1/2) sat(S/delta) + k2 S = -v.
"""

from dataclasses import replace

from plant.laws import hybrid
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.continuous import ContinuousForm
from plant.laws.hybrid import Constants, Gains, linear_part, sliding_term
from plant.laws.law import Blocks
from plant.laws.observer import Observer, observe, triple_pole
from plant.laws.surface import surface


def step(
    memory: Observer,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, Observer]:
    """One control period."""
    z = observe(memory, constants.observer, measured.value, channel.b0 * applied.effect, h)
    e = surface(constants.lambda_, channel, setpoint, measured, z.z2)
    demand = setpoint.acceleration - constants.lambda_ * e.error_rate - sliding_term(e.s, constants)
    return (demand - z.z2 - z.z3) / channel.b0, z


def continuous(gains: Gains, from_observer: bool) -> ContinuousForm:
    """Return the continuous form without the power-rate term."""
    return linear_part(gains, from_observer, triple_pole(gains.omega_o), estimate=1.0)


LAW = replace(
    hybrid.LAW,
    name="hybrid_paper_f_hat",
    title="A-ST-SMC with z2 taken for an estimate of f, as printed",
    blocks=Blocks("surface S, power rate, minus z2 and z3", measured="linear ESO", takes_command=True),
    step=step,
    promises=frozenset({"rejects"}),
    family="",
    continuous=continuous,
)
