"""Tables of pages by the runs that they rest on; `figures.py` makes the runs and writes the tables."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import degrees, isfinite, log10
from pathlib import Path
from typing import NotRequired, TypedDict

ROOT = Path(__file__).resolve().parents[2]


class Estimate(TypedDict):
    """A value with its interval, of `summary.json`."""

    value: float | None
    low: float | None
    high: float | None


class Count(TypedDict):
    """Events in flights, and the upper bound of their share."""

    events: int
    flights: int
    upper: float


class SummaryRow(TypedDict):
    """A row of the Default / Tuned table."""

    label: str
    default: Estimate
    tuned: Estimate
    default_count: NotRequired[Count]
    tuned_count: NotRequired[Count]


def number(value: float, digits: int = 3) -> str:
    """Return a number with significant digits, without an exponent."""
    if not isfinite(value) or value == 0.0:
        return f"{value:.0f}"
    return f"{value:.{max(0, digits - 1 - int(log10(abs(value)) // 1))}f}"


def estimate(entry: Estimate, scale: Callable[[float], float], digits: int) -> str:
    """Return a value with its interval in brackets, where it has one; margins of an unstable loop have no value."""
    if entry["value"] is None:
        return "unstable"
    value = number(scale(entry["value"]), digits)
    if entry["low"] is None or entry["high"] is None:
        return value
    decimals = len(value.partition(".")[2])
    low, high = (f"{scale(end):.{decimals}f}" for end in (entry["low"], entry["high"]))
    return f"{value} [{low}, {high}]" if low != high else value


def decibels(factor: float) -> float:
    """Return a factor in dB."""
    return 20.0 * log10(factor)


def same(value: float) -> float:
    """Return the value."""
    return value


@dataclass(frozen=True)
class Row:
    """A row of a table: its heading, the label of `summary.json`, a scale and digits; without a label, the gains `names`."""

    heading: str
    label: str = ""
    scale: Callable[[float], float] = same
    digits: int = 3
    names: tuple[str, ...] = ()

    def cell(self, summary: dict, which: str) -> str:
        """Return the cell of a column, "default" or "tuned"."""
        if self.names:
            values = {entry["name"]: entry[which] for entry in summary["variables"]}
            return ", ".join(number(values.get(name, 0.0)) for name in self.names)
        rows: dict[str, SummaryRow] = {entry["label"]: entry for entry in summary["table"]}
        row = rows[self.label]
        count = row.get("default_count" if which == "default" else "tuned_count")
        if count is not None:
            return f"{count['events']} of {count['flights']}: at most {number(100.0 * count['upper'], 2)} %"
        return estimate(row["default" if which == "default" else "tuned"], self.scale, self.digits)


@dataclass(frozen=True)
class Table:
    """A table of a page: `columns` are headings with a results folder and which of its gains."""

    page: str
    name: str
    columns: tuple[tuple[str, str, str], ...]
    rows: tuple[Row, ...]
    commands: tuple[str, ...]
    corner: str = ""

    def lines(self, folder: Path) -> Iterator[str]:
        """Return the lines of the table from the results below a folder."""
        yield f"| {' | '.join((self.corner, *(heading for heading, _, _ in self.columns)))} |".replace("|  |", "| |")
        yield "|---|" + "---:|" * len(self.columns)
        read = {run: json.loads((folder / "results" / run / "summary.json").read_text()) for _, run, _ in self.columns}
        for row in self.rows:
            yield f"| {' | '.join((row.heading, *(row.cell(read[run], which) for _, run, which in self.columns)))} |"


def tuned(page: str, run: str, rows: tuple[Row, ...], *commands: str, corner: str = "", last: str = "tuned") -> Table:
    """Return the table of default and tuned gains of one run."""
    return Table(page, run, (("default", run, "default"), (last, run, "tuned")), rows, commands, corner)


def accuracy(folder: Path) -> Iterator[str]:
    """Return the table of gains on vehicles that differ from the model."""
    import tuner

    yield "| vehicle against the model | phase margin [deg] | gain margin [dB] | Ms | ITAE, worst 20 % [m] | travel [1/s] |"
    yield "|---|---:|---:|---:|---:|---:|"
    spread, exact = "scenario.0.spread", 1e-6
    none = {f"{spread}.{name}": exact for name in ("mass", "inertia", "thrust", "lag")}
    corners = {f"margin.{i}.spread": True for i in range(3)}
    for name, error in (("", 0.0), *((n, s * e) for n, e in ERRORS.items() for s in (1, -1))):
        shift = {f"{spread}.{name}_shift": error} if name else {}
        study = tuner.load_study("quickstart", {**none, **corners, **shift})
        table = tuner.check_requirements(folder / "results/quickstart/gains.json", study).table
        value: dict[str, float] = table["value"].to_dict()
        cells = (
            number(degrees(value["phase_margin(spread)"])), number(decibels(value["gain_margin(spread)"])),
            number(value["ms(spread)"]), number(value["cvar80(itae.position)"]), number(value["mean(travel)"]),
        )  # fmt: skip
        yield f"| {f'{name} {100.0 * error:+.0f} %' if name else 'as the model'} | {' | '.join(cells)} |"


ERRORS = {"mass": 0.1, "inertia": 0.2, "thrust": 0.1, "lag": 0.5}
"""Relative errors of the model by the name of the spread."""


def notches(folder: Path) -> Iterator[str]:
    """Return the table of what notches on the rotors' lines leave of the noise, under default gains."""
    yield "| | `noise` [hover thrusts] | `rms.tilt` [rad] |"
    yield "|---|---:|---:|"
    for name, run in NOTCHES.items():
        table = json.loads((folder / "results" / run / "summary.json").read_text())["table"]
        value = {row["label"]: row["default"]["value"] for row in table}
        yield f"| {name} | {number(value['mean(noise)'])} | {number(value['mean(rms.tilt)'])} |"


