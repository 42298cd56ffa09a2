"""`tuner run` and `tuner check` on a contest, as a user meets them."""

import json
import shutil

import pytest

import tuner as api
from tests.tuner.cli.test_cli import refused
from tests.tuner.experiments.again.killing import unsealed
from tests.tuner.extensions.contests.experiments.contest_text import changed, write
from tests.tuner.in_process import tuner as in_process
from tuner.documents.summary import NOTHING
from tuner.text.errors import NOTHING_FEASIBLE


def test_check_says_what_a_contest_would_fly(tmp_path, tuner):
    figures = json.loads(tuner("check", write(tmp_path), "--json").stdout)
    assert figures["contenders"] == ["PID (1 searched)", "The hybrid, v1.0 (as given)", "LADRC (as given)"]
    assert figures["search_flights"] == 8 * 3 * (4 + 2)
    # Three contenders, and of the one that is tuned the front's points that go to the held-out check, 16 and 8 beside limits at most.
    assert figures["comparison_flights_at_most"] == (3 + 24) * (8 + 6)
    told = tuner("check", tmp_path / "contest.toml").stdout
    assert "LADRC (as given)" in " ".join(told.split())


@pytest.fixture
def planned_once(monkeypatch):
    """Fly the pilots of a plan once, for its document and its text on the terminal."""
    plan, made = api.plan, []

    def remembered(*given, **named):
        made[:] = made or [plan(*given, **named)]
        return made[0]

    monkeypatch.setattr(api, "plan", remembered)


def test_a_plan_counts_the_flights_of_the_comparison(small_contest, tmp_path, tuner, planned_once):
    """Against what the small contest flew: the search to the last flight, the rest not above what the plan allows."""
    result, folder = small_contest
    plan = json.loads(tuner("plan", write(tmp_path), "--json", "--threads", 2).stdout)
    run, compared = plan["runs"]["PID"], plan["comparison"]
    assert list(plan["runs"]) == ["PID"] and compared["stream"] == "confirmation"
    assert run["flights"]["search_at_most"] == 8 * 3 * (4 + 2)
    assert compared["flights_at_most"] == (3 + 24) * (8 + 6)
    assert plan["total"]["flights_at_most"] == compared["flights_at_most"] + run["flights"]["total_at_most"]
    own = json.loads((folder / "contenders" / "pid" / "summary.json").read_text())["flights"]
    assert (own, result.flights - own) <= (run["flights"]["total_at_most"], compared["flights_at_most"])
    assert result.flights - own > 3 * (8 + 6)
    assert 0.0 < compared["seconds_at_most"] < plan["total"]["seconds_at_most"]
    shown = tuner("plan", tmp_path / "contest.toml", "--threads", 2).stdout
    assert "The contest takes at most" in shown and f"{plan['total']['flights_at_most']:,} flights" in shown


def test_run_prints_tables_and_sentences(tmp_path, tuner):
    given = changed("{ low = 20.0, high = 200.0 }", "60.0")
    path = write(tmp_path, given)
    done = tuner(
        "run", path, "--out", tmp_path / "out", "--threads", 2, "--set", "contender.PID.gains.attitude.kp=70.0"
    )
    assert done.returncode == 0, done.stderr
    shown = " ".join(done.stdout.split())
    found = json.loads((tmp_path / "out" / "contest.json").read_text())
    assert found["contenders"][0]["gains"]["roll.kp"]["value"] == 70.0
    for text in found["words"]:
        assert " ".join(text.split()) in shown
    assert "Printed numbers and our flights" in shown
    assert "peak.roll rad (fitted)" in shown
    assert "report.html" in shown
    assert "exists already" in refused(tuner("run", path, "--out", tmp_path / "out"))


def test_bad_input_is_one_line_on_stderr(tmp_path, tuner):
    path = write(tmp_path, changed('"attitude.kd" = 14.0', '"attitude.kdd" = 14.0'))
    message = refused(tuner("run", path, "--out", tmp_path / "never"))
    assert message.count("\n") == 1
    assert "contender[0].gains.attitude.kdd" in message and str(path) in message
    assert not (tmp_path / "never").exists()


def test_a_contender_without_a_feasible_candidate_is_told_first_and_ends_with_its_code(tmp_path, monkeypatch, capsys):
    """No gain gives the tilt loops of this vehicle, through rotors of 20 ms, a phase margin of 89 deg."""
    margin = '\n[[margin]]\nquantity = "phase_margin"\naxis = "tilt"\nmin = 89\n'
    text = changed("[search]", f"{margin}\n[search]")
    monkeypatch.setenv("COLUMNS", "300")
    out = tmp_path / "out"
    code, said, err = in_process(
        monkeypatch, capsys, "run", write(tmp_path, text), "--out", out, "--threads", 2, "--set", "search.generations=1"
    )
    assert (code, err) == (NOTHING_FEASIBLE, "")
    assert said.index(f"{NOTHING} for PID") < said.index("On 14 confirmation flights each")
    found = json.loads((out / "contest.json").read_text())
    assert list(found)[:2] == ["feasible", "ending"] and found["feasible"] is False
    marks = {row["name"]: row["feasible"] for row in found["contenders"]}
    assert marks == {"PID": False, "The hybrid, v1.0": True, "LADRC": True}
    assert any("loop reaches" in text for text in found["ending"][1:])
    own = out / "contenders" / "pid"
    assert not (own / "gains.json").exists() and (own / "infeasible.json").exists()
    page = (out / "report.html").read_text()
    assert NOTHING in page and page.index(NOTHING) < page.index('class="lead"')
    code, said, _ = in_process(monkeypatch, capsys, "show", out)
    assert code == 0 and said.splitlines()[1].startswith(NOTHING)


def test_show_tells_which_contenders_of_an_unfinished_contest_are_tuned(small_contest, tmp_path, tuner):
    folder = shutil.copytree(small_contest[1], tmp_path / "stopped")
    (folder / "contest.json").unlink()
    unsealed(folder)
    (folder / "contenders" / "ladrc").mkdir()
    told = json.loads(tuner("show", folder, "--json").stdout)
    assert list(told) == ["kind", "finished", "title", "contenders_finished", "contenders_begun", "commands"]
    assert (told["kind"], told["finished"]) == ("contest", False)
    assert (told["contenders_finished"], told["contenders_begun"]) == (["pid"], ["ladrc"])
    text = " ".join(tuner("show", folder).stdout.split())
    assert "Tuned: pid Begun: ladrc" in text and f"tuner resume {folder}" in text
