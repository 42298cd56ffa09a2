"""A made-up contest folder with plausible numbers, written as a contest writes it; no flight behind it."""

import csv
import json
from dataclasses import dataclass, field
from itertools import combinations
from pathlib import Path

import numpy as np

from tuner.extensions.contests.documents import ContestDocument
from tuner.store.columns import stacked
from tuner.store.npz import npz_bytes

ALL = ("PID", "ADRC", "A-ST-SMC", "PID (other)", "ADRC (other)")
LAWS = {"PID": "pid", "ADRC": "ladrc", "A-ST-SMC": "hybrid", "PID (other)": "pid", "ADRC (other)": "ladrc"}
# What each has of every disturbance and error.
SHARES = {"PID": 1.0, "ADRC": 0.7, "A-ST-SMC": 0.45, "PID (other)": 1.1, "ADRC (other)": 0.75}
GAINS = {
    "pid": {"kp": (57.17291212843563, "s^-2"), "kd": (10.954421757755522, "s^-1")},
    "ladrc": {"omega_c": (7.214875428763568, "rad/s"), "omega_o": (11.928332485044788, "rad/s")},
    "hybrid": {"lambda": (7.852243572280327, "s^-1"), "k1": (3.2630369291812844, "rad^(1/2) s^(-3/2)")},
}
FLIGHTS = {"gusts": 40, "level": 24}
AXES = ("x", "y", "z", "roll", "pitch", "yaw")
SIGNALS = {name: "m" for name in "xyz"} | {name: "rad" for name in AXES[3:]} | {f"rotor{i}": "1" for i in range(1, 5)}
AIR = {f"wind_{axis}": "m/s" for axis in "xyz"} | {f"angular_acceleration_{axis}": "rad/s^2" for axis in "xyz"}


def quantity(metric, unit, size, kind, scenario=None, risk="mean", limit=None):
    label = f"{risk}({metric})" + (f"@{scenario}" if scenario else "")
    said = "mean over scenarios" if risk == "mean" else "mean of the worst share 1 - `level` of the scenarios"
    row = {
        "label": label,
        "metric": metric,
        "unit": unit,
        "risk": risk.rstrip("0123456789"),
        "level": None,
        "scenario": scenario,
        "definition": f"what {metric} is",
        "risk_definition": said,
        "kind": kind,
        "limit": limit,
    }
    return row, size


QUANTITIES = (
    quantity("itae.position", "m", 0.4, "objective", risk="cvar80"),
    quantity("travel", "1/s", 20.0, "objective"),
    quantity("ise.yaw", "rad^2 s", 3e-7, "objective", "gusts"),
    quantity("failure", "1", 0.0, "constraint", limit=0.0),
    quantity("peak.tilt", "rad", 0.3, "constraint", "gusts", limit=0.2),
    quantity("peak.roll", "rad", 0.08, "published", "level"),
    quantity("settling.yaw", "s", 6.0, "published", "level"),
    quantity("rms.z", "m", 0.03, "claimed", "gusts"),
)
PRINTED = {
    "peak.roll": {"PID": 0.088, "ADRC": 0.083, "A-ST-SMC": 0.034},
    "settling.yaw": {"PID": 17.267, "ADRC": 8.873, "A-ST-SMC": 6.326},
}
ENVIRONMENT = {
    "gainproof": "0.1.0", "numpy": "2.4.6", "python": "3.11.9", "platform": "Linux-6.1", "threads": 4, "commit": "873a14b",
    "cpu": "AMD EPYC 9R14", "simd": "avx512", "started": "2025-11-21T02:41:04+00:00", "command": "tuner run studies/made.toml",
}  # fmt: skip
STUDY = """title = "made up"
[[scenario]]
name = "gusts"
reference = { kind = "steps" }
[[scenario]]
name = "level"
reference = { kind = "level" }
"""


@dataclass
class Made:
    """What a fabricated contest knows of itself. objectives: how many of the first quantities are objectives with fronts; lost: how
    many points of each front lost two flights.
    """

    names: tuple[str, ...] = ALL[:3]
    title: str = "Three controllers in gusts"
    objectives: int = 2
    tuned: bool = True
    lost: int = 0
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(20250509))

    @property
    def quantities(self):
        return [row for row in QUANTITIES if row[0]["kind"] != "objective"][:0] + [
            (
                row | {"kind": "objective" if i < self.objectives else "claimed"}
                if row["kind"] == "objective"
                else row,
                size,
            )
            for i, (row, size) in enumerate(QUANTITIES)
        ]

    @property
    def labels(self):
        return [row["label"] for row, _ in self.quantities[: self.objectives]]


