"""gains.json as the report's page makes it for another point: a valid document without what is true of one point alone."""

import json
import subprocess
from pathlib import Path

import tuner.report
from tests.clients import program
from tests.tuner.gains.making import document, whole_document, written
from tuner.gains.examining import examine

SCRIPT = Path(tuner.report.__file__).parent / "js" / "13_gains_file.js"
GLOBALS = """
const data = { tuned: "p0001", gains_file: process.argv[1], };
const patch = [{ kind: "objective", label: "mean(travel)", tuned: { value: 9.0, low: 8.9, high: 9.1 }, verdict: "better" }];
const point = { name: "p0002", gains: [7.5], patch }, byName = new Map([["p0002", { point }]]);
const variables = [{ addresses: ["roll.k2", "pitch.k2"] }];
"""


def page_text(made, name):
    script = f"{GLOBALS}{SCRIPT.read_text()}\nprocess.stdout.write(gainsText({json.dumps(name)}));"
    done = subprocess.run([program("node"), "-e", script, json.dumps(made)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_another_point_gets_a_valid_document(tmp_path):
    made = whole_document()
    told = json.loads(page_text(made, "p0002"))
    assert examine(written(tmp_path, told)).problems == []
    assert made.keys() - told.keys() == {"sha256", "margins", "cost", "exports"}
    assert told["gains"]["roll.k2"]["value"] == told["gains"]["pitch.k2"]["value"] == 7.5
    assert told["gains"]["yaw.k2"] == made["gains"]["yaw.k2"] and told["study"]["point"] == "p0002"
    assert told["objectives"][0]["tuned"] == {"value": 9.0, "low": 8.9, "high": 9.1}


def test_the_recommended_point_gets_the_file_as_it_is():
    made = document()
    assert page_text(made, "p0001") == json.dumps(made)
