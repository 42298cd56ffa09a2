"""What is saved with a result: every value in JSON, the same from one process to the next; and what its digest sees."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel

from plant.quadrotor.airframes import load
from plant.references import REFERENCES, parameters
from tests.tuner.study.study_text import STUDY, changed, write
from tuner.study.build import load_study
from tuner.study.schema import StudyTable

ROOT = Path(__file__).resolve().parents[3]
WAYPOINTS = changed('kind = "steps"\nx = 1.0\ntime = 0.5', 'kind = "waypoints"\npath = "points.csv"')


def missing(table: BaseModel, resolved: Any, key: str = "") -> list[str]:
    """Return the keys of the schema that a resolved document lacks, depth first."""
    gone = []
    for field, info in type(table).model_fields.items():
        name = info.serialization_alias or field
        here = f"{key}.{name}" if key else name
        if name not in resolved:
            gone.append(here)
            continue
        value = getattr(table, field)
        parts = value if isinstance(value, list) else [value]
        found = resolved[name] if isinstance(value, list) else [resolved[name]]
        for part, inner in zip(parts, found, strict=True):
            gone += missing(part, inner, here) if isinstance(part, BaseModel) else []
    return gone


def test_every_key_of_the_schema_appears(tmp_path: Path):
    # All flights first is as if nothing were said.
    study = load_study(write(tmp_path, changed("population = 8", "population = 8\nfirst = 2")))
    assert isinstance(study.table, StudyTable)
    # Digests of code stand where there is some, see test_own_code.py; a second rate where there is one, so that old digests hold;
    # what vehicles are drawn from where they are, points of earlier runs where a search starts from some, flights that may grow.
    assert missing(study.table, study.resolved()) == [
        "controller.position_every",
        "target",
        "scenario.spread.from",
        "law",
        "metric",
        "reference",
        "search.starts",
        "search.reference",
        "search.flight_growth",
    ]
    slower = load_study(write(tmp_path, changed('attitude = "hybrid"', 'attitude = "hybrid"\nposition_every = 2')))
    resolved: dict[str, Any] = slower.resolved()
    assert resolved["controller"]["position_every"] == 2


def test_it_is_json_and_survives_a_round_trip(tmp_path: Path):
    resolved = load_study(write(tmp_path, STUDY)).resolved()
    text = json.dumps(resolved, allow_nan=False)
    assert json.loads(text) == json.loads(json.dumps(load_study(write(tmp_path, STUDY)).resolved()))
    assert json.loads(text)["seed"] == 1


def test_defaults_are_written_out(tmp_path: Path):
    resolved: dict[str, Any] = load_study(write(tmp_path, STUDY)).resolved()
    (scenario,) = resolved["scenario"]
    assert resolved["controller"]["control_period"] == 0.004
    assert resolved["limits"] == {"position": 5.0, "tilt_deg": 80.0}
    assert scenario["sensors"]["rate"] == 0.01
    assert scenario["air"]["roughness"] == "C"
    assert set(scenario["reference"]) == {"kind"} | {entry.name for entry in parameters(REFERENCES["steps"])}
    assert scenario["reference"]["yaw_deg"] == 0.0
    assert resolved["gains"]["roll.k1"] == 20.0
    assert resolved["gains"]["x.zeta"] == 1.0
    assert resolved["variables"][0]["addresses"] == ("roll.lambda", "pitch.lambda")


def test_the_airframe_is_there_with_units_and_sources(tmp_path: Path):
    resolved: dict[str, Any] = load_study(write(tmp_path, STUDY)).resolved()
    airframe = resolved["airframe"]
    sources = load("hummingbird").sources
    assert airframe["name"] == "hummingbird"
    assert set(airframe["numbers"]) == set(sources)
    assert airframe["numbers"]["mass"] == {"value": 0.698, "unit": "kg", "source": sources["mass"].source}


def test_waypoints_are_saved_by_value(tmp_path: Path):
    (tmp_path / "points.csv").write_text("t,x,y,z\n0,0,0,0\n1,1,0,0\n", encoding="utf-8")
    resolved: dict[str, Any] = load_study(write(tmp_path, WAYPOINTS)).resolved()
    reference = resolved["scenario"][0]["reference"]
    assert reference["path"] == "points.csv"
    assert json.loads(json.dumps(reference["points"])) == [[0, 0, 0, 0, 0], [1, 1, 0, 0, 0]]


def digest(folder: Path, text: str = STUDY) -> str:
    return load_study(write(folder, text)).digest()


def test_the_digest_is_in_the_document(tmp_path: Path):
    study = load_study(write(tmp_path, STUDY))
    assert study.resolved()["digest"] == study.digest()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("seed = 1", "seed = 2"),
        ('"hummingbird"', '"iris"'),
        ('"hybrid"', '"hybrid"\nposition = "pid"'),
        ('"hybrid"', '"hybrid"\ndelay = true'),
        ("high = 16", "high = 17"),
        ("high = 16 }", 'high = 16, scale = "linear" }'),
        ('"roll.k1" = 20.0', '"roll.k1" = 21.0'),
        ('"roll.k1" = 20.0', '"yaw.lambda" = { tie = "tilt.lambda" }'),
        ("duration = 2.0", "duration = 2.4"),
        ("search = 4", "search = 5"),
        ("held_out = 8", "held_out = 9"),
        ("x = 1.0", "x = 1.5"),
        ('"light"', '"none"'),
        ("mass = 0.1", "mass = 0.2"),
        ("level = 0.9", "level = 0.8"),
        ("max = 0.0", "max = 0.1"),
        ("population = 8", "population = 10"),
        ("population = 8", 'population = 8\nalgorithm = "nsga2"'),
        ("population = 8", "population = 8\nfirst = 2"),
        ('"knee"', '"closest"'),
    ],
)
def test_the_digest_sees_what_decides_the_result(old: str, new: str, tmp_path: Path):
    assert digest(tmp_path, changed(old, new)) != digest(tmp_path)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('title = "Test"', 'title = "Another"\ndescription = "of the same"'),
        ("seed = 1", "# a comment\nseed = 1"),
        ("x = 1.0", "x = 1"),
        ("x = 1.0", "x = 1.0\ny = 0.0"),
        ("mass = 0.1", "mass = 0.1\nlag = 0.2"),
        ("population = 8", 'population = 8\nalgorithm = "gaussian_process"'),
        ("population = 8", "population = 8\nfirst = 4"),
    ],
)
def test_the_digest_does_not_see_what_changes_nothing(old: str, new: str, tmp_path: Path):
    assert digest(tmp_path, changed(old, new)) == digest(tmp_path)


def test_the_digest_sees_into_the_files_beside_the_study(tmp_path: Path):
    points, frame = tmp_path / "points.csv", tmp_path / "mine.toml"
    numbers = load("hummingbird").path.read_text(encoding="utf-8")
    text = changed('name = "hummingbird"', 'file = "mine.toml"', WAYPOINTS)
    seen = []
    for x, mass in ((1, "0.698"), (2, "0.698"), (1, "0.699")):
        points.write_text(f"t,x,y,z\n0,0,0,0\n1,{x},0,0\n", encoding="utf-8")
        assert numbers.count("value = 0.698,") == 1
        frame.write_text(numbers.replace("value = 0.698,", f"value = {mass},"), encoding="utf-8")
        seen.append(digest(tmp_path, text))
    assert len(set(seen)) == 3


def test_the_digest_does_not_see_how_such_a_file_is_called(tmp_path: Path):
    for name in ("points.csv", "moved.csv"):
        (tmp_path / name).write_text("t,x,y,z\n0,0,0,0\n1,1,0,0\n", encoding="utf-8")
    assert digest(tmp_path, changed("points.csv", "moved.csv", WAYPOINTS)) == digest(tmp_path, WAYPOINTS)


def test_another_process_finds_the_same(tmp_path: Path):
    path = write(tmp_path, STUDY)
    code = (
        "import json, sys; from pathlib import Path; from tuner.study.build import load_study; "
        "print(json.dumps(load_study(Path(sys.argv[1])).resolved()))"
    )
    # Another hash seed walks sets in another order.
    environment = os.environ | {"PYTHONHASHSEED": "12345", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == json.dumps(load_study(path).resolved())