NOTCHES = {
    "white noise alone": "white",
    "lines, no notches": "notches_0",
    "lines, `rpm_notches = 1`": "notches_1",
    "lines, `rpm_notches = 3`": "notches_3",
}
"""Results folders by what flies."""
LEVELS = "\\n".join(
    f'vibration_{i} = {{ value = {level}, unit = "rad/s", source = "assumed" }}'
    for i, level in ((1, 0.1), (2, 0.05), (3, 0.03))
)
SMALLEST = (
    "tuner run betaflight --set search.generations=1 --set search.population=8 --set scenario.0.search=2 "
    "--set scenario.0.held_out=32 --set margin=[] --set constraint=[] --set mission.held=1.0 "
    """--set 'objective=[{metric="rms.tilt"},{metric="noise"}]' """
)


def notch_run(count: int) -> str:
    """Return the run with so many notches."""
    options = "" if count == 0 else "--set controller.rpm_notch_q=5 --set controller.rpm_notch_min=100 "
    airframe = """--set 'airframe={file="{folder}/lines.toml"}'"""
    return f"{SMALLEST}{airframe} --set controller.rpm_notches={count} {options}--out results/notches_{count}"


def costs(folder: Path) -> Iterator[str]:
    """Return the table of instructions of a control step."""
    import tuner

    del folder
    yield "| attitude law | three attitude loops | whole cascade with LADRC in position |"
    yield "|---|---:|---:|"
    table = tuner.cost().table.loc["ladrc"]
    for law in ("pid", "ladrc", "hybrid", "adrc"):
        loops, step = (float(table[f"instructions_{part}"][law]) for part in ("attitude", "step"))
        yield f"| {law} | {loops:.0f} | {step:.0f} |"


