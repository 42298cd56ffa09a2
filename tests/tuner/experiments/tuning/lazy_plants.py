"""Eight studies of plants of one's own whose author forgot a channel or asks for little: gains at their low end win each of them.

Each is a plant in a few lines, its loops, its flights and what is asked for. `forgotten`: the channel and the scenario that no
objective judges, None where an objective names them and still rewards what does nothing.
"""

from dataclasses import dataclass
from pathlib import Path

PLANT = """from typing import Annotated, NamedTuple


class State(NamedTuple):
{state}


class Input(NamedTuple):
{input}


class Disturbance(NamedTuple):
{disturbance}


class Parameters(NamedTuple):
    scale: Annotated[float, "1"] = 1.0


class Output(NamedTuple):
{output}


def derivative(x, u, d, p):
    return State({derivative})


def output(x, u, d, p):
    return Output({shown})
"""
GAINS = """"{0}.kp" = {{ low = {1}, high = {2}, default = {3} }}
"{0}.ki" = {4}
"{0}.kd" = {5}
"{0}.t_f" = {6}
"""


@dataclass(frozen=True)
class Lazy:
    """A lazy study. equations: fields and texts of the plant's file; tables: TOML behind title, seed and [plant]."""

    name: str
    period: float
    equations: dict[str, str]
    tables: str
    forgotten: tuple[str, str] | None

    def written(self, folder: Path) -> Path:
        """Write plant and study and return the path of the study."""
        fields = {
            key: "\n".join(f'    {name}: Annotated[float, "1"]' for name in self.equations[key].split())
            for key in ("state", "input", "disturbance", "output")
        }
        (folder / f"{self.name}.py").write_text(PLANT.format(**{**self.equations, **fields}), encoding="utf-8")
        head = f'title = "{self.name}"\nseed = 3\n[plant]\nfile = "{self.name}.py"\ncontrol_period = {self.period}\n'
        tail = '[search]\nalgorithm = "nsga2"\npopulation = 12\ngenerations = 4\n'
        path = folder / f"{self.name}.toml"
        path.write_text(head + self.tables + tail, encoding="utf-8")
        return path


def channel(name: str, to: str, limit: float, extra: str = "") -> str:
    """Return the table of a channel under PID."""
    return f'[[channel]]\nname = "{name}"\nlaw = "pid"\noutput = "{name}"\nto = "{to}"\nlost_beyond = {limit}\n{extra}'


def actuator(name: str, size: float, extra: str = "") -> str:
    """Return the table of an input."""
    return f'[[actuator]]\nname = "{name}"\nlow = {-size}\nhigh = {size}\n{extra}'


def scenario(name: str, duration: float, content: str) -> str:
    """Return the table of a scenario of few flights."""
    return f'[[scenario]]\nname = "{name}"\nduration = {duration}\nsearch = 3\nheld_out = 8\nspread.scale = 0.1\n{content}\n'


def objectives(*metrics: str, at: str = "") -> str:
    """Return the tables of objectives, all of one scenario where one is named."""
    where = f'scenario = "{at}"\n' if at else ""
    return "".join(f'[[objective]]\nmetric = "{metric}"\n{where}' for metric in metrics)


