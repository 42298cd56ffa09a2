"""A made-up results folder with plausible numbers, written as a run writes it; no flight behind it."""

import csv
import json
from dataclasses import dataclass
from functools import lru_cache
from math import radians
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from tests.tables import write_rows
from tuner.documents.registry import DOCUMENTS
from tuner.store.columns import in_codes
from tuner.store.npz import npz_bytes

OBJECTIVES = (
    ("cvar90(itae.position)", "itae.position", "m", "time-weighted mean of |e|: integral of t|e| over T^2/2"),
    ("mean(travel)", "travel", "1/s", "total variation of the rotor commands per second, summed over rotors"),
    ("mean(rms.tilt)@gusts", "rms.tilt", "rad", "root of the mean of e^2 over the flight"),
    ("cvar90(settling.z)@gusts", "settling.z", "s", "time from the step until |e| stays within the band"),
    ("mean(ise.yaw)", "ise.yaw", "rad^2 s", "integral of e^2"),
)
DEFAULTS = (0.412, 31.0, 0.051, 2.31, 0.0123)
VARIABLES = (
    ("attitude.omega_o", "wo", "rad/s", 2.0, 75.0, "log", 10.0),
    ("attitude.lambda", "lambda", "s^-1", 0.5, 20.0, "log", 5.0),
    ("attitude.k1", "k1", "rad^(1/2) s^(-3/2)", 0.0, 40.0, "linear", 20.0),
    ("attitude.delta", "delta", "rad/s", 0.01, 1.0, "log", 0.1),
    ("position.zeta", "zeta", "1", 0.4, 2.5, "linear", 1.0),
)
SIGNALS = (
    *((name, "m") for name in "xyz"),
    *((name, "rad") for name in ("roll", "pitch", "yaw")),
    *((f"rotor{i}", "1") for i in range(1, 5)),
)
GENERATIONS, POPULATION, FINALISTS = 12, 32, 14
CHANNELS = ("x", "y", "z", "roll", "pitch", "yaw")
# Seconds of a made-up flight, and instants recorded of it.
DURATION, INSTANTS = 10.0, 400


@dataclass
class Made:
    """What a fabricated run knows of itself. best: whether any finalist keeps every limit; old: without later files; lost: how many
    finalists at the end lost two flights, which puts their values far off.
    """

    objectives: int
    scenarios: tuple[str, ...]
    title: str
    rng: np.random.Generator
    population: int = POPULATION
    finalists: int = FINALISTS
    best: bool = True
    old: bool = False
    lost: int = 0

    @property
    def labels(self):
        return [self.label(i) for i in range(self.objectives)]

    def label(self, i):
        return OBJECTIVES[i][0].replace("@gusts", f"@{self.scenarios[0]}")

    @property
    def tuned(self):
        return "p0101"


def fabricate(
    folder: Path, objectives=2, scenarios=("gusts",), title="Quickstart: hold a hover", responses=True, **more
):
    """Write a results folder and return its path; more: further fields of `Made`."""
    for name, content in files_of(objectives, tuple(scenarios), title, responses, **more).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder


@lru_cache(maxsize=8)
def files_of(objectives, scenarios, title, responses, **more) -> dict[str, bytes]:
    """Return the files of a folder, made once: most tests have one of a few."""
    with TemporaryDirectory() as base:
        made_up(
            folder := Path(base), Made(objectives, scenarios, title, np.random.default_rng(20250509), **more), responses
        )
        files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
        return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def made_up(folder: Path, made: Made, responses: bool) -> None:
    """Write the files of a folder."""
    (folder / "generations").mkdir(parents=True)
    (folder / "study.toml").write_text('title = "made up"\nseed = 2025\n', encoding="utf-8")
    write_search(folder, made)
    front = write_front(folder, made)
    documents = {
        "resolved": resolved(made),
        "environment": ENVIRONMENT,
        "summary": summary(made, front),
        "gains": gains(made, front),
    }
    for name, content in documents.items():
        model = DOCUMENTS.get(name)
        text = json.dumps(content) if model is None else model.parse(json.dumps(content)).text()
        (folder / f"{name}.json").write_text(text, encoding="utf-8")
    if responses:
        write_responses(folder, made)
    if not made.old:
        write_constraints(folder, made, front)
        write_margins(folder, made)


