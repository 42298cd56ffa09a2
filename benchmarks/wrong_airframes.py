"""`python -m benchmarks.wrong_airframes`: parameter files next to airframes of another class.

Two kinds of files: those of six classes of vehicles as PX4 holds them from 1.13 on, with hover command, cells and the rotor
positions of its allocation, and with `--ardupilot` and `--px4` the stock files of quadrotors in checkouts, which mostly hold a
hover command alone. A number beyond a factor of 1.25 from the airframe's 95 % range contradicts it in a sentence, one beyond
1.6 makes the verdict "not judged".
"""

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import tuner
from benchmarks.measuring import RESULTS, machine, write_json
from benchmarks.opinions import file_of
from plant.law_registry import law
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions
from tuner.extensions.autopilots.registry import firmware_of
from tuner.extensions.judge.vehicle_facts import contradictions
from tuner.extensions.judge.vehicle_files import name_files
from tuner.gains import Controller
from tuner.study.targets import TARGETS


class Parts(NamedTuple):
    """Parts of a usual vehicle of a class: mass [kg], wheelbase [m], propeller [inches], kv [rpm/V], cells."""

    mass: float
    wheelbase: float
    propeller: str
    kv: float
    cells: int


CLASSES = {
    "65 mm": Parts(0.03, 0.065, "1.22x1x4", 22000.0, 1),
    "3 inch": Parts(0.25, 0.14, "3x3x3", 4500.0, 4),
    "5 inch": Parts(0.65, 0.225, "5.1x4.8x3", 1900.0, 6),
    "7 inch": Parts(1.1, 0.315, "7x4x3", 1300.0, 6),
    "450 mm": Parts(1.4, 0.45, "10x4.5", 920.0, 3),
    "650 mm": Parts(3.5, 0.65, "15x5", 400.0, 6),
}
FRAMES, AIRFRAME_SCRIPTS = "Tools/Frame_params", "ROMFS/px4fmu_common/init.d/airframes"
PUBLISHED = {
    "ardupilot": {
        "5 inch": ("Holybro-QAV250-bdshot.param", "Holybro-kospi1.param"),
        "7 inch": ("iflight-chimera7-4.2.param",),
        "450 mm": (
            "hexsoon-edu450.param", "3DR_Iris+_AC34.param", "Holybro-S500.param", "eLAB_LAB445_AC34.param",
            "Holybro-X500v2-bdshot.param",
        ),
        "650 mm": ("hexsoon-edu650.param", "eLAB_EX1050_AC34.param"),
    },
    "px4": {
        "65 mm": ("4041_beta75x", "4901_crazyflie21"),
        "5 inch": ("4052_holybro_qav250", "4053_holybro_kopis2", "4601_droneblocks_dexi_5"),
        "450 mm": ("4016_holybro_px4vision", "4061_atl_mantis_edu"),
    },
}  # fmt: skip
"""Source -> class -> stock files of quadrotors that hold a number of the vehicle."""


def write_airframes(place: Path) -> dict[str, Path]:
    """Write the airframe of each class, estimated from its parts."""
    files = {}
    for name, parts in CLASSES.items():
        files[name] = place / f"{name.replace(' ', '-')}.toml"
        tuner.estimate_airframe(**parts._asdict(), out=files[name])
    return files


def write_vehicles(airframes: dict[str, Path], place: Path) -> Iterator[tuple[str, Path]]:
    """Yield class and file of each vehicle: PX4's default gains, and the numbers of its airframe."""
    firmware = firmware_of("px4")
    target = TARGETS[firmware.target]
    for name, path in airframes.items():
        airframe = load(str(path))
        cascade = close_cascade(law(target.position), law(firmware.law), target.position_every)
        gains, period = tuple(default_row(cascade, airframe.vehicle)), target.control_period
        content = file_of(Controller(airframe, cascade, ControlOptions(), period, period, gains), firmware)
        vehicle = airframe.vehicle
        places = {
            f"CA_ROTOR{rotor}_P{axis}": value
            for axis, values in (("X", vehicle.rotor_x), ("Y", vehicle.rotor_y))
            for rotor, value in enumerate(values)
        }
        numbers = {**places, "BAT1_N_CELLS": CLASSES[name].cells}
        lines = "".join(f"1\t1\t{parameter}\t{value:g}\t9\n" for parameter, value in numbers.items())
        file = place / f"{name.replace(' ', '-')}.params"
        file.write_bytes(content + lines.encode())
        yield name, file


def judge_pairs(files: Iterator[tuple[str, Path]], source: str, airframes: dict[str, Path]) -> Iterator[dict[str, Any]]:
    """Yield a row for each file and airframe of another class."""
    for own, file in files:
        for other, airframe in airframes.items():
            if other == own:
                continue
            given = name_files(file, None, source, str(airframe))
            rows = contradictions(given.facts, given.chosen)
            yield {
                "file": file.name,
                "class": own,
                "airframe": other,
                "is_refused": any(row.refuses for row in rows),
                "sentences": [row.sentence(other) for row in rows],
            }


def published_files(checkout: Path, folder: str, source: str) -> Iterator[tuple[str, Path]]:
    """Yield class and path of the stock files of a checkout."""
    for name, files in PUBLISHED[source].items():
        for file in files:
            yield name, checkout / folder / file


def main() -> None:
    """Count, print and write the result."""
    parser = argparse.ArgumentParser(description="Parameter files next to airframes of another class.")
    parser.add_argument("--ardupilot", type=Path, help="checkout of ArduPilot")
    parser.add_argument("--px4", type=Path, help="checkout of PX4-Autopilot")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="wrong-") as folder:
        place = Path(folder)
        airframes = write_airframes(place)
        rows = {
            "files with rotor positions": list(judge_pairs(write_vehicles(airframes, place), "px4", airframes)),
            "stock files": [
                row
                for source, checkout, within in (
                    ("ardupilot", chosen.ardupilot, FRAMES),
                    ("px4", chosen.px4, AIRFRAME_SCRIPTS),
                )
                if checkout is not None
                for row in judge_pairs(published_files(checkout, within, source), source, airframes)
            ],
        }
    counts = {
        kind: {
            "pairs": len(each),
            "contradicted": sum(bool(row["sentences"]) for row in each),
            "not judged": sum(row["is_refused"] for row in each),
        }
        for kind, each in rows.items()
    }
    for kind, count in counts.items():
        print(kind, count)
    write_json(RESULTS / "wrong_airframes.json", {"machine": machine(), "counts": counts, "rows": rows})


if __name__ == "__main__":
    main()