def fabricate(folder: Path, made=None, without=(), **changes):
    """Write a contest folder and return its path.

    without: files that it does not have. changes: keys of contest.json that are something else.
    """
    made = made or Made()
    scores = {
        (name, row["label"]): flown(made, name, row, size) for name in made.names for row, size in made.quantities
    }
    fronts = {name: front(made, name) for name in made.names} if made.tuned else {}
    document = ContestDocument.parse(json.dumps(contest_document(made, scores, fronts) | changes))
    writers = {
        "study.toml": lambda file: file.write_text(STUDY, encoding="utf-8"),
        "environment.json": lambda file: file.write_text(json.dumps(ENVIRONMENT), encoding="utf-8"),
        "contest.json": lambda file: file.write_text(document.text(), encoding="utf-8"),
        "scores.npz": lambda file: file.write_bytes(npz_bytes(score_table(made, scores))),
        "fronts.csv": lambda file: write_csv([row for rows in fronts.values() for row in rows], file),
        "responses.npz": lambda file: file.write_bytes(npz_bytes(response_table(made))),
        "traces.npz": lambda file: file.write_bytes(npz_bytes(trace_table(made))),
        "wind.npz": lambda file: file.write_bytes(npz_bytes(air_table(made))),
    }
    folder.mkdir(parents=True)
    for name, write in writers.items():
        if name not in without and (made.tuned or name != "fronts.csv"):
            write(folder / name)
    return folder


def rewrite(folder, change):
    """Change contest.json of a folder with a function of its content."""
    file = folder / "contest.json"
    content = json.loads(file.read_text(encoding="utf-8"))
    change(content)
    file.write_text(json.dumps(content), encoding="utf-8")


def flown(made, name, row, size):
    count = FLIGHTS[row["scenario"]] if row["scenario"] else sum(FLIGHTS.values())
    share = 2.0 - SHARES[name] if row["metric"] == "travel" else SHARES[name]
    return size * share * made.rng.gamma(9.0, 1.0 / 9.0, count)


def spread(values):
    """Mean with a normal interval, which need not be the bootstrap's."""
    half = 1.96 * np.std(values, axis=0) / np.sqrt(len(values))
    return {
        "value": float(np.mean(values, axis=0)),
        "low": float(np.mean(values) - half),
        "high": float(np.mean(values) + half),
    }


def contest_document(made, scores, fronts):
    quantities = [row for row, _ in made.quantities]
    return {
        "title": made.title,
        "description": "Made up for tests.",
        "study": "made.toml",
        "seed": 2025,
        "flights": 38400,
        "stream": "confirmation",
        "compared_on": [{"scenario": name, "flights": n, "duration": 10.0} for name, n in FLIGHTS.items()],
        "wall_seconds": 72.4,
        "contenders": [contender(made, name) for name in made.names],
        "quantities": quantities,
        "estimates": [
            {"contender": name, "quantity": label, **spread(values)} for (name, label), values in scores.items()
        ],
        "differences": [
            difference(first, second, row["label"], scores)
            for row in quantities
            for first, second in combinations(made.names, 2)
        ],
        "fronts": fronts_part(made, fronts) if fronts else None,
        "best_under": best_under(made, fronts) if fronts and made.objectives == 2 else [],
        "published": [cell(name, row, scores) for row in quantities if row["metric"] in PRINTED for name in made.names],
        "claims": [claim(made, scores)] if len(made.names) > 1 else [],
        "words": [
            "cvar80(itae.position): A-ST-SMC has the lowest value, 0.18 m.",
            'The claim "The last is best" fails: of 2.',
        ],
        "warnings": ["cvar80(itae.position) rests on 8 search scenarios."],
    }


