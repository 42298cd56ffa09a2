"""A search from the page: the folder of `tuner run`, candidates that can be taken, and an end as by Ctrl-C."""

import json
import time

import pytest

from tests.tuner.extensions.studio.conftest import STUDIES
from tests.tuner.extensions.studio.served import served
from tuner.extensions.studio.answering import Bench, opening
from tuner.extensions.studio.live import opened

SMALL = {"population = 24": "population = 8", "generations = 20": "generations = 2", "held_out = 256": "held_out = 32"}


def study_in(folder, **changes):
    text = (STUDIES / "dc_motor.toml").read_text()
    for old, new in {**SMALL, **changes}.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "motor.toml").write_text(text.replace("dc_motor.py", str(STUDIES / "dc_motor.py")))
    return folder / "motor.toml"


def until(client, wanted, since=0):
    """The first state of the search that is as wanted."""
    for _ in range(600):
        state = json.loads(client.ask("/search-state", {"since": since})[2])
        if wanted(state):
            return state
        time.sleep(0.1)
    raise AssertionError("the search never came to the wanted state")


def files_of(folder):
    return {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}


@pytest.mark.slow
def test_a_search_writes_the_folder_of_the_command(tmp_path, tuner, few_golden_vectors):
    study = study_in(tmp_path)
    with served(study, tmp_path) as (bench, client):
        (started,) = client.lines("/search", {"number": 1, "values": {}, "folder": "mine", "from": "study"})
        assert "Started" in started["text"]
        (second,) = client.lines("/search", {"number": 1, "values": {}, "folder": "other", "from": "study"})
        assert "running already" in second["error"]
        state = until(client, lambda each: not each["running"])
        assert state["ended"] and state["generations"] == 2
        candidates = [name for name in state["points"] if name.startswith("candidate ")]
        assert len(candidates) == 16
        answer = client.lines("/answer", {"number": 9, "page": "s", "values": state["points"][candidates[-1]]})[0]
        ids = {name for trace in answer["charts"]["front"]["traces"] for name in trace.get("ids", [])}
        assert {"default"} < ids <= set(state["points"])
    assert tuner("run", str(study), "--out", str(tmp_path / "theirs")).returncode in (0, 3)
    mine, theirs = files_of(tmp_path / "mine"), files_of(tmp_path / "theirs")
    assert mine.keys() == theirs.keys()
    # Times and names of folders are those of a run.
    own = {"history.csv", "summary.json", "report.html", "environment.json", "manifest.json", "run.json", ".lock"}
    compared = [name for name in mine if name not in own and not name.startswith("figures/")]
    assert len(compared) > 8
    assert [name for name in compared if mine[name].read_bytes() != theirs[name].read_bytes()] == []


@pytest.mark.slow
def test_a_search_from_the_setting_stops_as_by_ctrl_c(tmp_path):
    study = study_in(tmp_path, **{"generations = 20": "generations = 400"})
    with served(study, tmp_path) as (_, client):
        client.lines("/search", {"number": 1, "values": {"angle.kp": 22.0}, "folder": "mine", "from": "setting"})
        until(client, lambda each: each["generations"] >= 1)
        stopped = json.loads(client.ask("/search-stop", {})[2])
        assert "tuner resume" in stopped["text"]
        assert not json.loads(client.ask("/search-state", {"since": 0})[2])["running"]
    assert (tmp_path / "mine" / "run.json").exists() and not (tmp_path / "mine" / "summary.json").exists()
    assert "22.0" in next((tmp_path / "mine" / "inputs").glob("*.toml")).read_text()
    # The page of a run that has not ended, as `tuner run --live` opens it.
    session = opened(tmp_path / "mine", (str(STUDIES / "dc_motor.py"),))
    bench = Bench.of(session, 2)
    assert session.results is None and opening(bench)["live"]
    run = bench.front.run
    assert run is not None and not run.has_ended and len(run.generations()) >= 1
    assert run.points().keys() >= set(run.generations()[0].names)


@pytest.mark.parametrize("folder", ["../x", "", "a/b"])
def test_a_search_elsewhere_is_refused(client, folder):
    (answer,) = client.lines("/search", {"number": 1, "values": {}, "folder": folder, "from": "study"})
    assert "without folders" in answer["error"]
