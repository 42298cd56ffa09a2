"""Make the runs that pages report and write their tables: python docs/generator/figures.py [--check] [RUN ...]

A table is between `<!-- figures NAME -->` and `<!-- end -->`. Runs named on the command line are made alone. With --check pages
stay as they are, and numbers that differ by more than the tolerance end it with exit code 1.
"""

import argparse
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import degrees, isfinite, log10
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NotRequired, TypedDict

ROOT = Path(__file__).resolve().parents[2]
TOLERANCE = 0.05
"""Largest relative difference of a number; searches of another processor may end at a neighbor of the same front."""
NUMBER = re.compile(r"-?\d+(?:,\d{3})*(?:\.\d+)?")


class Estimate(TypedDict):
    """A value with its interval, of `summary.json`."""

    value: float
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
    """Return a value with its interval in brackets, where it has one."""
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

    yield "| error of the model | phase margin [deg] | gain margin [dB] | Ms | ITAE, worst 20 % [m] | travel [1/s] |"
    yield "|---|---:|---:|---:|---:|---:|"
    spread, exact = "scenario.0.spread", 1e-6
    none = {f"{spread}.{name}": exact for name in ("mass", "inertia", "thrust", "lag")}
    corners = {f"margin.{i}.spread": True for i in range(3)}
    for name, error in (("", 0.0), *((n, s * e) for n, e in ERRORS.items() for s in (1, -1))):
        shift = {f"{spread}.{name}_shift": error} if name else {}
        study = tuner.load_study("quickstart", {**none, **corners, **shift})
        table = tuner.judge(folder / "results/quickstart/gains.json", study).table
        value: dict[str, float] = table["value"].to_dict()
        cells = (
            number(degrees(value["phase_margin(spread)"])), number(decibels(value["gain_margin(spread)"])),
            number(value["ms(spread)"]), number(value["cvar80(itae.position)"]), number(value["mean(travel)"]),
        )  # fmt: skip
        yield f"| {f'{name} {error:+.0%}' if name else 'none'} | {' | '.join(cells)} |"


ERRORS = {"mass": 0.1, "inertia": 0.2, "thrust": 0.1, "lag": 0.5}
"""Relative errors of the model by the name of the spread."""


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


def worth(folder: Path) -> Iterator[str]:
    """Return what a run says of the value of better knowledge of the vehicle."""
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
    Listing("docs/exports.md", "costs", costs),
    tuned(
        "docs/from_file_and_back.md", "my_px4",
        (
            Row("position error, mean of the worst 20 % of the flights [m]", "cvar80(rms.position)"),
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
    Listing("docs/log_to_gains.md", "worth", worth, MINE),
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
FILES = {"log15": "tests/tuner/logs/crazyflie/log15_70_to_85", "studies": "studies"}
"""Files of the repository that commands name."""


def make(table: Table | Listing, folder: Path) -> None:
    """Make the runs of a table in a folder; those that are there already stay."""
    for name, source in FILES.items():
        if not (folder / name).exists():
            (folder / name).symlink_to(ROOT / source)
    write_files(table.page, folder)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = folder / ".done"
    made = done.read_text().splitlines() if done.exists() else []
    for command in table.commands:
        if command not in made:
            environment = {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}
            subprocess.run(command, shell=True, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
            with done.open("a") as file:
                file.write(f"{command}\n")


def write_files(page: str, folder: Path) -> None:
    """Write the files that a page shows and says to be there from the start."""
    text = (ROOT / page).read_text(encoding="utf-8")
    for name, content in re.findall(r"^`([\w.]+)`[^\n`]*:\n\n```\w+\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        (folder / name).write_text(content, encoding="utf-8")


def marked(name: str) -> re.Pattern[str]:
    """Return the pattern of a table between its marks."""
    return re.compile(rf"(?<=<!-- figures {name} -->\n).*?(?=<!-- end -->)", re.DOTALL)


def differs(before: str, after: str) -> bool:
    """Return True where two tables differ in words, or in a number by more than the tolerance."""
    if NUMBER.sub("#", before) != NUMBER.sub("#", after):
        return True
    pairs = zip(*([float(x.replace(",", "")) for x in NUMBER.findall(text)] for text in (before, after)), strict=True)
    return any(abs(a - b) > TOLERANCE * max(abs(a), abs(b)) for a, b in pairs)


def update(table: Table | Listing, folder: Path, check: bool) -> bool:
    """Write a table into its page, or only compare; return True where it differs."""
    page = ROOT / table.page
    text = page.read_text(encoding="utf-8")
    match = marked(table.name).search(text)
    if match is None:
        raise SystemExit(f"{table.page} has no marks for {table.name}")
    after = "\n" + "\n".join(table.lines(folder)) + "\n\n"
    if not check:
        page.write_text(text[: match.start()] + after + text[match.end() :], encoding="utf-8")
    return differs(match[0], after)


def main() -> int:
    """Make the runs, write or compare the tables; return the exit status."""
    parser = argparse.ArgumentParser(description="Write the tables of pages from runs.")
    parser.add_argument("names", nargs="*", metavar="RUN", help=f"of {', '.join(table.name for table in TABLES)}")
    parser.add_argument("--check", action="store_true", help="compare, and write nothing")
    parser.add_argument("--folder", type=Path, help="where runs are made, or are already")
    given = parser.parse_args()
    with TemporaryDirectory() as temporary:
        folder = (given.folder or Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        status = 0
        for table in TABLES:
            if not given.names or table.name in given.names:
                make(table, folder)
                other = update(table, folder, given.check)
                print(f"{table.page}: {table.name} {'differs' if other else 'holds'}", flush=True)
                status |= given.check and other
    return int(status)


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    sys.exit(main())
