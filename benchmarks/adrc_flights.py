"""`python -m benchmarks.adrc_flights FLIGHTS.csv`: forecasts of Betaflight's ADRC against what its pilots printed.

FLIGHTS.csv has a row for each printed outcome: craft, build, loop_hz, axis, wc, wo, b0, b0_law, throttle (with scale= of b0 and
gain= of the plant), outcome, frequency_hz, value, unit. The plants of one craft, by chirp, are scaled by b0 to the others;
nothing is fitted to an outcome. `--write` puts the page into results/adrc_flights.md.
"""

import argparse
import csv
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import spearmanr

from benchmarks.measuring import RESULTS
from tuner.extensions.betaflight_adrc.linear_loop import Margins, Sampling, margins, scaled
from tuner.extensions.betaflight_adrc.ringing import REFERENCE
from tuner.extensions.betaflight_adrc.settings import BUILDS, default_tune
from tuner.text.tables import Table

Row = dict[str, str]
CRAFT_B0 = {
    "Air65-A": {"roll": 8964.0, "pitch": 5378.0, "yaw": 3586.0},
    "TH3+ 2.5in (US25 frame)": {"roll": 6560.0, "pitch": 3936.0, "yaw": 2624.0},
    "Petrel75-PET": {"roll": 4458.0, "pitch": 2858.0, "yaw": 4200.0},
}
"""Craft -> b0 by which the reference plants are scaled: that of its own sweep."""
GROUND_B0 = 3852.0
"""b0 of the pitch axis of Air65-B, by chirp [deg/s3]."""
TITLE = """# Forecasts of Betaflight's ADRC against printed flights

`python -m benchmarks.adrc_flights FLIGHTS.csv --write`; nothing is fitted to an outcome. Flights and outcomes: analyses in
danusha2345/ADRC-betaflight and threads of betaflight/betaflight#15400."""
PLACES = {"roll": 0, "pitch": 1, "yaw": -1}
LINE = "motor line 40-80 Hz, per-motor RMS of mean motor"
SWEEPS: dict[str, Callable[[Row], bool]] = {
    "Air65-A, SQRT": lambda row: row["outcome"] == LINE and _is("Air65-A", row) and row["b0_law"] == "SQRT",
    "Air65-A, FIXED": lambda row: row["outcome"] == LINE and _is("Air65-A", row) and row["b0_law"] == "FIXED",
    "Air65-A, SQRT and FIXED": lambda row: row["outcome"] == LINE and _is("Air65-A", row),
    "Air65-A, 144/160, median": lambda row: "median of 1-s" in row["outcome"] and _is("Air65-A", row),
    "Air65-A, 144/160, whole flight": lambda row: "whole flight" in row["outcome"] and _is("Air65-A", row),
    "Air65-A, yaw": lambda row: "(yawsweep)" in row["source"] and _is("Air65-A", row) and bool(row["value"]),
}


def _is(craft: str, row: Row) -> bool:
    return row["craft"] == craft


class Forecast(NamedTuple):
    """Forecast of a row: its worst axis and margins, 2 wc wo/b0 and wo of that axis."""

    axis: str
    margins: Margins
    gain_d: float
    wo: float


def number(text: str, axis: str) -> float | None:
    """Return the number of an axis in "roll/pitch/yaw", one for all, or roll/pitch; None without any."""
    parts = re.findall(r"[\d.]+", text)
    if not parts or (axis == "yaw" and len(parts) == 2):
        return None
    return float(parts[PLACES[axis]] if len(parts) > 1 else parts[0])


def named(row: Row, name: str, default: float) -> float:
    """Return the number behind a name in the column of the throttle."""
    match = re.search(rf"{name}\s*=?\s*([\d.]+)", row["throttle"])
    return float(match[1].rstrip(".")) if match else default


