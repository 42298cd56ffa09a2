"""`python -m benchmarks.published_bad`: settings that others published because their vehicle fell or flew wrong, through judge.

Each case is the default file of the firmware with the settings of one report. Judge has that file as the present one. A case
passes where the command ends with exit code 0. A report of a hexarotor counts as the same settings on a quadrotor, and "or
lower" and "or higher" as the number itself.
"""

import argparse
import tempfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import tuner
from benchmarks.measuring import RESULTS, machine, write_json
from plant.errors import ToolError

PX4, ARDUPILOT = "https://github.com/PX4/PX4-Autopilot/issues", "https://github.com/ArduPilot/ardupilot/issues"
N_FLIGHTS = 64
MAX_PASSED = 2
"""Flights of each file; cases that may pass."""


class Report(NamedTuple):
    """A report: its address, airframe of the simulated vehicle, source, and the settings of each case."""

    address: str
    airframe: str
    source: str
    cases: tuple[dict[str, float], ...]


REPORTS = (
    Report(f"{PX4}/22037", "iris", "px4", ({"MC_PITCH_P": 21.5}, {"MC_PITCH_P": 0.0}, {"MC_PITCH_P": 345.0})),
    Report(f"{PX4}/22041", "iris", "px4", ({"MC_PITCHRATE_D": 0.006, "MC_PITCHRATE_K": 5.0},)),
    Report(
        f"{PX4}/22046", "iris", "px4",
        (
            {"MC_PITCHRATE_D": 0.05}, {"MC_PITCHRATE_FF": 0.8}, {"MC_PITCHRATE_K": 4.0, "MC_PITCHRATE_P": 0.45},
            {"MC_ROLL_P": 0.1}, {"MC_ROLLRATE_K": 0.01}, {"MC_ROLLRATE_K": 5.0}, {"MC_ROLLRATE_MAX": 0.0},
            {"MC_ROLLRATE_P": 0.03}, {"MC_ROLLRATE_P": 0.5}, {"MC_YAW_P": 100.0}, {"MC_YAW_P": 17.9, "MC_YAWRATE_FF": 1.8},
            {"MC_YAWRATE_FF": 10.0}, {"MC_YAWRATE_P": 0.0},
        ),
    ),
    Report(
        f"{PX4}/22050", "iris", "px4",
        (
            {"MPC_THR_MAX": 0.0}, {"MPC_XY_P": 0.0001}, {"MPC_XY_P": 10.0}, {"MPC_XY_P": 2.0, "MPC_XY_VEL_I_ACC": 6.0},
            {"MPC_XY_VEL_I_ACC": 46.6}, {"MPC_XY_VEL_MAX": 0.0}, {"MPC_XY_VEL_P_ACC": 0.0}, {"MPC_XY_VEL_P_ACC": 100.0},
            {"MPC_Z_P": 0.0}, {"MPC_Z_P": 100.0}, {"MPC_Z_VEL_MAX_DN": 2.0},
        ),
    ),
    Report(
        f"{PX4}/22052", "iris", "px4",
        (
            {"MC_PITCHRATE_FF": 1.0}, {"MC_PITCHRATE_P": 0.01}, {"MC_ROLL_P": -0.9}, {"MC_ROLLRATE_D": 0.01},
            {"MC_ROLLRATE_D": 4.2}, {"MC_ROLLRATE_FF": 4.0}, {"MC_ROLLRATE_P": 0.01}, {"MC_PITCHRATE_K": 4.0},
            {"MC_PITCHRATE_P": 0.3}, {"MC_ROLL_P": 0.0}, {"MC_ROLLRATE_P": 0.03, "MC_ROLL_P": 0.1},
        ),
    ),
    Report(
        f"{PX4}/22067", "iris", "px4",
        (
            {"MC_ROLL_P": 17.9, "MPC_XY_VEL_P_ACC": 4.78}, {"MC_YAW_P": 0.01}, {"MPC_XY_VEL_D_ACC": 1.8}, {"MPC_XY_P": 17.0},
            {"MPC_XY_P": 57.5}, {"MPC_XY_VEL_I_ACC": 60.0}, {"MPC_XY_VEL_P_ACC": 50.0}, {"MPC_Z_VEL_P_ACC": 0.0},
        ),
    ),
    Report(
        f"{ARDUPILOT}/33597", "iris", "ardupilot",
        ({"ATC_RAT_PIT_P": 0.005, "ATC_RAT_PIT_D": 0.001, "ATC_RAT_PIT_FF": 0.5},),
    ),
    Report(f"{ARDUPILOT}/14446", "iris", "ardupilot", ({"ATC_RAT_RLL_FF": 0.432304, "ATC_RATE_R_MAX": 11.0},)),
)  # fmt: skip
DEFAULTS = {
    "px4": {
        **{f"MC_{axis}_P": 6.5 for axis in ("ROLL", "PITCH")},
        **{
            f"MC_{axis}RATE_{name}": value
            for axis in ("ROLL", "PITCH")
            for name, value in {"P": 0.15, "I": 0.2, "D": 0.003, "FF": 0.0, "K": 1.0, "MAX": 220.0}.items()
        },
        **{"MC_YAW_P": 2.8, "MC_YAWRATE_P": 0.2, "MC_YAWRATE_I": 0.1, "MC_YAWRATE_D": 0.0, "MC_YAWRATE_FF": 0.0},
        **{"MC_YAWRATE_K": 1.0, "MC_YAWRATE_MAX": 200.0, "IMU_GYRO_CUTOFF": 40.0, "IMU_DGYRO_CUTOFF": 30.0},
        **{"MPC_XY_P": 0.95, "MPC_XY_VEL_P_ACC": 1.8, "MPC_XY_VEL_I_ACC": 0.4, "MPC_XY_VEL_D_ACC": 0.2, "MPC_Z_P": 1.0},
        **{"MPC_Z_VEL_P_ACC": 4.0, "MPC_Z_VEL_I_ACC": 2.0, "MPC_Z_VEL_D_ACC": 0.0, "MPC_THR_MAX": 1.0},
        **{"MPC_XY_VEL_MAX": 12.0, "MPC_Z_VEL_MAX_DN": 1.5},
    },
    "ardupilot": {
        **{
            f"ATC_RAT_{axis}_{name}": value
            for axis in ("RLL", "PIT")
            for name, value in {"P": 0.135, "I": 0.135, "D": 0.0036, "FF": 0.0, "FLTT": 20.0, "FLTD": 20.0}.items()
        },
        **{"ATC_RAT_YAW_P": 0.18, "ATC_RAT_YAW_I": 0.018, "ATC_RAT_YAW_D": 0.0, "ATC_RAT_YAW_FF": 0.0},
        **{
            "ATC_ANG_RLL_P": 4.5,
            "ATC_ANG_PIT_P": 4.5,
            "ATC_ANG_YAW_P": 4.5,
            "ATC_RATE_R_MAX": 0.0,
            "INS_GYRO_FILTER": 20.0,
        },
        **{"FRAME_CLASS": 1.0, "FRAME_TYPE": 1.0, "SCHED_LOOP_RATE": 400.0},
    },
}
"""Settings of a firmware's simulated quadrotor as it starts, by source."""


