"""Verdicts of `tuner judge` against the firmware's own flights, for pairs of random gains.

    python -m benchmarks.opinions --firmware px4 --binary PX4-Autopilot --pairs 30 --json
    python -m benchmarks.opinions --firmware px4 --factors

Gains are drawn around the defaults of the firmware's law, those of a pair apart by one of three sizes. Both files of a pair are
exported and judged as a user would, and fly in the firmware flights that the judge flew in the model: the same vehicles, air
and noise. The product's function compares the firmware's own flights, too. A pair agrees where both comparisons have one word;
a false alarm is a refusal, "worse" or "do not fly", of gains that the firmware flies no worse in any metric, a strict one a
refusal of gains that it does not fly worse on the whole: mixed ones count.

With `--factors` the judge alone compares P, I and D of roll and pitch times each of seven factors with the defaults; below 1
nothing may be "better", else the command fails.
"""

import argparse
import json
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import count, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import tuner
from objectives.flown_system import FlightBatch
from objectives.own_meters import metering
from objectives.problem import score_flights
from objectives.risk.differences import BETTER, NO_PRACTICAL_DIFFERENCE, NOT_DISTINGUISHABLE, WORSE
from objectives.system import System
from plant.errors import InputError
from plant.law_registry import law
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions
from plant.quadrotor.scenarios import ScenarioSpec
from plant.seeds import generator
from tuner.api.flight_setup import FlightSetup
from tuner.documents.assessment import REFUSED, AssessmentDocument
from tuner.exchange.registry import exporter, settings_of
from tuner.exchange.run import bundle_of, check_laws
from tuner.exchange.target import Request
from tuner.extensions.autopilots.firmware import Bench, Firmware
from tuner.extensions.autopilots.flying import FirmwareFlights
from tuner.extensions.autopilots.registry import firmware_of
from tuner.extensions.judge.assessing import STREAM, scenario_setups
from tuner.extensions.judge.opinion import compare_flights
from tuner.extensions.judge.paired_scores import PairedScores
from tuner.extensions.judge.vehicle_files import name_files, read_subjects
from tuner.gains import Controller
from tuner.study.targets import TARGETS

AIRFRAMES = {"px4": "f450", "ardupilot": "f450", "betaflight": "racer5", "crazyflie": "crazyflie-pybullet"}
SPREADS = (0.02, 0.15, 0.4)
"""Standard deviations of the logarithms by which the gains of a pair differ."""
SHARED = {"roll": "tilt", "pitch": "tilt", "x": "horizontal", "y": "horizontal"}
"""Axis -> axes whose gains are one parameter."""
NOT_WORSE = (BETTER, NO_PRACTICAL_DIFFERENCE, NOT_DISTINGUISHABLE)
"""Words on flights that are no worse in any metric."""
SEED = 20261126
JUDGED = 256
"""Flights of each file by the judge, its default."""
FACTORS = (0.2, 0.5, 0.8, 0.9, 1.1, 1.25, 1.5)
"""Factors of P, I and D of roll and pitch."""


def pairs_of_files(firmware: Firmware, seed: int) -> Iterator[tuple[int, bytes, bytes]]:
    """Yield pairs of files of random gains with their number; those beyond the firmware's ranges are drawn again."""
    default = default_controller(firmware)
    base, addresses = np.array(default.gains), axes_and_names(default)
    # Gains alone: cut-offs and limits stay. Axes that share a parameter have one factor.
    groups = [f"{SHARED.get(axis, axis)}.{name}" for axis, name in addresses]
    _, group = np.unique(groups, return_inverse=True)
    free = np.array([name in ("p", "i", "d", "angle_p") for _, name in addresses]) & (base > 0.0)

    def varied(row: np.ndarray, deviation: float, rng: np.random.Generator) -> np.ndarray:
        return row * np.exp(np.where(free, deviation * rng.standard_normal(len(groups))[group], 0.0))

    for k in count():
        rng = generator(seed, f"opinions/{firmware.name}", k)
        first = varied(base, 0.15, rng)
        second = varied(first, SPREADS[k % len(SPREADS)], rng)
        with suppress(InputError):
            before, after = (file_of(replace(default, gains=tuple(row)), firmware) for row in (first, second))
            yield k, before, after


def default_controller(firmware: Firmware) -> Controller:
    """Return the firmware's law at its default gains on the airframe."""
    target, airframe = TARGETS[firmware.target], load(AIRFRAMES[firmware.name])
    cascade = close_cascade(law(target.position), law(firmware.law), target.position_every)
    gains, period = tuple(default_row(cascade, airframe.vehicle)), target.control_period
    return Controller(airframe, cascade, ControlOptions(), period, period, gains)


def axes_and_names(controller: Controller) -> list[tuple[str, str]]:
    """Return axis and name of each gain."""
    parts = [gain.address.partition(".") for gain in gain_addresses(controller.cascade)]
    return [(axis, name) for axis, _, name in parts]


def scaled_gains(controller: Controller, factor: float) -> Controller:
    """Return a controller whose P, I and D of roll and pitch are multiplied by a factor."""
    is_scaled = [axis in ("roll", "pitch") and name in ("p", "i", "d") for axis, name in axes_and_names(controller)]
    gains = (gain * factor if scaled else gain for gain, scaled in zip(controller.gains, is_scaled, strict=True))
    return replace(controller, gains=tuple(gains))


def file_of(controller: Controller, firmware: Firmware) -> bytes:
    """Return the file that the exporter writes."""
    target = exporter(firmware.target)
    request = Request(controller, "0" * 64, settings_of(target, firmware.options), None)
    check_laws(target, request)
    return bundle_of(target, request).files[firmware.file]


def firmware_flights(
    after: Path, before: Path, firmware: Firmware, program: Path, flights: int, threads: int, place: Path
) -> list[PairedScores]:
    """Return the scores of the firmware's own flights in each scenario of the judge."""
    subjects = read_subjects(name_files(after, before, firmware.target, AIRFRAMES[firmware.name]))
    return [
        PairedScores(
            setups[0].metrics,
            np.array(
                [
                    _firmware_scores(setup, file, firmware, program, threads, place / f"{index}-{number}")
                    for number, (setup, file) in enumerate(zip(setups, (after, before), strict=True))
                ]
            ),
            1,
            scenario,
        )
        for index, (scenario, setups) in enumerate(scenario_setups(subjects, flights, 1))
    ]


def _firmware_scores(
    setup: FlightSetup, file: Path, firmware: Firmware, program: Path, threads: int, place: Path
) -> np.ndarray:
    """Return the scores (metrics, flights) of a file's flights in the firmware, whose board lies in a folder."""
    assert isinstance(setup.system, System) and isinstance(setup.spec, ScenarioSpec)
    system = metering(setup.system, setup.metrics)
    curve = actuation(system.nominal.vehicle, firmware.curve)
    bench = Bench(program, place, curve, system.timing.control_period)
    power_up = firmware.install(bench, file.read_bytes())
    batch = FlightBatch(setup.spec, STREAM, len(setup.draws[1]))
    results = FirmwareFlights(system, firmware, 1, threads).fly(setup.gains, power_up, batch)
    return score_flights(system, setup.metrics, results, setup.spec, system.targets(setup.spec))[0]


def judge_factors(firmware: Firmware, flights: int) -> list[dict[str, Any]]:
    """Return the judge's words on each factor, against the defaults."""
    default = default_controller(firmware)
    with TemporaryDirectory(prefix="opinions-") as place:
        before, after = (Path(place) / f"{name}{Path(firmware.file).suffix}" for name in ("before", "after"))
        before.write_bytes(file_of(default, firmware))
        rows = []
        for factor in FACTORS:
            after.write_bytes(file_of(scaled_gains(default, factor), firmware))
            document = judge_pair(firmware, after, before, flights)
            words = {"judge": document.verdict, "comparison": document.comparison, "sentence": document.sentence}
            rows.append({"factor": factor, **words})
    return rows


def judge_pair(firmware: Firmware, after: Path, before: Path, flights: int) -> AssessmentDocument:
    """Return the judge's document on two files, the airframe named."""
    airframe = AIRFRAMES[firmware.name]
    return tuner.judge(after, before, airframe=airframe, source=firmware.target, flights=flights).document