def trade_off(made, n, spread):
    """Values (n, objectives) on a convex surface below the default's, pushed away from it by a spread."""
    weights = made.rng.dirichlet(np.ones(made.objectives) * 0.8, n) if made.objectives > 1 else np.ones((n, 1))
    distance = 1.0 + spread * made.rng.gamma(2.0, 0.5, n)
    scaled = 0.35 + 0.75 * (1.0 - np.sqrt(np.clip(weights, 1e-6, None)))
    return scaled * distance[:, None] * np.array(DEFAULTS[: made.objectives])


def values_of_gains(made, n):
    unit = made.rng.uniform(size=(n, len(VARIABLES)))
    columns = []
    for i, (_, _, _, low, high, scale, _) in enumerate(VARIABLES):
        span = low * (high / low) ** unit[:, i] if scale == "log" else low + (high - low) * unit[:, i]
        columns.append(span)
    return np.stack(columns, axis=1)


def write_search(folder, made):
    saved = "" if made.old else ",flights_saved,flights_raced"
    history = [f"generation,flights,seconds,feasible_share,hypervolume{saved}"]
    for generation in range(GENERATIONS):
        values = trade_off(made, made.population, 3.0 / (1.0 + 0.5 * generation))
        failed = made.rng.uniform(size=made.population) < (0.4 / (1.0 + generation) if made.best else 2.0)
        values[failed] *= 30.0
        gains_rows = values_of_gains(made, made.population)
        columns = {"candidate": np.arange(made.population) + generation * made.population}
        columns |= {f"gain:{entry[0]}": gains_rows[:, i] for i, entry in enumerate(VARIABLES)}
        columns |= {f"objective:{label}": values[:, i] for i, label in enumerate(made.labels)}
        columns |= {"violation:mean(failure)": failed * 0.25, "failures": failed * 0.25, "feasible": ~failed}
        if not made.old:
            columns["requirement:phase_margin"] = np.where(failed, np.inf, np.radians(28.0 + columns["candidate"] % 17))
        (folder / "generations" / f"{generation:04d}.npz").write_bytes(npz_bytes(columns))
        flights = (generation + 1) * made.population * 32 * len(made.scenarios)
        volume = 0.55 * (1.0 - np.exp(-0.4 * (generation + 1)))
        saved = "" if made.old else f",{flights // 5},{flights // 8}"
        history.append(f"{generation},{flights},{flights / 9000:.17g},{1.0 - failed.mean():.17g},{volume:.17g}{saved}")
    (folder / "history.csv").write_text("\n".join(history) + "\n", encoding="utf-8")


