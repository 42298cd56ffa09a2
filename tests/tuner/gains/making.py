"""Gains documents to test with: of any two laws and any airframe, with every section filled."""

import json
from functools import cache

from plant.law_registry import LAWS
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions
from tuner.gains import Controller, content_hash, to_document

SECTIONS = {
    "vehicle": {
        "target": "px4", "target_version": "PX4 1.16", "file": "quad.params", "sha256": 64 * "b",
        "settings": [{"name": "thrust_curve", "value": "1"}],
        "parameters": [{"name": "MC_ROLL_P", "value": 6.5}, {"name": "MC_ROLLRATE_D", "value": 0.003}],
        "kept": ["MC_ROLLRATE_D"],
    },
    "study": {"name": "a.toml", "title": "A", "seed": 7, "digest": "6e88f077f95289f1bd3efec4", "point": "p0001"},
    "objectives": [
        {
            "label": "mean(travel)", "unit": "s-1", "kind": "objective", "limit": None,
            "default": {"value": 18.4, "low": 18.3, "high": 18.5}, "tuned": {"value": 9.2, "low": 9.1, "high": 9.3},
            "difference": {"value": -9.2, "low": -9.4, "high": -9.0}, "verdict": "better",
            "interval": {"level": 0.95, "n": 64, "method": "bootstrap"},
        },
        {
            "label": "ms", "unit": "1", "kind": "requirement", "limit": 2.0,
            "default": {"value": 5.6, "low": None, "high": None}, "tuned": {"value": None, "low": None, "high": None},
            "difference": {"value": None, "low": None, "high": None}, "verdict": "broken",
        },
    ],
    "design": [
        {"axis": "roll", "designed": True, "why": "", "load_rejection": {"value": 60.0, "unit": "s-3"}},
        {"axis": "yaw", "designed": False, "why": "no law", "load_rejection": None},
    ],
    "margins": [
        {
            "loop": "roll", "break_at": "plant input", "method": "describing function", "amplitude": "amplitude 0.1",
            "stable": True, "gain_up": {"value": 3.2, "unit": "1"}, "phase_margin": {"value": 0.7, "unit": "rad"},
            "crossover": {"value": 14.0, "unit": "rad/s"}, "delay_margin": {"value": 0.01, "unit": "s"},
        },
        {"loop": "x", "break_at": "demand of the position loop", "method": "linearised", "stable": False},
    ],
    "cost": [
        {
            "target": "cortex-m4f -O2", "tool": "qemu", "instructions": {"value": 223.1, "unit": "1"},
            "bytes": {"value": 1000, "unit": "By"},
        }
    ],
    "exports": [
        {"target": "c99", "target_version": "C99", "file": "gains.h", "sha256": 64 * "a", "lossy": ["float32"]}
    ],
    "x-note": {"anything": [1, "two", None]},
}  # fmt: skip


def neighbour(law: str) -> str:
    """Return the law behind one in the registry; behind the last stands the first."""
    names = list(LAWS)
    return names[(names.index(law) + 1) % len(names)]


@cache
def airframe(name="hummingbird"):
    return load(name, allow_unphysical=True)


def controller(position="ladrc", attitude="hybrid", frame="hummingbird"):
    cascade = close_cascade(LAWS[position], LAWS[attitude])
    return Controller(airframe(frame), cascade, ControlOptions(), 0.004, 0.001, tuple(default_row(cascade)))


def document(position="ladrc", attitude="hybrid", frame="hummingbird", **sections):
    """The document of default gains as a reader of JSON finds it."""
    return json.loads(json.dumps(to_document(controller(position, attitude, frame), sections)))


def whole_document():
    return document(**SECTIONS)


def rehashed(made):
    """The same with a right hash, where it has one."""
    return made | {"sha256": content_hash(made)} if "sha256" in made else made


def written(folder, made, name="gains.json"):
    file = folder / name
    file.write_text(json.dumps(made), encoding="utf-8")
    return file