def contender(made, name):
    law = LAWS[name]
    gains = {f"{axis}.omega_c": {"value": 1.2761355905816194, "unit": "rad/s"} for axis in AXES[:3]}
    gains |= {f"{axis}.{key}": {"value": v, "unit": unit} for axis in AXES[3:] for key, (v, unit) in GAINS[law].items()}
    if law == "ladrc":
        gains["yaw.omega_o"] = {"value": 3.5, "unit": "rad/s"}
    end = {
        "variable": "attitude.kp",
        "end": "high",
        "bound": 60.0,
        "value": 57.2,
        "recommended": True,
        "share": 0.25,
        "natural": False,
    }
    return {
        "name": name,
        "slug": "".join(c if c.isalnum() else "-" for c in name.lower()),
        "laws": {"position": "ladrc", "attitude": law},
        "airframe": "iris" if "other" in name else "hummingbird",
        "tuned": made.tuned,
        "folder": f"contenders/{name.lower()}" if made.tuned else None,
        "point": "p0073" if made.tuned else "given",
        "budget": None,
        "gains": gains,
        "searched": [f"attitude.{key}" for key in GAINS[law]] if made.tuned else [],
        "cost": {"operations": 100 + 3 * len(law), "position": 34, "attitude": 25, "meaning": "counted instructions"},
        "on_bounds": [end] if law == "pid" and made.tuned else [],
        "failures": 0.0,
    }


def difference(first, second, label, scores):
    found = spread(scores[second, label] - scores[first, label])
    lower = second if found["high"] < 0.0 else first if found["low"] > 0.0 else None
    row = {"first": first, "second": second, "quantity": label, "difference": found["value"]}
    return row | {
        "low": found["low"],
        "high": found["high"],
        "verdict": f"{lower} is lower" if lower else "not distinguishable",
        "lower": lower,
    }


def cell(name, row, scores):
    values = scores[name, row["label"]]
    value = PRINTED[row["metric"]][name.removesuffix(" (other)")]
    low, median, high = np.quantile(values, [0.025, 0.5, 0.975], axis=0).tolist()
    percentile = 100.0 * float(np.mean(values < value, axis=0))
    return {
        "contender": name,
        "contenders": [name],
        "metric": row["metric"],
        "unit": row["unit"],
        "scenario": row["scenario"],
        "quantity": row["label"],
        "value": value,
        "source": "Table 3",
        "fitted": name == "PID" and row["metric"] == "peak.roll",
        "mean": float(np.mean(values, axis=0)),
        "low": 0.0,
        "high": 0.0,
        "p2_5": low,
        "median": median,
        "p97_5": high,
        "percentile": percentile,
        "inside": 2.5 <= percentile <= 97.5,
    }


def claim(made, scores):
    better, label = made.names[-1], "mean(rms.z)@gusts"
    rows = []
    for than in made.names[:-1]:
        found = difference(than, better, label, scores)
        verdict = {better: "survives", than: "fails", None: "undecided"}[found["lower"]]
        rows.append(
            {
                "than": than,
                "quantity": label,
                **{k: found[k] for k in ("difference", "low", "high")},
                "verdict": verdict,
            }
        )
    return {
        "text": "The last is best",
        "better": better,
        "than": list(made.names[:-1]),
        "verdict": "fails",
        "rows": rows,
    }


def front(made, name):
    """Rows of fronts.csv of one contender, on a convex curve."""
    count = 7
    trade = np.linspace(0.5, 2.0, count)
    columns = [trade, 1.0 / trade, 0.5 + made.rng.uniform(size=count)][: made.objectives]
    rows = []
    for n in range(count):
        row = {"contender": name, "point": f"p{70 + n:04d}", "candidate": 70 + n, "recommended": n == 3}
        row["lost"] = 2 if n < made.lost else 0
        for label, (_, size), column in zip(made.labels, made.quantities, columns, strict=False):
            value = float(size * SHARES[name] * column[n])
            row |= {f"value:{label}": value, f"low:{label}": 0.9 * value, f"high:{label}": 1.15 * value}
        gains = contender(made, name)["gains"]
        rows.append(row | {f"gain:{address}": entry["value"] * (1.0 + 0.01 * n) for address, entry in gains.items()})
    return rows


def fronts_part(made, fronts):
    shares = {
        name: {"value": 0.9 - 0.05 * i, "low": 0.8 - 0.05 * i, "high": 0.95 - 0.05 * i} for i, name in enumerate(fronts)
    }
    names = list(fronts)
    pairs = [
        {"first": a, "second": b, "difference": -0.05, "low": -0.1, "high": 0.0, "larger": a if b == names[1] else None}
        for a, b in combinations(names, 2)
    ]
    sizes = dict(zip(made.labels, (size for _, size in made.quantities), strict=False))
    return {
        "objectives": made.labels,
        "ideal": dict.fromkeys(made.labels, 0.0),
        "reference": {k: 2.2 * v for k, v in sizes.items()},
        "meaning": "share of the box",
        "sizes": [{"contender": name, "points": len(rows)} for name, rows in fronts.items()],
        "hypervolume": [{"contender": name, **share} for name, share in shares.items()],
        "differences": pairs,
    }