def write_front(folder, made):
    """Write front.csv and return its rows as dictionaries."""
    search = np.concatenate([[DEFAULTS[: made.objectives]], trade_off(made, made.finalists, 0.05)])
    held_out = search * made.rng.normal(1.04, 0.02, search.shape)
    held_out[len(held_out) - made.lost :] *= 40.0
    half = held_out * made.rng.uniform(0.015, 0.05, search.shape)
    best = [not any(np.all(other < row) for other in held_out[1:]) for row in held_out]
    gain_rows = np.concatenate([[[entry[6] for entry in VARIABLES]], values_of_gains(made, made.finalists)])
    rows = []
    for k in range(made.finalists + 1):
        row = {
            "point": "default" if k == 0 else f"p{100 + k:04d}",
            "candidate": 0 if k == 0 else 100 + k,
            "role": {0: "default", 1: "tuned"}.get(k, ""),
            "non_dominated": bool(best[k]) and k > 0 and k != 5 and made.best,
            "feasible": k != 5 and made.best,
        }
        if not made.old:
            row["probability"] = 0.0 if k in (0, 5) else float(made.rng.uniform(0.2, 1.0))
            row["lost"] = 2 if k > made.finalists - made.lost else 0
        row |= {f"gain:{entry[0]}": float(gain_rows[k, i]) for i, entry in enumerate(VARIABLES)}
        for i, label in enumerate(made.labels):
            value = float(held_out[k, i])
            row |= {f"search:{label}": float(search[k, i]), f"held_out:{label}": value}
            row |= {f"low:{label}": value - float(half[k, i]), f"high:{label}": value + 1.2 * float(half[k, i])}
            if not made.old:
                row |= judged("gap", value - float(search[k, i]), float(half[k, i]), label)
                row |= judged("difference", value - float(held_out[0, i]), 0.4 * float(half[k, i]) * (k > 0), label)
        if not made.old:
            row["requirement:phase_margin"] = radians(30.0 + k) if k else float("inf")
        rows.append(row)
    with open(folder / "front.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return rows


def judged(name, value, half, label):
    return {f"{name}:{label}": value, f"{name}_low:{label}": value - half, f"{name}_high:{label}": value + half}


def estimate(row, label):
    return {"value": row[f"held_out:{label}"], "low": row[f"low:{label}"], "high": row[f"high:{label}"]}


def table_row(made, front, i):
    label, (_, metric, unit, definition) = made.label(i), OBJECTIVES[i]
    default, tuned = estimate(front[0], label), estimate(front[1], label)
    difference = tuned["value"] - default["value"]
    half = 0.4 * (default["high"] - default["low"])
    verdict = "better" if difference + half < 0 else "worse" if difference - half > 0 else "no clear difference"
    return {
        "label": label,
        "metric": metric,
        "definition": definition,
        "risk": "mean of the worst share 1 - `level` of the scenarios" if "cvar" in label else "mean over scenarios",
        "scenario": made.scenarios[0] if "@" in label else None,
        "unit": unit,
        "kind": "objective",
        "limit": None,
        "default": default,
        "tuned": tuned,
        "verdict": verdict,
        "difference": {"value": difference, "low": difference - half, "high": difference + half},
    }


CONSTRAINTS = [
    {
        "label": "mean(failure)", "metric": "failure", "definition": "1 if the flight failed, else 0",
        "risk": "mean over scenarios", "scenario": None, "unit": "1", "kind": "constraint", "limit": 0.0,
        "default": {"value": 0.0, "low": 0.0, "high": 0.0}, "tuned": {"value": 0.0, "low": 0.0, "high": 0.0},
        "difference": {"value": 0.0, "low": 0.0, "high": 0.0}, "verdict": "kept",
    },
    {
        "label": "quantile95(peak.tilt)", "metric": "peak.tilt", "definition": "largest |e| of roll and pitch",
        "risk": "smallest value that the share `level` of the scenarios does not exceed", "scenario": None,
        "unit": "rad", "kind": "constraint", "limit": 0.35, "verdict": "broken",
        "default": {"value": 0.31, "low": 0.29, "high": 0.335}, "tuned": {"value": 0.36, "low": 0.33, "high": 0.38},
        "difference": {"value": 0.05, "low": 0.03, "high": 0.06},
    },
]  # fmt: skip


REQUIREMENT = {
    "label": "phase_margin", "quantity": "phase margin of every loop", "unit": "rad", "shown_unit": "deg",
    "kind": "requirement", "limit": radians(35.0), "sense": "min", "default": {"value": None, "low": None, "high": None},
    "tuned": {"value": radians(31.0), "low": None, "high": None}, "difference": {"value": None, "low": None, "high": None},
    "verdict": "broken",
}  # fmt: skip


def table(made, front):
    rows = [table_row(made, front, i) for i in range(made.objectives)] + CONSTRAINTS
    return rows if made.old else [*rows, REQUIREMENT]


def summary(made, front):
    return {
        "title": made.title,
        "study": "quickstart.toml",
        "tuned": made.tuned,
        "pick": {
            "rule": "knee",
            "why": "knee of the held-out front, among points better on held-out flights than the default in every objective",
        },
        "flights": 16128,
        "wall_seconds": 72.4,
        "held_out": 256 * len(made.scenarios),
        "front_size": 11,
        "hypervolume": 0.5471,
        "warnings": ["cvar90(itae.position) rests on 32 search scenarios; 50 would put five into its tail."],
        "variables": [
            {
                "name": name,
                "symbol": symbol,
                "meaning": "",
                "unit": unit,
                "low": low,
                "high": high,
                "scale": scale,
                "default": default,
                "tuned": front[1][f"gain:{name}"],
            }
            for name, symbol, unit, low, high, scale, default in VARIABLES
        ],
        "table": table(made, front),
        "air": [
            {
                "scenario": name,
                "spec": "MIL-F-8785C",
                "intensity": "moderate",
                "altitude": 10.0,
                "mean_wind": 11.9,
                "airspeed": 11.9,
                "frozen_field_ratio": 0.245,
                "length_u": 67.37,
                "sigma_u": 2.915,
                "tau_u": 5.66,
                "length_v": 67.37,
                "sigma_v": 2.915,
                "tau_v": 5.66,
                "length_w": 10.0,
                "sigma_w": 1.543,
                "tau_w": 0.84,
            }
            for name in made.scenarios
        ],
    }


def resolved(made):
    return {
        "title": made.title,
        "description": "One metre steps in moderate gusts.",
        "seed": 2025,
        "digest": "9f8c01aa27",
        "airframe": {"name": "hummingbird", "title": "AscTec Hummingbird"},
        "controller": {"position": "ladrc", "attitude": "hybrid", "control_period": 0.004, "plant_step": 0.001},
        "search": {"algorithm": "nsga2", "population": POPULATION, "generations": GENERATIONS},
    }


ENVIRONMENT = {
    "gainproof": "0.1.0", "numpy": "2.4.6", "numba": "0.68.1", "python": "3.11.9", "platform": "Linux-6.1", "threads": 4,
    "cpu": "AMD EPYC 9R14", "simd": "avx512", "started": "2025-11-21T02:41:04+00:00",
    "command": "tuner run studies/quickstart.toml", "commit": None,
}  # fmt: skip


def gains(made, front):
    bandwidth = {"value": front[1]["gain:attitude.omega_o"], "unit": "rad/s"}
    keys = ("label", "unit", "kind", "limit", "default", "tuned", "difference", "verdict")
    return {
        "format": "gainproof-gains",
        "version": "0.1",
        "controller": {"position": "ladrc", "attitude": "hybrid"},
        "gains": {
            **{f"{axis}.omega_o": bandwidth for axis in ("roll", "pitch", "yaw")},
            "roll.delta": {"value": 30.0, "unit": "rad/s"},
        },
        "study": {"title": made.title, "point": made.tuned},
        "objectives": [{key: row[key] for key in keys} for row in table(made, front)],
    }


def step(time, rate, damping):
    """Unit step response of a second-order system, damping below 1."""
    fast = rate * np.sqrt(1.0 - damping**2)
    decay = np.exp(-damping * rate * time)
    return 1.0 - decay * (np.cos(fast * time) + damping * rate / fast * np.sin(fast * time))


def fan(made, signal, time, quality):
    """Reference and low, median, high of one signal; the better the quality, the tighter the band."""
    start = np.clip(time - 1.0, 0.0, None)
    wobble = np.convolve(made.rng.normal(size=len(time)), np.hanning(25) / 12.0, mode="same")
    if signal in "xyz":
        level = {"x": 1.0, "y": -1.0, "z": 0.5}[signal]
        reference, middle, width = level * (time >= 1.0), level * step(start, 2.0 * quality, 0.5 + 0.2 * quality), 0.12
    elif signal in ("roll", "pitch"):
        reference = 0.2 * np.exp(-start) * np.sin(3.0 * start)
        middle, width = 0.18 * np.exp(-start) * np.sin(3.0 * start - 0.2), 0.05
    elif signal == "yaw":
        reference = 0.35 * (time >= 1.0)
        middle, width = 0.35 * step(start, 3.0 * quality, 0.7), 0.02
    else:
        reference, middle, width = np.full(len(time), np.nan), 1.0 + 0.3 * np.exp(-3.0 * start) * (start > 0.0), 0.15
    middle = middle + 0.02 * width * wobble
    gust = width / quality * (0.4 + 0.6 * np.exp(-(((time - 5.0) / 2.0) ** 2)))
    return reference, middle - gust, middle, middle + 1.1 * gust


def write_responses(folder, made):
    time = np.linspace(0.0, DURATION, INSTANTS, endpoint=False)
    qualities = {"default": 1.0, made.tuned: 1.7, "p0103": 1.4}
    if not made.old:
        qualities = {"default": 1.0} | {f"p{100 + k:04d}": 1.1 + 0.9 / k for k in range(1, made.finalists + 1)}
    columns = {name: [] for name in ("point", "scenario", "signal", "unit")}
    series = {name: [] for name in ("time", "reference", "low", "median", "high", "worst")}
    for scenario in made.scenarios:
        for point, quality in qualities.items():
            for signal, unit in SIGNALS:
                reference, low, median, high = fan(made, signal, time, quality)
                for name, value in zip(columns, (point, scenario, signal, unit), strict=True):
                    columns[name] += [value] * len(time)
                worst = high + 0.3 * (high - low) * np.sin(time)
                for name, values in zip(series, (time, reference, low, median, high, worst), strict=True):
                    series[name].append(values)
    found = {name: in_codes(values) for name, values in columns.items()}
    found |= {name: np.concatenate(parts) for name, parts in series.items()}
    found["worst_flight"] = np.full(len(found["time"]), 17, dtype=np.int32)
    if made.old:
        del found["worst"], found["worst_flight"]
    (folder / "responses.npz").write_bytes(npz_bytes(found))


def write_constraints(folder, made, front):
    rows = ["point,label,value,low,high,difference,difference_low,difference_high"]
    for k, row in enumerate(front):
        rows.append(f"{row['point']},mean(failure),0,0,0,0,0,0")
        rows.append(
            f"{row['point']},quantile95(peak.tilt),{0.3 + 0.005 * k},{0.28 + 0.005 * k},{0.33 + 0.005 * k},{0.005 * k},0,0.1"
        )
    (folder / "constraints.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")


def write_margins(folder, made):
    """A double integrator with a delay under a lead, faster from point to point."""
    frequency = np.geomspace(0.05, 785.0, 120)
    rows = []
    for k in range(made.finalists + 1):
        for channel in CHANNELS:
            # x and y, roll and pitch are alike.
            rate = (1.0 + 0.05 * k) * {"x": 2.0, "y": 2.0, "z": 3.0, "roll": 12.0, "pitch": 12.0, "yaw": 8.0}[channel]
            s = 1j * frequency
            loop = (rate / s) ** 2 * (1.0 + 3.0 * s / rate) / (1.0 + s / (9.0 * rate)) * np.exp(-0.01 * s)
            rows.append(
                {
                    "point": f"p{100 + k:04d}" if k else "default",
                    "channel": channel,
                    "stable": True,
                    "gain_up": 4.0,
                    "gain_down": None,
                    "phase_margin": 0.7 + 0.01 * k,
                    "delay_margin": 0.03,
                    "ms": 1.5,
                    "mt": 1.3,
                    "disk": 0.8,
                    "crossover": 3.0 * rate,
                    "bandwidth": 2.0 * rate,
                    "case": "",
                    "frequency": frequency.tolist(),
                    "real": loop.real.tolist(),
                    "imag": loop.imag.tolist(),
                }
            )
    write_rows(folder / "margins.npz", rows)
