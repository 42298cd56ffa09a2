"""A made-up inference.json, with the keys that an inference writes; no flight behind it."""

import json

from tests.tuner.report.contest.fabricate_contest import ENVIRONMENT, STUDY
from tuner.documents.inference_document import InferenceDocument

KINDS = ("peak", "settling")


def spread(median, percentile):
    ends = {"low68": 0.8 * median, "high68": 1.2 * median, "low95": 0.6 * median, "high95": 1.5 * median}
    return {
        "mean": 1.02 * median,
        "median": median,
        **ends,
        "percentile": percentile,
        "inside": 2.5 <= percentile <= 97.5,
    }


def cell(contender, metric, unit, published, ours, percentile, consistent, reproducible):
    return {
        "contender": contender,
        "metric": metric,
        "kind": metric.partition(".")[0],
        "unit": unit,
        "scenario": "level",
        "published": published,
        "ours": spread(ours, percentile),
        "default": spread(0.37 * ours, 99.9),
        "percentile": percentile,
        "inside": 2.5 <= percentile <= 97.5,
        "consistent": consistent,
        "reproducible": reproducible,
        "ratio": ours / published,
        "tolerance": 0.3,
        "best_ratio": 0.61,
    }


def misfit(size, inside):
    parts = {"peak": 0.5 * size, "settling": size, "all": 0.8 * size}
    return {"search": parts, "held_out": {k: 1.1 * v for k, v in parts.items()}, "inside": inside, "ratios_inside": 1}


def unknown(name, unit, low, high, scale, default, inferred, verdict, at_end):
    return {
        "name": name,
        "unit": unit,
        "set": [f"contender.ADRC.gains.attitude.{name}"],
        "low": low,
        "high": high,
        "scale": scale,
        "default": default,
        "inferred": inferred,
        "near_low": 0.8 * inferred,
        "near_high": 1.3 * inferred,
        "low68": 0.9 * inferred,
        "high68": 1.2 * inferred,
        "share": 0.2,
        "at_end": at_end,
        "verdict": verdict,
    }


def inference(title="What the open values were"):
    return {
        "title": title,
        "description": "Made up for tests.",
        "study": "made.toml",
        "seed": 2025,
        "contenders": ["PID", "ADRC"],
        "flights": 123456,
        "wall_seconds": 61.2,
        "inferred": "p0123",
        "settings": {"flights": 32, "held_out": 256, "near": 0.1, "population": 32, "generations": 12, "tried": 523},
        "unknowns": [
            unknown("omega_c", "rad/s", 0.5, 10.0, "log", 2.5, 4.25, "told", False),
            unknown("zeta", "1", 0.4, 2.5, "linear", 1.0, 1.75, "loosely", True),
        ],
        "kinds": [{"metric": kind, "definition": f"what {kind} is"} for kind in KINDS],
        "cells": [
            cell("PID", "peak.roll", "rad", 0.088, 0.0812, 58.0, True, True),
            cell("ADRC", "peak.roll", "rad", 0.083, 0.0312, 99.2, True, True),
            cell("PID", "settling.yaw", "s", 17.267, 9.25, 100.0, False, False),
            cell("ADRC", "rms.yaw", "rad", 0.0042, 0.0011, 99.5, False, True),
        ],
        "ratios": [
            {
                "first": "PID",
                "second": "ADRC",
                "metric": "peak.roll",
                "scenario": "level",
                "published": 0.9432,
                "ours": spread(0.41, 99.0),
                "default": spread(0.2, 100.0),
                "percentile": 99.0,
                "inside": False,
                "consistent": False,
                "reproducible": False,
                "nearest": 0.77,
            },
        ],
        "misfit": {"default": misfit(1.4, 0), "inferred": misfit(0.6, 1)},
        "together": {"most": 2, "of": 3, "candidate": "p0044", "missed": []},
        "front": [{"candidate": "p0044", "unknowns": {}, **misfit(0.7, 2)}],
        "failures": [{"contender": "PID", "default": 0.0, "inferred": 0.0}],
        "words": ["At the inferred setting 1 of 3 published cells lie inside."],
    }


def fabricate_inference(folder, **changes):
    folder.mkdir(parents=True)
    files = {
        "inference.json": InferenceDocument.parse(json.dumps(inference() | changes)).text(),
        "environment.json": json.dumps(ENVIRONMENT),
    }
    for name, text in {**files, "study.toml": STUDY}.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder
