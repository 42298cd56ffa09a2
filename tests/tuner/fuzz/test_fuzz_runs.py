"""What is read also runs: hostile studies and gains go through the command line to its end and leave nothing lying about.

Only studies whose kernel is compiled already and that are over in a second are run; the others were read, and that is all.
Here a few; several hundred: pytest -m slow tests/tuner/fuzz.
"""

import json
import shutil
import tomllib
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant.output_files import ASIDE
from tests.tuner.conftest import QUICKSTART, NoDrawing
from tests.tuner.fuzz.fuzzing import fuzzed, outcome, patience
from tests.tuner.fuzz.hostile import mutated, shaken
from tests.tuner.fuzz.hostile_text import json_of, toml_of
from tests.tuner.in_process import tuner
from tuner.experiments.tuning.problem import problem_of
from tuner.gains import read_gains, to_document
from tuner.study.build import load_study
from tuner.study.kinds import load_any
from tuner.study.size import flight_steps
from tuner.study.study import Study

# A run of two generations of eight, two flights each of a fifth of a second, is one of 16 000 plant steps.
MAX_STEPS, MAX_CANDIDATES = 400_000, 64
SHORT = {
    ("search", "population"): 8, ("search", "generations"): 2, ("scenario", 0, "search"): 2, ("scenario", 0, "held_out"): 2,
    ("scenario", 0, "duration"): 0.2, ("scenario", 0, "reference", "time"): 0.1,
}  # fmt: skip
RUN_PATIENCE = 120


# What else a study may say, so that it can be changed too.
MORE = {
    "limits": {"position": 5.0, "tilt_deg": 80.0},
    "gains": {
        "attitude.lambda": {"low": 2.0, "high": 14.0}, "tilt.k2": {"low": 1.0, "high": 30.0, "scale": "linear"}, "yaw.k2": 5.0,
        "position.omega_c": {}, "position.omega_o": 6.0, "attitude.k1": 3.0, "attitude.delta": 0.05,
    },
    "pick": {"rule": "min:travel"},
}  # fmt: skip
MORE_FLOWN = {
    "sensors": {"position": 0.002, "velocity": 0.01, "attitude": 0.002, "rate": 0.01},
    "bands": {"settling": 0.05, "position": 0.1, "attitude": 0.035},
    "steady_share": 0.2,
}
GUST = {"amplitude": 3.0, "start": 0.05, "length": 0.1}


def short_study():
    table = tomllib.loads(QUICKSTART.read_text()) | MORE
    table["scenario"][0] |= MORE_FLOWN
    table["scenario"][0]["air"] |= {"gust": GUST, "vehicle_speed": 1.0, "minimum_airspeed": 1.5, "span": 0.34}
    for (*path, key), value in SHORT.items():
        here = table
        for part in path:
            here = here[part]
        here[key] = value
    return table


def is_short(study):
    """Whether a study can be run here: one controller, whose kernel is there, and few steps."""
    if not isinstance(study, Study) or study.search.population * study.search.generations > MAX_CANDIDATES:
        return False
    candidates = study.search.population * study.search.generations
    timing = study.system.timing
    flights = [
        (flight_steps(entry.spec, timing), candidates * entry.search + candidates * entry.held_out)
        for entry in study.scenarios
    ]
    if sum(steps * count for steps, count in flights) > MAX_STEPS or any(count > 2000 for _, count in flights):
        return False
    return problem_of(study, 1, None).flyer.cached