def forecast_axis(row: Row, axis: str, craft_b0: float | None = None) -> Forecast | None:
    """Return the forecast of an axis; None where the row lacks its wc or wo."""
    wc, wo = number(row["wc"], axis), number(row["wo"], axis)
    if wc is None or wo is None:
        return None
    reference = craft_b0 or CRAFT_B0.get(row["craft"], {}).get(axis)
    b0 = number(row["b0"], axis) or reference or 2000.0
    period = 1.0 / float(row["loop_hz"])
    is_own = row["craft"].startswith("TH3+")
    build = BUILDS["b11" if row["build"].startswith("b11") else "b10.1"]
    ground = {"adrc_ground_wc": min(wc, 255.0), "adrc_ground_dgain": 0.0} if build.name == "b11" else {}
    tune = default_tune(build).with_numbers(
        {
            f"adrc_wc_{axis}": wc,
            f"adrc_wo_{axis}": wo,
            f"adrc_b0_{axis}": round(b0),
            "adrc_gyro_lpf_hz": named(row, "adrc lpf", 0.0 if is_own else 150.0),
            **ground,
        }
    )
    of_chirp, plant = REFERENCE[axis]
    plant = scaled(plant, (reference or b0) / of_chirp * named(row, "gain", 1.0))
    scale, is_open = named(row, "scale", 1.0), "gate shut" not in row["throttle"]
    sampling = Sampling(period, period, (1000.0,) if is_own else ())
    return Forecast(axis, margins(tune, axis, plant, sampling, scale, is_open), 2.0 * wc * wo / (b0 * scale), wo)


def forecast(row: Row) -> Forecast | None:
    """Return the forecast of the axis that has the smallest gain margin among those of the row."""
    axes = {"rpy": ("roll", "yaw"), "rp": ("roll",)}.get(row["axis"], (row["axis"],))
    found = [one for axis in axes if axis in PLACES and (one := forecast_axis(row, axis)) is not None]
    return min(found, key=lambda one: np.nan_to_num(one.margins.gain, nan=np.inf), default=None)


def rank(values: Sequence[float], outcomes: Sequence[float]) -> str:
    """Return Spearman's rank correlation as text, "-" for a constant."""
    if len(set(values)) < 2:
        return "-"
    return f"{float(np.asarray(spearmanr(values, outcomes))[0]):.2f}"


def ranks(name: str, rows: Sequence[Row]) -> list[str]:
    """Return a row of the table of ranks: ours, 2 wc wo/b0, wo."""
    found = [(one, float(row["value"].split("/")[0])) for row in rows if (one := forecast(row)) is not None]
    outcomes = [value for _, value in found]
    measures = zip(*[(1.0 / one.margins.gain, one.gain_d, one.wo) for one, _ in found], strict=True)
    return [name, str(len(found)), *[rank(values, outcomes) for values in measures]]


