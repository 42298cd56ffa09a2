"""Tails from question to folder: what is written, gone on with, compared, told, and flown again."""

import json
import re
import shutil
from math import exp, log, sqrt

import numpy as np
import pytest

import tuner
from plant.errors import InputError, StoreError
from tests.tuner.conftest import QUICKSTART
from tuner.api.frames import json_text
from tuner.cli.terminal import Console
from tuner.documents.parts import SampledValue
from tuner.documents.tail import TailEvent, TailMode, TailPoint
from tuner.extensions.tails.document import TailDocument, TailRatio
from tuner.extensions.tails.estimation.intervals import FIRST
from tuner.extensions.tails.printer import print_tail
from tuner.extensions.tails.record import line_digest
from tuner.extensions.tails.run import ratio_of
from tuner.extensions.tails.words import event_line, mode_line, point_line, probability_text, ratio_line
from tuner.search.watcher import Watcher
from tuner.study.build import load_study

EVENTS = ["peak.position > 1.35"]
MORE = "peak.position > 1.1"
"""So frequent that no design point is sought."""
SETTINGS = {"to": 1e-3, "width": 5.0, "most": 200_000}


@pytest.fixture(scope="module", autouse=True)
def few_replicas_and_failures():
    """Have a fifth of the replicas, a third of their states and a quarter of the failures.

    Coverage is tested where they are made, and searches of design points from each failure took three quarters of the time.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tuner.extensions.tails.estimation.estimate.FIRST", 4)
        patch.setattr("tuner.extensions.tails.estimation.planning.MIN_CHAINS", 8)
        patch.setattr("tuner.extensions.tails.estimation.planning.FAILURES", 2)
        yield


@pytest.fixture(scope="module")
def study():
    return load_study(QUICKSTART, {"scenario.0.duration": 0.6, "limits.position": 1.4})


@pytest.fixture(scope="module")
def made(study, tmp_path_factory):
    return tuner.tail(study, EVENTS, out=tmp_path_factory.mktemp("tail"), threads=2, **SETTINGS)


def files(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != ".lock"}


def test_the_document_reads_back_as_it_was_written(made):
    assert TailDocument.read(made.folder / "tail.json") == made.document
    assert json.loads(made.json)["format"] == "gainproof-tail"
    assert made.table.index.tolist() == [("quickstart", text) for text in EVENTS]


@pytest.mark.slow
def test_the_probability_of_a_loss_is_that_of_crude_flights(study):
    flown = tuner.fly(_default(study), study=study, flights=6000, threads=2)
    lost = flown.document.lost
    share = len(lost) / 6000
    event = tuner.tail(study, "failure", threads=2, **SETTINGS).document.gains[0].events[0]
    spread = 4.0 * sqrt(share / 6000)
    assert event.low - spread < share < event.high + spread


def _default(study):
    from tuner.api.gains import gains_of

    return gains_of(study.controller(study.default_row), {})


@pytest.mark.slow
def test_any_number_of_threads_gives_the_same_bits(study, made, tmp_path):
    alone = tuner.tail(study, EVENTS, out=tmp_path / "one", threads=1, **SETTINGS)
    assert files(alone.folder) == files(made.folder)


@pytest.mark.slow
@pytest.mark.parametrize("kept", [1, -1])
def test_a_killed_run_goes_on_to_the_same_bytes(study, made, tmp_path, kept):
    folder = tmp_path / "killed"
    shutil.copytree(made.folder, folder)
    for name in ("tail.json", "tail.png", "tail.pdf", *[path.name for path in folder.glob("point-*")]):
        (folder / name).unlink()
    lines = (folder / "replicas.jsonl").read_bytes().splitlines(keepends=True)
    (folder / "replicas.jsonl").write_bytes(b"".join(lines[:kept]) + lines[kept][:20])
    again = tuner.tail(study, EVENTS, out=folder, threads=2, **SETTINGS)
    assert files(again.folder) == files(made.folder)


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("nonsense", "line 1 is damaged; take the line out"),
        ('{"gains": 0}', "line 1 is damaged"),
        (
            '{"gains": 0, "event": "peak.position > 1.35", "number": 0, "probability": 0.1, "ladders": [], "curve": [], '
            '"evaluations": 3, "sha256": "DIGEST"}',
            "replicas of another version or machine",
        ),
    ],
)
def test_spoiled_replicas_are_told_in_a_sentence(study, made, tmp_path, line, sentence):
    folder = tmp_path / "spoiled"
    shutil.copytree(made.folder, folder)
    digest = line_digest(json.loads(line)) if line.startswith("{") else ""
    (folder / "replicas.jsonl").write_text(line.replace("DIGEST", digest) + "\n")
    with pytest.raises(StoreError, match=sentence):
        tuner.tail(study, EVENTS, out=folder, threads=1, **SETTINGS)


@pytest.mark.slow
def test_replicas_on_record_are_not_flown_again(study, made, tmp_path, monkeypatch):
    folder = tmp_path / "again"
    shutil.copytree(made.folder, folder)
    before = (folder / "replicas.jsonl").read_bytes()
    flown = []
    watcher = tuner.Watcher()
    monkeypatch.setattr(watcher, "on_flights_done", flown.append)
    tuner.tail(study, EVENTS, out=folder, threads=2, watcher=watcher, **SETTINGS)
    assert (folder / "replicas.jsonl").read_bytes() == before
    assert sum(flown) < sum(event.flights for event in made.document.gains[0].events) + 20_000


def test_an_interrupted_run_says_how_it_goes_on(study, tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    # At the first of its work: it takes a second to get further.
    monkeypatch.setattr("tuner.extensions.tails.run.plan_tail", interrupted)
    with pytest.raises(KeyboardInterrupt) as caught:
        tuner.tail(study, EVENTS, out=tmp_path / "new", threads=1, **SETTINGS)
    assert caught.value.__notes__ == ["give the command again"]


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"events": MORE}, r"events changed \(0 peak.position > 1.35 -> peak.position > 1.1\)"),
        ({"to": 1e-4}, r"options changed \(to 0.001 -> 0.0001\)"),
        ({"width": 1.0}, r"options changed \(width 5.0 -> 1.0\)"),
        ({"most": 10}, r"options changed \(most 200000 -> 10\)"),
        ({"worst": "air"}, r"options changed \(worst none -> air\)"),
        ({"gains": {"scenario.0.duration": 0.7}}, "flights changed"),
        ({"gains": {"seed": 9}}, r"options changed \(seed .* -> 9\)"),
        ({"gains": {"gains": {"attitude.k2": 3.0}}}, "gains changed"),
        ({}, r"version of the product changed \(version .* -> 99.0\)"),
    ],
)
def test_a_changed_input_is_refused_by_its_name(study, made, tmp_path, monkeypatch, changed, sentence):
    folder = tmp_path / "other"
    shutil.copytree(made.folder, folder)
    if not changed:
        monkeypatch.setattr("tuner.extensions.tails.run.version", lambda: "99.0")
    few = {"scenario.0.duration": 0.6, "limits.position": 1.4}
    given = {"gains": study, "events": EVENTS, **SETTINGS} | changed
    if isinstance(given["gains"], dict):
        given["gains"] = load_study(QUICKSTART, few | given["gains"])
    with pytest.raises(StoreError, match=sentence) as refused:
        tuner.tail(given.pop("gains"), given.pop("events"), out=folder, **given)
    assert "choose another folder with --out" in str(refused.value) and "--restart" not in str(refused.value)
    assert files(folder) == files(made.folder)


def test_gains_are_compared_with_the_first(study, tmp_path):
    path = tmp_path / "calm.json"
    _default(study).write(path)
    both = tuner.tail([study, path], MORE, study=study, threads=2, to=0.05, width=5.0, most=1000)
    [ratio] = both.document.ratios
    assert (ratio.gains, ratio.first) == (str(path), "quickstart")
    assert ratio.ratio is not None and ratio.ratio.value == pytest.approx(1.0)
    assert ratio.ratio.low < 1.0 < ratio.ratio.high


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"to": 0.5}, "allowed: 1e-09 to 0.1"),
        ({"width": 0.0}, "allowed: 0.05 to 10"),
        ({"most": 0}, "at least one flight"),
        ({"events": []}, "give gains and an event"),
        ({"events": ["failure", "failure"]}, "given twice"),
        ({"gains": []}, "give gains and an event"),
        ({"gains": ["nothing.json"]}, "nothing.json"),
    ],
)
def test_wrong_questions_are_told_in_a_sentence(study, changes, sentence):
    given = {"gains": study, "events": "failure", **changes}
    with pytest.raises(InputError, match=sentence):
        tuner.tail(**given)


@pytest.mark.slow
def test_one_flight_is_allowed(study):
    event = tuner.tail(study, "failure", most=1).document.gains[0].events[0]
    assert event.flights <= 1
    assert (event.low, event.high) == pytest.approx((0.0, 0.975), abs=0.03)


@pytest.mark.slow
def test_a_scenario_without_noise_needs_one_flight(study):
    still = {"intensity": "none", "altitude": 10.0, "mean_wind": False}
    quiet = load_study(
        QUICKSTART,
        {
            "scenario.0.duration": 0.6, "scenario.0.air": still, "scenario.0.spread": {},
            "scenario.0.sensors": {"position": 0.0, "velocity": 0.0, "attitude": 0.0, "rate": 0.0},
        },
    )  # fmt: skip
    event = tuner.tail(quiet, "failure", to=0.05, width=5.0, most=1000).document.gains[0].events[0]
    assert event.high < 1.0


@pytest.mark.slow
def test_a_design_point_is_flown_by_its_name_and_reaches_the_limit(study, made):
    points = [mode.point for mode in made.document.gains[0].events[0].modes if mode.point]
    assert points
    for point in points:
        assert sum(point.shares.values()) == pytest.approx(1.0)
        flown = tuner.fly(_default(study), study=study, flight=f"{made.folder}/{point.name}", threads=1)
        assert flown.count == 1
        assert flown.table.loc["peak.position", "mean"] == pytest.approx(1.35, rel=0.01)
        assert np.ptp(flown.recorded.actual[..., 0]) > 0.1


@pytest.mark.slow
def test_the_worst_air_alone_is_a_little_farther_off_and_no_vehicle_alone_does_it(study, made, capsys):
    [mode] = made.document.gains[0].events[0].modes
    air, vehicle = (tuner.tail(study, EVENTS, worst=part, threads=2, **SETTINGS) for part in ("air", "vehicle"))
    [of_air] = air.document.gains[0].events[0].modes
    assert of_air.probability == mode.probability and of_air.point is not None and mode.point is not None
    assert of_air.point.shares["air"] == pytest.approx(1.0)
    assert 0.98 * mode.point.distance < of_air.point.distance < 1.2 * mode.point.distance
    [of_vehicle] = vehicle.document.gains[0].events[0].modes
    assert of_vehicle.point is None
    print_tail(vehicle, Console())
    assert "no vehicle alone leads to it" in capsys.readouterr().out
    with pytest.raises(InputError, match="valid: air, sensors, vehicle"):
        tuner.tail(study, EVENTS, worst="gravity", **SETTINGS)


def test_a_flight_of_another_scenario_or_a_wrong_file_is_refused(made, tmp_path):
    point = next(iter(made.folder.glob("point-*.npy")))
    name = str(point.with_suffix(""))
    with pytest.raises(InputError, match="give the tail's study and scenario"):
        tuner.fly(tuner.default_gains("hybrid"), flight=name)
    for content in (b"", b"nonsense", point.read_bytes()[:500]):
        (tmp_path / "bad.npy").write_bytes(content)
        with pytest.raises(InputError, match="holds no flight of a tail"):
            tuner.fly(tuner.default_gains("hybrid"), flight=str(tmp_path / "bad"))


def fabricated(status="estimated", probability=1e-4, low=0.7e-4, high=1.5e-4, method="splitting"):
    return TailEvent(
        event="peak.position > 3", metric="peak.position", unit="m", limit=3.0, status=status, method=method,
        probability=probability, low=low, high=high, flights=4200, count=None, replicas=20, modes=[], curve=[],
    )  # fmt: skip


def test_a_ratio_has_the_interval_of_independent_lognormal_estimates():
    event, base = fabricated(), fabricated(probability=2e-4, low=1e-4, high=4e-4)
    ratio = ratio_of(event, base)
    assert ratio is not None and ratio.value == pytest.approx(0.5)
    assert log(ratio.low / ratio.value) == pytest.approx(-sqrt(log(1 / 0.7) ** 2 + log(2.0) ** 2))
    assert ratio.high == pytest.approx(0.5 * exp(sqrt(log(1.5) ** 2 + log(2.0) ** 2)))
    assert ratio_of(event, fabricated(low=0.0)) is None


@pytest.mark.parametrize(
    ("event", "line"),
    [
        (fabricated(), "peak.position > 3: 1.0e-4 [0.7e-4, 1.5e-4] (4200 flights, splitting)"),
        (fabricated("below", 0.0, 0.0, 2e-7), "rarer than 1.0e-06, at most 2.0e-07"),
        (fabricated("unreached", 0.0, 0.0, 1e-3), "no flight came near it, it may be impossible"),
        (fabricated("certain", 1.0, 0.99, 1.0), "at least 0.99; every flight has it"),
        (fabricated("deterministic", 0.0, 0.0, 0.0), "nothing of this scenario is drawn"),
        (fabricated("wide"), "too few for the width"),
    ],
)
def test_every_ending_is_told_in_a_line(event, line):
    assert line in event_line(event, 1e-6)


def test_modes_points_and_ratios_are_told_in_a_line():
    share = SampledValue(0.6, 0.4, 0.8)
    mode = TailMode(mode="tilt", probability=SampledValue(6e-5, 3e-5, 9e-5), share=share, point=None)
    assert mode_line(mode) == "by tilt: 60 % [40 %, 80 %] of it, 6.0e-5 [3.0e-5, 9.0e-5]"
    point = TailPoint(
        name="point-1", distance=4.42, shares={"vehicle": 0.05, "air": 0.949, "sensors": 0.001},
        numbers={"vehicle mass": -0.94, "vehicle lag": 0.01},
    )  # fmt: skip
    assert point_line(point).endswith(
        "point-1, 4.42 deviations off, of it squared air 95 %, vehicle 5.0 %; vehicle mass −0.9"
    )
    ratio = TailRatio(event="failure", gains="b", first="a", ratio=SampledValue(0.5, 0.25, 1.1))
    assert ratio_line(ratio) == "failure, b over a: 0.5 times [0.25, 1.1]"
    assert probability_text(0.178, 0.15, 0.21) == "0.178 [0.15, 0.21]"


@pytest.mark.slow
def test_a_plants_study_has_tails_too(tmp_path, monkeypatch):
    from tests.tuner.experiments import own_motor

    monkeypatch.chdir(tmp_path)
    folder = own_motor.write_motor(tmp_path).parent
    tuner.use(folder / "motor.py")
    study = tuner.load_study(folder / "motor.toml")
    found = tuner.tail(study, "failure", to=0.01, most=500)
    assert found.document.parts
    assert json_text(found.document)


def test_the_answer_has_a_line_for_every_event_mode_and_point(made, capsys):
    print_tail(made, Console())
    printed = " ".join(capsys.readouterr().out.split())
    [event] = made.document.gains[0].events
    assert event_line(event, made.document.smallest) in printed
    assert point_line(event.modes[0].point) in printed
    assert f"Document: {made.folder / 'tail.json'}" in printed


@pytest.mark.slow
def test_the_flights_that_are_announced_are_about_those_that_are_made(study, monkeypatch):
    """Of a wide interval too, which the first replicas make narrower than asked for."""
    monkeypatch.setattr("tuner.extensions.tails.estimation.estimate.FIRST", FIRST)
    messages: list[str] = []
    watcher = Watcher()
    monkeypatch.setattr(watcher, "on_message", messages.append)
    made = tuner.tail(study, EVENTS[0], to=1e-3, width=5.0, threads=2, watcher=watcher)
    [event] = made.document.gains[0].events
    [pilot] = [text for text in messages if text.startswith("A pilot of")]
    spent, more = (int(re.sub(r"\D", "", part)) for part in re.findall(r"(?:of|about) (\d[^a-z]*)", pilot))
    assert event.method == "splitting"
    assert (spent + more) / event.flights == pytest.approx(1.0, abs=0.25)