def files_in(folder):
    return {file.relative_to(folder).as_posix(): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def told_well(code, out, err, codes):
    assert code in codes, (code, err[-2000:])
    assert "Traceback" not in err + out and "Warning:" not in err
    # Gains whose airframe is not the bundled one of its name say so.
    err = "".join(line for line in err.splitlines(keepends=True) if not line.startswith("Note: "))
    assert code != 2 or (err.startswith("Error: ") and err.count("\n") == 1 and err.strip().isprintable()), err


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """An empty folder that is the working directory; the figures, which take most of a short run's time, are left out."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("tuner.report.start_figures", lambda folder: NoDrawing())
    return tmp_path


def run_one(desk, text, monkeypatch, capsys):
    """Run a study file; return how it ended."""
    path, out = desk / "hostile.toml", desk / "out"
    path.write_text(text, encoding="utf-8")
    if outcome(load_any, path) == "refused":
        return "refused"
    if not is_short(load_any(path)):
        return "read"
    before = files_in(desk)
    with patience(RUN_PATIENCE):
        code, said, err = tuner(monkeypatch, capsys, "run", path, "--out", out, "--threads", 2)
    told_well(code, said, err, (0, 2))
    left = files_in(desk)
    if code == 2:
        assert left == before, "a refused run leaves files behind"
        return "refused late"
    assert {name: left[name] for name in before} == before
    assert all(name.startswith("out/") for name in left.keys() - before.keys())
    assert not [name for name in left if name.endswith(ASIDE)]
    json.loads(left["out/summary.json"], parse_constant=pytest.fail)
    assert {"out/report.html", "out/gains.json", "out/front.csv"} <= left.keys()
    read_gains(out / "gains.json")
    shutil.rmtree(out)
    return "run"


def run_hostile(examples, desk, tmp_path_factory, monkeypatch, capsys):
    tally, table = Counter(), short_study()

    @fuzzed(examples, tmp_path_factory.mktemp("hypothesis"))
    @given(st.one_of(mutated(table), shaken(table), shaken(table)))
    def attempt(hostile):
        tally[run_one(desk, toml_of(hostile), monkeypatch, capsys)] += 1

    attempt()
    return tally


def with_values(gains, values):
    return {address: gain | {"value": values[address]} for address, gain in gains.items()}


def fly_hostile(examples, desk, tmp_path_factory, monkeypatch, capsys):
    study = load_study(QUICKSTART)
    document = to_document(study.controller(study.default_row), {})
    # With a hash every change would be refused for that alone.
    del document["sha256"], document["airframe"]["sha256"]
    path, tally = desk / "gains.json", Counter()
    # Numbers that may be changed without contradicting the rest.
    values = {address: gain["value"] for address, gain in document["gains"].items()}
    free = shaken(values).map(lambda changed: document | {"gains": with_values(document["gains"], changed)})

    @fuzzed(examples, tmp_path_factory.mktemp("hypothesis"))
    @given(
        st.one_of(mutated(document), shaken(document), free, free),
        st.sampled_from(["fly", "margins", "theory", "check"]),
    )
    def attempt(hostile, command):
        path.write_text(json_of(hostile), encoding="utf-8")
        if outcome(read_gains, path) == "refused":
            tally["refused"] += 1
            return
        words = {"fly": ["--seeds", 2], "check": ["--requirements", desk / "asked.toml", "--seeds", 2]}.get(command, [])
        controller = read_gains(path)
        if {controller.cascade.position.name, controller.cascade.attitude.name} != {"ladrc", "hybrid"}:
            tally["read"] += 1
            return
        before = files_in(desk)
        with patience(RUN_PATIENCE):
            code, said, err = tuner(monkeypatch, capsys, command, path, *words, "--json")
        told_well(code, said, err, (0, 1, 2))
        assert files_in(desk) == before
        tally[f"{command} {code}"] += 1
        if code != 2:
            json.loads(said, parse_constant=pytest.fail)

    (desk / "asked.toml").write_text(toml_of(short_study()))
    attempt()
    return tally


def test_hostile_studies_run(desk, tmp_path_factory, monkeypatch, capsys):
    run_hostile(8, desk, tmp_path_factory, monkeypatch, capsys)


def test_hostile_gains_fly(desk, tmp_path_factory, monkeypatch, capsys):
    fly_hostile(10, desk, tmp_path_factory, monkeypatch, capsys)


@pytest.mark.slow
def test_many_hostile_studies_run(desk, tmp_path_factory, monkeypatch, capsys):
    tally = run_hostile(400, desk, tmp_path_factory, monkeypatch, capsys)
    with capsys.disabled():
        print(f"\nstudies through `tuner run`: {dict(tally)}")
    assert tally["run"] >= 40


@pytest.mark.slow
def test_many_hostile_gains_fly(desk, tmp_path_factory, monkeypatch, capsys):
    tally = fly_hostile(250, desk, tmp_path_factory, monkeypatch, capsys)
    with capsys.disabled():
        print(f"\ngains through fly, margins, theory, check: {dict(tally)}")
    assert sum(count for name, count in tally.items() if name.endswith((" 0", " 1"))) >= 40
