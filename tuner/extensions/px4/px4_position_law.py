"""PX4's position loops: P on the position around a PID on the velocity, D on the measured acceleration.

    v_sp = position_p (r - y) + r',    b0 u = authority (r'' + p (v_sp - y') + I - d a),    a = LP(y')'
    I' = i (v_sp - y'),  |I| <= i_limit

Use it around `px4`, for a vehicle that flies PX4 in position mode.

The integral does not grow further while a limit takes acceleration away, as along z in PX4; along x and y PX4 hands it 2/p of
what is taken away instead, which differs only while the tilt is limited. authority: what the vehicle accelerates by for 1 m/s2
of PX4's, which counts with g = 9.80665 m/s2 and its hover thrust. PX4 1.16, src/modules/mc_pos_control/PositionControl and
MulticopterPositionControl.
"""

from collections.abc import Mapping
from typing import NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.filters import stage_share, step_stage
from plant.laws.law import Blocks, GainInfo, Law, Span
from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.autopilots.law_parts import limited, outward_stopped

SOURCE = "PX4 1.16, src/modules/mc_pos_control/PositionControl and parameter metadata"
GRAVITY = 9.80665


class Gains(NamedTuple):
    """position_p [1/s]; p [1/s], i [1/s2], d [1]: acceleration per velocity, position and acceleration; i_limit [y/s2]; d_cutoff
    [Hz], 0 for none; authority [1].
    """

    position_p: float
    p: float
    i: float
    d: float
    i_limit: float
    d_cutoff: float
    authority: float


class Constants(NamedTuple):
    """The gains, with the filter as the share of a new sample."""

    position_p: float
    p: float
    i: float
    d: float
    i_limit: float
    smoothing: float
    authority: float


class Memory(NamedTuple):
    """integral [y/s2]; previous: last rate [y/s]; acceleration: filtered [y/s2]."""

    integral: float
    previous: float
    acceleration: float


def prepare(gains: Gains, h: float) -> Constants:
    """Sample the filter."""
    smoothing = stage_share(gains.d_cutoff, h)
    return Constants(gains.position_p, gains.p, gains.i, gains.d, gains.i_limit, smoothing, gains.authority)


def start(constants: Constants, measured: Measured, held: float) -> Memory:
    """Steady: the integral holds the plant."""
    return Memory(held / constants.authority, measured.rate, 0.0)


def step(
    memory: Memory,
    constants: Constants,
    channel: Channel,
    setpoint: Setpoint,
    measured: Measured,
    applied: Applied,
    h: float,
) -> tuple[float, Memory]:
    """One control period; the integral takes effect one period after it is formed."""
    acceleration = step_stage(memory.acceleration, (measured.rate - memory.previous) / h, constants.smoothing)
    error = constants.position_p * (setpoint.value - measured.value) + setpoint.rate - measured.rate
    demand = setpoint.acceleration + constants.p * error + memory.integral - constants.d * acceleration
    integrated = outward_stopped(error, channel.b0 * applied.excess, constants.authority)
    integral = limited(memory.integral + h * constants.i * integrated, constants)
    return constants.authority * demand / channel.b0, Memory(integral, measured.rate, acceleration)


def on_airframe(vehicle: Vehicle) -> Mapping[str, Mapping[str, float]]:
    """Return the acceleration for 1 m/s2 of PX4's.

    Thrust is linearised (THR_MDL_FAC), and its share at hover is known.
    """
    return {"authority": dict.fromkeys(("x", "y", "z"), vehicle.gravity / GRAVITY)}


LAW = Law(
    name="px4_position",
    title="PX4's position loops: P around a velocity PID",
    blocks=Blocks("position P, velocity PID", measured="low-pass of D"),
    source=SOURCE,
    Gains=Gains,
    Constants=Constants,
    Memory=Memory,
    prepare=prepare,
    start=start,
    step=step,
    gains=(
        GainInfo(
            "position_p", "MPC_*_P", "s^-1", Span(4.0, 1.0, 12.0), Span(0.95, 0.1, 2.0), "log", SOURCE,
            "velocity asked for per position error",
        ),
        GainInfo(
            "p", "MPC_*_VEL_P_ACC", "s^-1", Span(8.0, 2.0, 50.0), Span(1.8, 1.2, 5.0), "log", SOURCE,
            "acceleration per velocity error", of_output=True,
        ),
        GainInfo(
            "i", "MPC_*_VEL_I_ACC", "s^-2", Span(8.0, 1.0, 100.0), Span(0.4, 0.02, 4.0), "log", SOURCE,
            "acceleration per integrated velocity error", term="integral term", of_output=True,
        ),
        GainInfo(
            "d", "MPC_*_VEL_D_ACC", "1", Span(0.2, 0.0, 1.0), Span(0.2, 0.0, 2.0), "linear", SOURCE,
            "acceleration per measured acceleration", term="derivative term", of_output=True,
        ),
        GainInfo(
            "i_limit", "i_limit", "{y} s^-2", Span(60.0, 5.0, 200.0), Span(9.80665, 1.0, 20.0), "log", SOURCE,
            "limit of the integral, which PX4 has at 9.80665 m/s2",
        ),
        GainInfo(
            "d_cutoff", "MPC_VELD_LP", "Hz", Span(30.0, 0.0, 100.0), Span(5.0, 0.0, 20.0), "linear", SOURCE,
            "cut-off of the first-order low-pass on the acceleration, 0 for none",
        ),
        GainInfo(
            "authority", "authority", "1", Span(1.0, 0.5, 2.0), Span(1.0, 0.5, 2.0), "log", SOURCE,
            "acceleration of the vehicle for that asked for", exclusive=True, airframe=True,
        ),
    ),
    sampling="D: backward difference, first-order low-pass by backward Euler; integral: forward Euler, in force one period "
    "after it is formed",
    promises=frozenset({"rejects"}),
    limits=(limited,),
    on_airframe=on_airframe,
    shared={**dict.fromkeys(("position_p", "p", "i", "d", "i_limit"), ("x", "y")), "d_cutoff": ("x", "y", "z")},
    axes={
        "z": {
            "position_p": Span(1.0, 0.1, 1.5),
            "p": Span(4.0, 2.0, 15.0),
            "i": Span(2.0, 0.2, 3.0),
            "d": Span(0.0, 0.0, 2.0),
        }
    },
)  # fmt: skip