STUDIES = (
    Lazy(
        "gimbal", 0.01,
        {
            "state": "pan pan_rate tilt tilt_rate", "input": "pan_torque tilt_torque", "disturbance": "wind", "output": "pan tilt",
            "derivative": "x.pan_rate, 100.0 * p.scale * u.pan_torque - 2.0 * x.pan_rate, x.tilt_rate, "
            "200.0 * (u.tilt_torque - 0.2 * u.pan_torque + d.wind) - 2.0 * x.tilt_rate",
            "shown": "x.pan, x.tilt",
        },
        actuator("pan_torque", 1.0) + actuator("tilt_torque", 1.0)
        + channel("pan", "pan_torque", 3.0) + channel("tilt", "tilt_torque", 3.0)
        + "[gains]\n" + GAINS.format("pan", 0.001, 4.0, 1.0, 0.1, 0.15, 0.02)
        + GAINS.format("tilt", 0.01, 2.0, 0.5, 0.1, 0.08, 0.02)
        + scenario("wind", 2.0, 'disturbance.wind = { kind = "coloured", rms = 0.05, correlation_time = 0.2 }')
        + scenario("slew", 2.0, 'reference.pan = { kind = "step", size = 0.5 }')
        + objectives("rms.tilt", "travel", at="wind"),
        ("pan", "slew"),
    ),
    Lazy(
        "motor", 0.005,
        {
            "state": "angle rate", "input": "volt", "disturbance": "torque", "output": "angle",
            "derivative": "x.rate, 50.0 * p.scale * (u.volt + d.torque) - 10.0 * x.rate", "shown": "x.angle",
        },
        actuator("volt", 12.0) + channel("angle", "volt", 10.0)
        + "[gains]\n" + GAINS.format("angle", 0.0001, 20.0, 5.0, 0.0, 0.2, 0.01)
        + scenario("turn", 1.0, 'reference.angle = { kind = "step", size = 1.0 }') + objectives("travel"),
        ("angle", "turn"),
    ),
    Lazy(
        "tank", 1.0,
        {
            "state": "level", "input": "valve", "disturbance": "draw", "output": "level",
            "derivative": "(p.scale * u.valve - x.level - d.draw) / 60.0", "shown": "x.level",
        },
        actuator("valve", 5.0, "delay = 12.0\n") + channel("level", "valve", 5.0)
        + "[gains]\n" + GAINS.format("level", 0.0001, 3.0, 1.5, 0.0, 0.0, 2.0)
        + scenario("fill", 400.0, 'reference.level = { kind = "step", size = 1.0 }') + objectives("effort"),
        ("level", "fill"),
    ),
    Lazy(
        "two_carts", 0.05,
        {
            "state": "first second first_speed second_speed", "input": "force", "disturbance": "push", "output": "second",
            "derivative": "x.first_speed, x.second_speed, u.force + x.second - x.first - 0.1 * x.first_speed, "
            "d.push + p.scale * (x.first - x.second) - 0.1 * x.second_speed",
            "shown": "x.second",
        },
        actuator("force", 2.0) + channel("second", "force", 50.0)
        + "[gains]\n" + GAINS.format("second", 0.0001, 0.2, 0.05, 0.0, 0.3, 0.1)
        + scenario("push", 60.0, 'disturbance.push = { kind = "step", size = 10.0, until = 0.1 }')
        + objectives("travel", "effort"),
        ("second", "push"),
    ),
    Lazy(
        "cart", 0.02,
        {
            "state": "place speed", "input": "force", "disturbance": "slope", "output": "place",
            "derivative": "x.speed, p.scale * u.force + d.slope - 0.2 * x.speed", "shown": "x.place",
        },
        actuator("force", 4.0) + channel("place", "force", 20.0)
        + "[gains]\n" + GAINS.format("place", 0.0001, 4.0, 2.0, 0.0, 2.0, 0.05)
        + scenario("move", 8.0, 'reference.place = { kind = "step", size = 1.0 }') + objectives("overshoot.place", "travel"),
        None,
    ),
    Lazy(
        "ovens", 0.5,
        {
            "state": "near far", "input": "near_power far_power", "disturbance": "door", "output": "near far",
            "derivative": "(p.scale * u.near_power - x.near) / 20.0, "
            "(u.far_power + 0.3 * x.near - x.far - d.door) / 30.0",
            "shown": "x.near, x.far",
        },
        actuator("near_power", 10.0) + actuator("far_power", 10.0)
        + channel("near", "near_power", 10.0) + channel("far", "far_power", 10.0)
        + "[gains]\n" + GAINS.format("near", 0.01, 8.0, 4.0, 0.1, 0.0, 1.0)
        + GAINS.format("far", 0.0001, 8.0, 4.0, 0.0, 0.0, 1.0)
        + scenario(
            "heat", 120.0,
            'reference.near = { kind = "step", size = 1.0 }\ndisturbance.door = { kind = "step", size = 1.0, time = 40.0 }',
        )
        + objectives("iae.near", "travel"),
        ("far", "heat"),
    ),
    Lazy(
        "cascade", 0.01,
        {
            "state": "angle rate", "input": "torque", "disturbance": "load", "output": "angle rate",
            "derivative": "x.rate, p.scale * u.torque + d.load - 0.5 * x.rate", "shown": "x.angle, x.rate",
        },
        actuator("torque", 10.0) + channel("angle", "rate", 5.0, "every = 2\n") + channel("rate", "torque", 20.0)
        + "[gains]\n" + GAINS.format("angle", 0.0001, 4.0, 2.0, 0.0, 0.0, 0.02)
        + GAINS.format("rate", 1.0, 20.0, 8.0, 0.0, 0.0, 0.02)
        + scenario("turn", 4.0, 'reference.angle = { kind = "step", size = 1.0 }') + objectives("rms.rate", "travel"),
        ("angle", "turn"),
    ),
    Lazy(
        "ship", 0.5,
        {
            "state": "heading rate", "input": "rudder", "disturbance": "waves", "output": "heading",
            "derivative": "x.rate, (0.2 * p.scale * u.rudder + d.waves - x.rate) / 10.0", "shown": "x.heading",
        },
        actuator("rudder", 0.6) + channel("heading", "rudder", 3.0)
        + "[gains]\n" + GAINS.format("heading", 0.0001, 3.0, 1.0, 0.0, 0.0, 1.0)
        + scenario("weave", 400.0, 'reference.heading = { kind = "sine", size = 0.2, frequency = 0.005 }')
        + objectives("command_peak"),
        ("heading", "weave"),
    ),
)  # fmt: skip