def compare(
    firmware: Firmware, program: Path, pairs: int, flights: int, threads: int, seed: int
) -> list[dict[str, Any]]:
    """Return a row for each pair."""
    rows = []
    for k, *contents in islice(pairs_of_files(firmware, seed), pairs):
        with TemporaryDirectory(prefix="opinions-") as place:
            files = [Path(place) / f"{name}{Path(firmware.file).suffix}" for name in ("before", "after")]
            for file, content in zip(files, contents, strict=True):
                file.write_bytes(content)
            before, after = files
            document = judge_pair(firmware, after, before, JUDGED)
            paired = firmware_flights(after, before, firmware, program, flights, threads, Path(place))
        metrics = [row for scores in paired for row in scores.rows]
        flown = compare_flights(metrics, [scores.loss for scores in paired])
        # The tail of the position takes 80 flights, which the firmware may not have.
        by_label = {row.label: row for row in metrics}
        rows.append(
            {
                "pair": k,
                "spread": SPREADS[k % len(SPREADS)],
                "judge": document.verdict,
                "comparison": document.comparison,
                "firmware": flown,
                "agrees": document.comparison == flown,
                "lost": [[count.events for count in scores.lost] for scores in paired],
                "sentence": document.sentence,
                "differences": {
                    row.label: [
                        list(each.difference) if each.difference else None for each in (row, by_label[row.label])
                    ]
                    for row in document.metrics
                    if row.label in by_label
                },
                "seconds": sum(document.seconds.values()),
            }
        )
    return rows


def print_factors(firmware: Firmware, rows: list[dict[str, Any]], as_json: bool) -> None:
    """Print the words on each factor."""
    if as_json:
        print(json.dumps({"firmware": firmware.name, "rows": rows}, indent=2))
        return
    for row in rows:
        print(f"{row['factor']:<6g} {row['judge']:22} {row['comparison']}")


def main() -> None:
    """Compare and print."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.opinions", description="The judge beside a firmware's flights."
    )
    parser.add_argument("--firmware", required=True)
    parser.add_argument("--binary", type=Path, help="firmware, see docs/how_to/confirm.md")
    parser.add_argument("--pairs", type=int, default=20)
    parser.add_argument(
        "--flights", type=int, default=64, help="flights in the firmware, or of the judge with --factors"
    )
    parser.add_argument("--threads", type=int, default=1, help="boards that fly at once")
    parser.add_argument("--seed", type=int, default=SEED, help="seed of the gains")
    parser.add_argument("--factors", action="store_true", help="judge weaker and stronger rate loops, without firmware")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    firmware = firmware_of(arguments.firmware)
    if arguments.factors:
        scaled = judge_factors(firmware, arguments.flights)
        print_factors(firmware, scaled, arguments.json)
        better = [
            row["factor"] for row in scaled if row["factor"] < 1.0 and BETTER in (row["judge"], row["comparison"])
        ]
        assert not better, f"lower gains are better: times {better}"
        return
    if arguments.binary is None:
        parser.error("--binary is missing: give the firmware, or --factors to judge without one")
    program = firmware.program(arguments.binary)
    rows = compare(firmware, program, arguments.pairs, arguments.flights, arguments.threads, arguments.seed)
    words = ("judge", "comparison", "firmware")
    counts = Counter(tuple(row[word] for word in words) for row in rows)
    refused = [row["firmware"] for row in rows if row["judge"] in REFUSED]
    report = {
        "firmware": firmware.name,
        "pairs": len(rows),
        "agree": sum(row["agrees"] for row in rows),
        "false_alarms": sum(flown in NOT_WORSE for flown in refused),
        "strict_false_alarms": sum(flown != WORSE for flown in refused),
        "table": [{**dict(zip(words, key, strict=True)), "pairs": n} for key, n in counts.items()],
        "rows": rows,
    }
    if arguments.json:
        print(json.dumps(report, indent=2))
        return
    print("{agree} of {pairs} agree; false alarms {false_alarms}, strict {strict_false_alarms}".format(**report))
    for row in report["table"]:
        print(f"{row['judge']:22} {row['comparison']:22} {row['firmware']:22} {row['pairs']}")


if __name__ == "__main__":
    main()
