"""`python -m benchmarks.flown_tunes`: tunes that people fly, each alone on the class of its firmware, through judge.

Stock files of ArduPilot's and PX4's quadrotors, and tunes of the public preset repository, evenly picked, 60 in all. Their
vehicles are not known to judge, so none may be "do not fly" but for a reason that holds for the tune itself.
"""

import argparse
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from benchmarks.measuring import RESULTS, machine, write_json
from benchmarks.presets import judge_tune, tunes_of
from benchmarks.wrong_airframes import AIRFRAME_SCRIPTS, FRAMES, published_files

N_TUNES, N_FLIGHTS = 60, 64
"""Number of tunes, and of the flights of each."""


def pick_tunes(presets: Path, ardupilot: Path, px4: Path) -> Iterator[tuple[str, Path]]:
    """Yield source and file of each tune."""
    stock = [
        (source, file)
        for source, checkout, folder in (("ardupilot", ardupilot, FRAMES), ("px4", px4, AIRFRAME_SCRIPTS))
        for _, file in published_files(checkout, folder, source)
    ]
    yield from stock
    tunes = list(tunes_of(presets))
    count = N_TUNES - len(stock)
    for index in range(count):
        yield "betaflight", tunes[index * len(tunes) // count]


def main() -> None:
    """Judge all tunes, and write the result."""
    parser = argparse.ArgumentParser(description="Tunes that people fly, alone through judge.")
    parser.add_argument("presets", type=Path, help="clone of betaflight/firmware-presets")
    parser.add_argument("--ardupilot", type=Path, required=True, help="checkout of ArduPilot")
    parser.add_argument("--px4", type=Path, required=True, help="checkout of PX4-Autopilot")
    chosen = parser.parse_args()
    rows = []
    for source, file in pick_tunes(chosen.presets, chosen.ardupilot, chosen.px4):
        rows.append({"file": file.name, "source": source, **judge_tune(file, None, N_FLIGHTS, source)})
        print(file.name, rows[-1]["verdict"], str(rows[-1]["sentence"])[:120], flush=True)
    counts = Counter(str(row["verdict"]) for row in rows)
    print(f"{len(rows)} tunes; " + ", ".join(f"{count} {word}" for word, count in counts.most_common()))
    write_json(RESULTS / "flown_tunes.json", {"machine": machine(), "counts": counts, "rows": rows})


if __name__ == "__main__":
    main()