def value_of_information(folder: Path) -> Iterator[str]:
    """Yield the sentences of a run on the value of better knowledge of the vehicle."""
    command = [sys.executable, "-m", "tuner", "show", "results/mine"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "200"}
    printed = subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True, text=True).stdout
    yield "```"
    yield from (line.strip() for line in printed.splitlines() if "knowing the vehicle" in line)
    yield "```"


@dataclass(frozen=True)
class Listing:
    """A table that a function works out."""

    page: str
    name: str
    lines: Callable[[Path], Iterator[str]]
    commands: tuple[str, ...] = ()


MINE = (
    "tuner identify log15 --airframe crazyflie-pybullet --out mine.toml",
    "tuner run mine_study.toml --out results/mine",
)
LOST = Row("lost flights, with the 95 % bound", "mean(failure)")
QUICKSTART = "tuner run quickstart"
STEPS = (
    Row("position error (ITAE), mean of the worst 20 % of the flights [m]", "cvar80(itae.position)"),
    Row("rotor travel [1/s]", "mean(travel)"),
    Row("phase margin, worst loop at hover and in the wind [deg]", "phase_margin", degrees),
    Row("gain margin, at least 6 [dB]", "gain_margin", decibels),
    Row("Ms, at most 2", "ms"),
)
TABLES: tuple[Table | Listing, ...] = (
    tuned(
        "README.md", "quickstart",
        (
            Row("position error (ITAE), mean of the worst 20 % of the flights [m]", "cvar80(itae.position)"),
            Row("rotor travel [1/s]", "mean(travel)"),
            Row("phase margin, worst loop at hover and in the wind, at least 35 [deg]", "phase_margin", degrees),
            LOST,
        ), QUICKSTART, last="tuned gains",
    ),
    Table(
        "docs/how_to/infeasible.md", "m45",
        (("35 deg", "quickstart", "tuned"), ("45 deg", "m45", "tuned"), ("50 deg", "m50", "tuned")), STEPS,
        (QUICKSTART, *(f"{QUICKSTART} --set margin.0.min={angle} --out results/m{angle}" for angle in (45, 50))),
        "tuned for at least",
    ),
    Table(
        "docs/how_to/period_and_delay.md", "p1",
        (("1 ms", "p1", "tuned"), ("2 ms", "p2", "tuned"), ("4 ms", "quickstart", "tuned")), STEPS,
        (QUICKSTART, *(f"{QUICKSTART} --set controller.control_period=0.00{ms} --out results/p{ms}" for ms in (1, 2))),
        "tuned at a period of",
    ),
    Listing("docs/how_to/model_accuracy.md", "accuracy", accuracy, (QUICKSTART,)),
    Listing("docs/how_to/processor_cost.md", "costs", costs),
    Listing(
        "docs/how_to/noise_and_battery.md", "notches", notches,
        (
            f"sed '/^mass = /i {LEVELS}' racer5.toml > lines.toml",
            f"{SMALLEST}--out results/white",
            *map(notch_run, (0, 1, 3)),
        ),
    ),
    tuned(
        "docs/from_file_and_back.md", "my_px4",
        (
            Row("position error in gusts, mean of the worst 20 % of the flights [m]", "cvar80(rms.position)@gusts"),
            Row("attitude error in small steps, the same [rad]", "cvar80(rms.tilt)@small steps"),
            Row("rotor travel [1/s]", "mean(travel)"),
            Row("phase margin, at least 35 [deg]", "phase_margin", degrees),
            Row("gain margin, at least 6 [dB]", "gain_margin", decibels),
            LOST,
        ),
        "tuner import quad.params --from px4 --airframe f450 --set loops=own --out vehicle.json",
        "tuner new my_px4 --from px4",
        "tuner run my_px4.toml --set controller.default=vehicle.json",
        last="tuned",
    ),
    tuned(
        "docs/examples/dc_motor.md", "my_motor",
        (
            Row("kp, ki, kd", names=("angle.kp", "angle.ki", "angle.kd")),
            Row("time-weighted mean of the error [rad]", "mean(itae.angle)"),
            Row("travel [1/s]", "mean(travel)"),
            Row("overshoot [%]", "mean(overshoot.angle)", digits=2),
            Row("Ms", "ms"),
        ), "tuner new my_motor --from dc_motor", "tuner run my_motor.toml",
    ),
    Table(
        "docs/examples/dead_time.md", "dead_time",
        (("default PID", "dead_time", "default"), ("PID", "dead_time", "tuned"), ("PI", "dead_time_pi", "tuned")),
        (
            Row("kp, ki, kd", names=("level.kp", "level.ki", "level.kd")),
            Row("IAE after the load [s]", "mean(iae.level)@load", digits=4),
            Row("IAE after the shift [s]", "mean(iae.level)@shift", digits=4),
            Row("Ms", "ms"),
        ),
        ("tuner run dead_time", "tuner run dead_time --set gains.level.kd=0 --out results/dead_time_pi"),
        "on 64 processes each, gain and lag within 10 %",
    ),
    tuned(
        "docs/examples/fixed_wing.md", "fixed_wing",
        (
            Row("kp, ki, kd", names=("pitch.kp", "pitch.ki", "pitch.kd")),
            Row("rms of the pitch [rad]", "mean(rms.pitch)", digits=4),
            Row("travel of the elevator [1/s]", "mean(travel)"),
            Row("phase margin [deg]", "phase_margin", degrees, 2),
            Row("gain margin [dB]", "gain_margin", decibels),
        ), "tuner run fixed_wing", corner="on 128 flights", last="recommended",
    ),
    tuned(
        "docs/examples/two_masses.md", "two_masses",
        (
            Row("omega_c, zeta, omega_o", names=("position.omega_c", "position.zeta", "position.omega_o")),
            Row("worst settling, at most 120 [s]", "worst(recovery.position)"),
            Row("travel [1/s]", "mean(travel)"),
        ), "tuner run two_masses", corner="on 1,024 springs", last="recommended",
    ),
    tuned(
        "docs/examples/own_law.md", "my_law",
        (
            Row("attitude kp, kd; position omega_c", names=("attitude.kp", "attitude.kd", "position.omega_c")),
            Row("mean error of the position [m]", "mean(mae.position)", digits=2),
            Row("sway of roll and pitch [rad]", "mean(sway.tilt)"),
        ),
        "tuner new my_law --from own_law", "tuner run my_law.toml",
        corner="on 64 flights that decided nothing", last="recommended",
    ),
    tuned(
        "docs/log_to_gains.md", "mine",
        (
            Row("tilt error, mean of the worst 20 % of the flights [rad]", "cvar80(rms.tilt)"),
            Row("noise of the commands", "mean(noise)"),
            Row("phase margin at the ends of the set, at least 35 [deg]", "phase_margin(tilt, spread)", degrees),
            Row("Ms at the ends of the set, at most 2", "ms(tilt, spread)"),
            LOST,
        ),
        *MINE, corner="on 128 flights, each with a vehicle of the set",
    ),
    Listing("docs/log_to_gains.md", "worth", value_of_information, MINE),
    tuned(
        "docs/examples/iron.md", "iron",
        (
            Row("kp [W/K], ki [W/(K s)], kd [W s/K]", names=("tip.kp", "tip.ki", "tip.kd")),
            Row("ITAE of the tip [K]", "mean(itae.tip)"),
            Row("travel of the power, in half ranges a second", "mean(travel)"),
            Row("overshoot [%], at most 5", "mean(overshoot.tip)", digits=2),
            Row("Ms, at most 1.7", "ms"),
        ),
        "pythonfmu build -f studies/from_fmu/iron.py -d studies/from_fmu",
        "tuner run studies/from_fmu/iron.toml",
        corner="on 64 irons each, capacities and conduction within 20 %", last="recommended",
    ),
)  # fmt: skip
