"""The hybrid law as printed: neither reference acceleration nor equivalent control.

    e = y - r,   S = e' + lambda e,   sat(x) = max(-1, min(1, x))
    b0 u = -z3 - k1 |S|^(1/2) sat(S/delta) - k2 S
    z1' = z2 + 3 wo (y - z1),   z2' = z3 + b0 u + 3 wo^2 (y - z1),   z3' = wo^3 (y - z1)

Use it to test the paper's claims alone.

Wu et al., Appl. Sci. 2025, 15(9), 5124, section 2.3.3, with the estimate of f + d read as z3 and the observer's poles in one
place, as in `hybrid`; to be compared with it. The minus signs are those without which the loop would be unstable: the
surface dynamics are first printed with the switching terms positive (S repelled), then negative. The terms r'' - lambda e'
that make S' = -k1 |S|^(1/2) sat(S/delta) - k2 S hold are left out there, by assuming what is to be proved. The remainder is a PD
law with kp = lambda k and kd = k, k as in `hybrid`: s^2 + k s + lambda k = 0 in place of poles at -k and -lambda, so underdamped
where lambda > k/4; and a moving reference is followed with the error that a missing r'' leaves.
"""

from dataclasses import replace

from plant.laws import hybrid
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.continuous import ContinuousForm
from plant.laws.hybrid import Constants, Gains, linear_part, sliding_term
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
    return (-sliding_term(e.s, constants) - z.z3) / channel.b0, z


def continuous(gains: Gains, from_observer: bool) -> ContinuousForm:
    """Return the continuous form without the power-rate term."""
    return linear_part(gains, from_observer, triple_pole(gains.omega_o), equivalent=0.0)


LAW = replace(
    hybrid.LAW,
    name="hybrid_literal",
    title="A-ST-SMC as printed: without reference acceleration and equivalent control",
    step=step,
    promises=frozenset({"rejects"}),
    family="",
    continuous=continuous,
)
