"""`python -m benchmarks.presets PRESETS`: the tunes of a clone of betaflight/firmware-presets, read and judged.

Each tune is read as a file of its own, and over the defaults of its firmware. With `--judge VERSION` the tunes of one version
fly against these defaults on the class: pilots fly them, so a refusal is a false alarm unless its reason explains it.
"""

import argparse
import re
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import tuner
from benchmarks.measuring import RESULTS, machine, write_json
from plant.errors import ToolError
from tuner.extensions.judge.vehicle_files import name_files, read_subjects

VERSION = re.compile(r"^[ \t]*#\$ FIRMWARE_VERSION:\s*(\S+)", re.MULTILINE)
N_FLIGHTS = 64
DEFAULTS = {"p_roll": 45, "i_roll": 80, "p_pitch": 47, "i_pitch": 84, "p_yaw": 45, "i_yaw": 80}
"""Gains of a board as it starts, the same from 4.3 to 2026.6: judge takes no file without gains."""


def tunes_of(presets: Path) -> Iterator[Path]:
    """Yield the tunes of a clone that a configurator shows, sorted."""
    for file in sorted(presets.glob("presets/*/tune/**/*.txt")):
        if "#$ TITLE:" in file.read_text(encoding="utf-8", errors="replace"):
            yield file


def versions_of(file: Path) -> list[str]:
    """Return the versions of the firmware that a preset names."""
    return VERSION.findall(file.read_text(encoding="utf-8", errors="replace"))


def write_defaults(version: str, place: Path) -> Path:
    """Write the answer of a board with default settings to `diff all`."""
    file = place / f"defaults-{version}.txt"
    heading = f"# Betaflight / STM32F7X2 (S7X2) {version}.0 Jan  1 2026 / 00:00:00 (0123456) MSP API: 1.46\n"
    settings = "".join(f"set {name} = {value}\n" for name, value in DEFAULTS.items())
    file.write_text(f"{heading}profile 0\n{settings}", encoding="utf-8")
    return file


def read_tune(file: Path, before: Path | None) -> str:
    """Return the reason of a refusal, or ""."""
    try:
        read_subjects(name_files(file, before, "betaflight", None))
    except ToolError as error:
        return str(error)
    return ""


def judge_tune(file: Path, before: Path | None, flights: int, source: str = "betaflight") -> dict[str, Any]:
    """Return judge's opinion of a tune, over the defaults or alone."""
    try:
        assessment = tuner.judge(file, before, source=source, flights=flights)
    except ToolError as error:
        return {"verdict": "bad input", "code": 2, "sentence": str(error)}
    document = assessment.document
    return {
        "verdict": document.verdict,
        "code": assessment.exit_code,
        "comparison": document.comparison,
        "sentence": document.sentence,
    }


def main() -> None:
    """Read and judge, and write the result."""
    parser = argparse.ArgumentParser(description="Tunes of the public preset repository, read and judged.")
    parser.add_argument("presets", type=Path, help="clone of betaflight/firmware-presets")
    parser.add_argument("--judge", metavar="VERSION", help="version of the firmware whose tunes fly, such as 4.5")
    parser.add_argument("--flights", type=int, default=N_FLIGHTS, help="flights of each file")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="presets-") as folder:
        rows = []
        for file in tunes_of(chosen.presets):
            version = versions_of(file)[0]
            before = write_defaults(version, Path(folder))
            row: dict[str, Any] = {
                "file": str(file.relative_to(chosen.presets)),
                "version": version,
                "alone": read_tune(file, None),
                "over_defaults": read_tune(file, before),
            }
            if version == chosen.judge:
                row |= judge_tune(file, before, chosen.flights)
                print(row["file"], row["verdict"], row["sentence"][:120], flush=True)
            rows.append(row)
    counts = {
        "tunes": len(rows),
        "read_alone": sum(not row["alone"] for row in rows),
        "read_over_defaults": sum(not row["over_defaults"] for row in rows),
        "verdicts": Counter(row["verdict"] for row in rows if "verdict" in row),
    }
    print(counts)
    for row in rows:
        if reason := row["alone"] or row["over_defaults"]:
            print(row["file"], reason)
    write_json(RESULTS / "presets.json", {"machine": machine(), **counts, "rows": rows})


if __name__ == "__main__":
    main()