def parameter_text(source: str, values: dict[str, float]) -> str:
    """Return a parameter file of a ground station."""
    if source == "px4":
        head = "# Stack: PX4 Pro\n# Vehicle: Multi-Rotor\n# Version: 1.14.0\n"
        return head + "".join(f"1\t1\t{name}\t{value:g}\t9\n" for name, value in values.items())
    return "#NOTE: Copter 4.6\n" + "".join(f"{name},{value:g}\n" for name, value in values.items())


class Opinion(NamedTuple):
    """Judge's answer to a case: word of the verdict, exit code, sentence."""

    verdict: str
    code: int
    sentence: str


def judge_case(report: Report, case: dict[str, float], flights: int, place: Path) -> Opinion:
    """Return judge's opinion of the settings of a case, against the firmware's defaults."""
    defaults = DEFAULTS[report.source]
    before, after = place / "before.params", place / "after.params"
    before.write_text(parameter_text(report.source, defaults), encoding="utf-8")
    after.write_text(parameter_text(report.source, {**defaults, **case}), encoding="utf-8")
    try:
        assessment = tuner.judge(after, before, airframe=report.airframe, source=report.source, flights=flights)
    except ToolError as error:
        return Opinion("bad input", 2, str(error).splitlines()[0])
    return Opinion(assessment.document.verdict, assessment.exit_code, assessment.document.sentence)


def judge_reports(reports: Sequence[Report], flights: int) -> list[dict[str, object]]:
    """Return judge's opinions of all cases, printed as they come."""
    rows: list[dict[str, object]] = []
    with tempfile.TemporaryDirectory(prefix="published-") as place:
        for report in reports:
            for case in report.cases:
                opinion = judge_case(report, case, flights, Path(place))
                rows.append({"report": report.address, "settings": case, **opinion._asdict()})
                print(
                    report.address.rpartition("/")[2],
                    case,
                    opinion.verdict,
                    opinion.code,
                    opinion.sentence[:90],
                    flush=True,
                )
    return rows


def main() -> None:
    """Judge all cases, and write the result."""
    parser = argparse.ArgumentParser(description="Settings that were published as bad, through judge.")
    parser.add_argument("--flights", type=int, default=N_FLIGHTS, help="flights of each file")
    rows = judge_reports(REPORTS, parser.parse_args().flights)
    passed = sum(row["code"] == 0 for row in rows)
    words = Counter(str(row["verdict"]) for row in rows)
    print(f"{len(rows)} cases, {passed} passed; " + ", ".join(f"{count} {word}" for word, count in words.most_common()))
    write_json(RESULTS / "published_bad.json", {"machine": machine(), "passed": passed, "rows": rows})
    assert passed <= MAX_PASSED, f"{passed} cases pass; allowed: {MAX_PASSED}"


if __name__ == "__main__":
    main()