def pooled(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of all craft whose outcome is the line in the motors, in % of their mean."""
    selected = [row for row in rows if row["unit"] == "% of mean motor" and row["craft"] in CRAFT_B0]
    wanted = (LINE, "motor line 70-90 Hz, median of 1-s windows", "motor band 25-38 Hz whole flight")
    return [row for row in selected if row["outcome"] in wanted]


def lines(rows: Sequence[Row], *, on_ground: bool) -> list[tuple[Row, Forecast, float]]:
    """Return rows with one printed frequency of a ring, and their forecasts."""
    selected = []
    for row in rows:
        is_plain = re.fullmatch(r"[\d.]+", row["frequency_hz"]) and "plant" not in row["build"] + row["outcome"]
        # Frequencies of mp2 are crossovers, those of chirps peaks of a response.
        is_ring = not re.match("mp2|b11 chirp", row["build"]) and "tap test" not in row["throttle"]
        is_shut = "gate shut" in row["throttle"]
        if is_plain and is_ring and is_shut == on_ground and row["wc"] and (one := forecast(row)) is not None:
            frequency = float(row["frequency_hz"])
            # Below 12 Hz there is no ring, but motion of the craft.
            if frequency > 12.0 and np.isfinite(one.margins.ring):
                selected.append((row, one, frequency))
    return selected


def frequency_table(title: str, found: Sequence[tuple[Row, Forecast, float]]) -> Table:
    """Return mean and largest errors of the frequency by craft and axis."""
    errors: dict[str, list[float]] = {}
    for row, one, frequency in found:
        for name in (f"{row['craft']}, {one.axis}", "all"):
            errors.setdefault(name, []).append(abs(one.margins.ring - frequency))
    names = sorted(errors, key=lambda name: (name == "all", name))
    body = [
        [name, str(len(errors[name])), f"{np.mean(errors[name]):.1f}", f"{max(errors[name]):.1f}"] for name in names
    ]
    return Table(title, ("craft, axis", "lines", "mean error [Hz]", "largest"), body)


def ground_table(rows: Sequence[Row]) -> Table:
    """Return the tap tests with the gate shut: gain margin of the ground and outcome."""
    taps = [row for row in rows if "tap test" in row["throttle"]]
    found = [(row, one) for row in taps if (one := forecast_axis(row, "pitch", GROUND_B0)) is not None]
    body = [
        [row["wc"], row["wo"], row["b0"], f"{one.margins.gain:.2f}", f"{one.margins.ring:.0f}", outcome(row)]
        for row, one in sorted(found, key=lambda pair: -pair[1].margins.gain)
    ]
    head = ("wc", "wo", "b0", "gain margin", "ring [Hz]", "printed")
    return Table(f"Tap tests on the ground, Air65-B pitch (b0 {GROUND_B0:.0f} by chirp)", head, body, ("printed",))


def outcome(row: Row) -> str:
    """Return the printed outcome of a tap test."""
    return row["outcome"].partition(": ")[2]


def failures(rows: Sequence[Row]) -> list[str]:
    """Return sentences on outcomes that the forecast does not explain."""
    same = [float(row["value"]) for row in rows if row["throttle"] == "thr < 35 %; scale=1"]
    axes = [one.axis for row in pooled(rows) if (one := forecast(row)) is not None]
    return [
        f"Air65-A at 99/110 and scale 1 printed {min(same):g} to {max(same):g} % in {len(same)} flights; the forecast is "
        "one number.",
        "Within a sweep 2 wc wo/b0 orders the flights as well as the gain margin does; over craft it does not.",
        "Petrel75: the three schedules are ordered as printed, but the voltage of the pack changed with them, and the whole "
        "flights differ from windows at matched throttle.",
        "Petrel75 rings at 28 to 33 Hz, as roll and pitch do; the forecast has the smallest margin on yaw.",
        "Petrel75-PET, yaw at 50/80 and 60/80: printed 63 Hz, forecast 48 to 50 Hz; its filters and dead time are not printed.",
        "Air65-A at 144/160 with a hover throttle of 21 to 27: the line rises from 76 to 86 Hz, the forecast stays at 70 Hz.",
        "Air65-B on the ground rings 3 to 11 Hz below the forecast; its filters are not printed.",
        "Amplitudes beyond the boundary are set by the limits of the motors, which a linear loop has not.",
        f"The axis is inferred: yaw has the smallest margin in {axes.count('yaw')} of {len(axes)} flights with a line in the "
        "motors; a spectrum of the motors' yaw mix would decide.",
    ]


def page(rows: list[Row]) -> str:
    """Return the page in Markdown."""
    table = [ranks(name, [row for row in rows if chosen(row)]) for name, chosen in SWEEPS.items()]
    table.append(ranks("three craft, % of mean motor", pooled(rows)))
    in_air, on_ground = (lines(rows, on_ground=ground) for ground in (False, True))
    of_yaw = [(one, frequency) for _, one, frequency in in_air if one.axis == "yaw"]
    frequencies = np.array([frequency for _, frequency in of_yaw])
    constant = float(np.mean(np.abs(frequencies - np.median(frequencies))))
    by_wo = float(np.mean(np.abs(0.6 * np.array([one.wo for one, _ in of_yaw]) - frequencies)))
    head = ("flights", "n", "1/gain margin", "2 wc wo/b0", "wo")
    tables = (
        Table("Rank correlation with the printed amplitude", head, table),
        frequency_table("Frequency of the line in flight", in_air),
        frequency_table("Frequency on the ground, gate shut", on_ground),
        ground_table(rows),
    )
    body = "\n\n".join(f"## {one.title}\n\n{one.markdown}" for one in tables)
    others = (
        f"For yaw in flight the best constant frequency errs by {constant:.1f} Hz, 0.6 wo (its number in Hz) by "
        f"{by_wo:.1f} Hz."
    )
    listed = "\n".join(f"- {sentence}" for sentence in failures(rows))
    return f"{TITLE}\n\n{body}\n\n{others}\n\n## Not explained\n\n{listed}\n"


def main() -> None:
    """Print the page, and write it on request."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("flights", type=Path)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    with given.flights.open(newline="", encoding="utf-8") as file:
        text = page(list(csv.DictReader(file)))
    print(text)
    if given.write:
        (RESULTS / "adrc_flights.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
