"""Any study, contest, airframe or gains file is either read or refused in one line that names a place in it.

Hypothesis changes good files in their structure and breaks them as text. Here a short share of it; 2,600 files:
pytest -m slow tests/tuner/fuzz.
"""

import json
import shutil
import tomllib
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant.quadrotor.airframes import load
from tests.tuner.fuzz.fuzzing import STUDIES, fuzzed, outcome
from tests.tuner.fuzz.hostile import broken, mutated
from tests.tuner.fuzz.hostile_text import json_of, toml_of
from tuner.gains import read_gains, to_document
from tuner.study.build import load_study
from tuner.study.kinds import load_any

CONTESTS = ["contest.toml", "paper_table3.toml"]
TUNINGS = sorted(file.name for file in STUDIES.glob("*.toml") if file.name not in CONTESTS)
# Files of each kind: in the short profile, in the long one, and the least share of them that is read and that is refused.
PROFILES = {
    "study": (80, 1000, 0.05, 0.5),
    "contest": (30, 300, 0.05, 0.5),
    "study text": (50, 400, 0.1, 0.3),
    "airframe": (30, 300, 0.02, 0.3),
    "gains": (60, 400, 0.03, 0.3),
    "gains text": (20, 100, 0.0, 0.3),
}  # fmt: skip


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    """A folder with all bundled studies, an airframe's table and the document of a gains file."""
    folder = tmp_path_factory.mktemp("desk")
    for file in [*STUDIES.glob("*.toml"), *STUDIES.glob("*.py")]:
        shutil.copy(file, folder / file.name)
    study = load_study(STUDIES / "quickstart.toml")
    gains = to_document(study.controller(study.default_row), {"study": {"title": study.title}, "objectives": []})
    # With a hash every change would be refused for that alone.
    del gains["sha256"], gains["airframe"]["sha256"]
    return folder, tomllib.loads(study.airframe.path.read_text()), gains


def hostile_file(data, kind, desk):
    """Write a hostile file of a kind; return how to read it, and its path."""
    folder, airframe, gains = desk
    path = folder / "hostile.toml"
    if kind == "gains":
        path.write_text(json_of(data.draw(mutated(gains))), encoding="utf-8")
        return read_gains, path
    if kind == "gains text":
        path.write_bytes(data.draw(broken(json.dumps(gains).encode())))
        return read_gains, path
    if kind == "airframe":
        path.write_text(toml_of(data.draw(mutated(airframe))), encoding="utf-8")
        return load, path
    names = CONTESTS if kind == "contest" else TUNINGS
    source = STUDIES / data.draw(st.sampled_from(names))
    if kind == "study text":
        path.write_bytes(data.draw(broken(source.read_bytes())))
    else:
        path.write_text(toml_of(data.draw(mutated(tomllib.loads(source.read_text())))), encoding="utf-8")
    return load_any, path


def read_or_refused(kind, desk, examples):
    """Try that many files and return how many were read and refused."""
    tally = Counter()

    @fuzzed(examples, desk[0] / ".hypothesis")
    @given(st.data())
    def attempt(data):
        tally[outcome(*hostile_file(data, kind, desk))] += 1

    attempt()
    return tally


@pytest.mark.parametrize("kind", PROFILES)
def test_a_hostile_file_is_read_or_refused(kind, desk):
    read_or_refused(kind, desk, PROFILES[kind][0])


@pytest.mark.slow
@pytest.mark.parametrize("kind", PROFILES)
def test_many_hostile_files_are_read_or_refused(kind, desk, capsys):
    _, examples, read, refused = PROFILES[kind]
    tally = read_or_refused(kind, desk, examples)
    with capsys.disabled():
        print(f"\n{kind}: {dict(tally)}")
    # Were all read, or all refused, the files would not be hostile, or too much so, to tell anything.
    total = tally.total()
    assert tally["accepted"] >= read * total and tally["refused"] >= refused * total
