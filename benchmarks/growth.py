"""`python -m benchmarks.growth`: 1 to 1000 times the flights, 16 to 65 536 scenarios, flights 100 times as long.

Every point is a process of its own, so its peak memory is its own. Time is processor time, drawing and
judging included; memory is the peak of the process, beside what it was before. `python -m benchmarks.growth --point
candidates,scenarios,seconds` measures one point and prints it as JSON.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

import numpy as np

from benchmarks.measuring import RESULTS, machine, peak_memory, write_json

ROOT = Path(__file__).resolve().parents[1]
# 65 536 flights of 0.2 s take half a minute: most of it is drawing wind and noise.
DURATION, SHORT = 1.0, 0.2


class Point(NamedTuple):
    """Candidates that fly through scenarios of so many seconds."""

    candidates: int
    scenarios: int
    seconds: float


SERIES: dict[str, list[Point]] = {
    "flights (candidates)": [Point(n, 16, DURATION) for n in (1, 10, 100, 1000)],
    "scenarios": [Point(1, n, SHORT) for n in (16, 256, 4096, 65_536)],
    "flight length [s]": [Point(1, 64, seconds) for seconds in (1.0, 10.0, 100.0)],
}
FIELDS = {
    "flights (candidates)": "candidates",
    "scenarios": "scenarios",
    "flight length [s]": "seconds",
}


def measure(point: Point) -> dict[str, Any]:
    """Fly a point through `Problem`, as a study does (scenarios in chunks), and return times and peak memory."""
    from objectives.decisions import DecisionSpace
    from objectives.flown_system import FlightBatch
    from objectives.metrics import parse
    from objectives.problem import Objective, Problem
    from objectives.risk import Risk
    from plant.air.air import AirSpec
    from plant.quadrotor.gains import default_row
    from plant.quadrotor.scenarios import SEARCH, ScenarioSpec, sample_scenarios
    from plant.references.steps import Steps

    system = system_of_course()
    spec = ScenarioSpec("growth", point.seconds, Steps(x=1.0, time=0.1), AirSpec(intensity="moderate", mean_wind=False))
    row = np.array(default_row(system.cascade))
    objectives = (Objective(parse("itae.position"), Risk("mean")),)
    problem = Problem(system, DecisionSpace((), (), tuple(row)), objectives, (), 1, threads=1)
    batch = FlightBatch(spec, SEARCH, point.scenarios)
    problem.evaluate_gains(row[None], (FlightBatch(spec, "warm-up", 16),))
    base, begin = peak_memory(), process_time()
    problem.evaluate_gains(np.tile(row, (point.candidates, 1)), (batch,))
    whole = process_time() - begin
    few, begin = min(point.scenarios, 16), process_time()
    sample_scenarios(spec, system.vehicle, system.timing, 1, SEARCH, range(few))
    drawn = (process_time() - begin) / few * point.scenarios
    flights = point.candidates * point.scenarios
    return {
        **point._asdict(),
        "flights": flights,
        "seconds_each": whole / flights,
        "drawing_share": min(drawn / whole, 1.0),
        "base_mb": base,
        "peak_mb": peak_memory(),
    }


def system_of_course() -> Any:
    """Return the system that flies the course of `benchmarks.course`."""
    from benchmarks.course import LIMITS, TIMING, loop
    from objectives.system import System
    from plant.quadrotor.airframes import load
    from plant.quadrotor.nominal import ControlOptions, nominal

    vehicle = load("hummingbird").vehicle
    return System(vehicle, loop().cascade, nominal(vehicle, ControlOptions(), TIMING.control_period), LIMITS, TIMING)


def alone(point: Point) -> dict[str, Any]:
    """Measure a point in a process of its own."""
    text = ",".join(map(str, point))
    command = [sys.executable, "-m", "benchmarks.growth", "--point", text]
    return json.loads(
        subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout.splitlines()[-1]
    )


def run() -> dict[str, Any]:
    """Measure all series."""
    return {
        "machine": machine(),
        "series": {name: [alone(point) for point in points] for name, points in SERIES.items()},
    }


def draw_figure(document: dict[str, Any], file: Path) -> None:
    """Draw time per simulated second and peak memory over each series."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(2, 3, figsize=(9.0, 5.0), layout="constrained", sharey="row")
    for column, (name, entries) in enumerate(document["series"].items()):
        x = [entry[FIELDS[name]] for entry in entries]
        time = [1e6 * entry["seconds_each"] / entry["seconds"] for entry in entries]
        above, below = axes[0, column], axes[1, column]
        above.loglog(x, time, "o-", color="#0b6e99")
        below.loglog(x, [entry["peak_mb"] for entry in entries], "o-", color="#0b6e99", label="peak")
        below.loglog(x, [entry["base_mb"] for entry in entries], "--", color="#888888", label="before flying")
        below.set_xlabel(name)
        for axis in (above, below):
            axis.grid(True, which="major", color="#dddddd")
    axes[0, 0].set_ylabel("processor time per flight and\nsimulated second [µs/s]")
    axes[1, 0].set_ylabel("memory [MB]")
    axes[1, 0].legend(frameon=False, fontsize=8)
    figure.suptitle("What a flight costs as studies grow")
    figure.savefig(file, dpi=130)
    pyplot.close(figure)


def main() -> None:
    """Write growth.json and growth.png, or print one point."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--point", help="candidates,scenarios,seconds")
    chosen = parser.parse_args()
    if chosen.point:
        candidates, scenarios, seconds = chosen.point.split(",")
        print(json.dumps(measure(Point(int(candidates), int(scenarios), float(seconds)))))
        return
    document = run()
    write_json(RESULTS / "growth.json", document)
    draw_figure(document, RESULTS / "growth.png")
    for name, entries in document["series"].items():
        for entry in entries:
            print(name, entry[FIELDS[name]], f"{1e6 * entry['seconds_each']:.0f} us", f"{entry['peak_mb']:.0f} MB")


if __name__ == "__main__":
    main()