def best_under(made, fronts):
    """Two questions; nobody keeps the limit of the second."""
    wanted, held = made.labels
    rows = []
    for name, points in fronts.items():
        best = points[2]
        ends = {"value": best[f"value:{wanted}"], "low": best[f"low:{wanted}"], "high": best[f"high:{wanted}"]}
        rows.append({"contender": name, **ends, "point": best["point"]})
    none = [{"contender": name, "value": None, "low": None, "high": None, "point": None} for name in fronts]
    return [
        {"objective": wanted, "subject_to": held, "limit": 15.25, "rows": rows},
        {"objective": held, "subject_to": wanted, "limit": 1e-3, "rows": none},
    ]


def write_csv(rows, file):
    names = list(dict.fromkeys(key for row in rows for key in row))
    with open(file, "w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, names, lineterminator="\n", restval="")
        writer.writeheader()
        writer.writerows(rows)


def long_table(parts):
    """Stack (names, columns) into one long table: names are repeated for every row of the columns."""
    return stacked({**names, **columns} for names, columns in parts)


def score_table(made, scores):
    scenario = {row["label"]: row["scenario"] for row, _ in made.quantities}
    parts = []
    for (name, label), values in scores.items():
        wanted = [scenario[label]] if scenario[label] else list(FLIGHTS)
        start = 0
        for where in wanted:
            count = FLIGHTS[where]
            rows = {"flight": np.arange(count), "value": values[start : start + count]}
            parts.append(({"contender": name, "quantity": label, "scenario": where}, rows))
            start += count
    return long_table(parts)


def asked(signal, scenario, time, name):
    if signal.startswith("rotor"):
        return np.full(len(time), np.nan)
    if signal in ("roll", "pitch") and scenario == "gusts":
        return 0.02 * SHARES[name] * np.sin(time)
    return 1.0 * (time >= 1.0) if signal == "x" and scenario == "gusts" else np.zeros(len(time))


def answer(signal, scenario, time, name):
    """One flight: what was asked for, late, and an error that the share of the contender scales."""
    base = 1.0 if signal.startswith("rotor") else np.nan_to_num(asked(signal, scenario, time - 0.2, name))
    return base + 0.05 * SHARES[name] * np.exp(-time / 4.0) * np.sin(2.0 * time + len(signal))


def response_table(made):
    time = np.arange(0.0, 10.0, 0.025)
    parts = []
    for scenario in FLIGHTS:
        for name in made.names:
            for signal, unit in SIGNALS.items():
                middle = answer(signal, scenario, time, name)
                band = {"low": middle - 0.04 * SHARES[name], "median": middle, "high": middle + 0.05 * SHARES[name]}
                names = {"point": name, "scenario": scenario, "signal": signal, "unit": unit}
                parts.append((names, {"time": time, "reference": asked(signal, scenario, time, name), **band}))
    return long_table(parts)


def trace_table(made):
    time = np.arange(0.0, 10.0, 0.05)
    return long_table(
        (
            {"contender": name, "scenario": scenario, "flight": 0, "signal": signal, "unit": unit},
            {
                "time": time,
                "value": answer(signal, scenario, time, name),
                "reference": asked(signal, scenario, time, name),
            },
        )
        for scenario in FLIGHTS
        for name in made.names
        for signal, unit in SIGNALS.items()
    )


def air_table(made):
    """Wind in gusts, injected angular accelerations where level is held; nowhere any vertical wind."""
    time = np.arange(0.0, 10.0, 0.02)
    parts = []
    for scenario in FLIGHTS:
        for signal, unit in AIR.items():
            blows = signal.startswith("wind") == (scenario == "gusts") and signal != "wind_z"
            value = made.rng.normal(size=len(time)) * blows
            names = {"scenario": scenario, "flight": 0, "signal": signal, "unit": unit}
            parts.append((names, {"time": time, "value": value}))
    return long_table(parts)
