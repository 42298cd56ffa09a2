"""gains.json of a run: what is written is read back; what is wrong is named; what was edited is told."""

import json
from dataclasses import replace

import pytest

from plant.errors import InputError
from tests.tables import read_frame
from tests.tuner.gains.making import whole_document
from tuner.experiments.tuning.gains_of_run import margin_rows
from tuner.gains import read_gains, to_document
from tuner.gains.examining import examine
from tuner.gains.hashing import same_result


@pytest.fixture
def document(small_run):
    _, folder = small_run
    return json.loads((folder / "gains.json").read_text())


def written(tmp_path, document):
    file = tmp_path / "gains.json"
    file.write_text(json.dumps(document))
    return file


def test_round_trip(tmp_path, document):
    controller = read_gains(written(tmp_path, document))
    kept = {key: document[key] for key in ("study", "objectives", "margins", "cost") if key in document}
    ranges = {address: (gain["low"], gain["high"]) for address, gain in document["gains"].items() if "low" in gain}
    assert to_document(controller, kept, ranges) == document


def test_a_run_writes_a_valid_document_with_ranges_intervals_and_margins(small_run, document):
    outcome, folder = small_run
    assert examine(folder / "gains.json").problems == []
    variable = outcome.study.space.variables[0]
    for address in variable.addresses:
        assert (document["gains"][address]["low"], document["gains"][address]["high"]) == (variable.low, variable.high)
    row = document["objectives"][0]
    assert row["interval"]["n"] == 32 and row["interval"]["level"] == 0.95
    assert row["tuned"]["low"] < row["tuned"]["value"] < row["tuned"]["high"]
    assert [row["loop"] for row in document["margins"]] == ["x", "y", "z", "roll", "pitch", "yaw"]
    # The loops of x and y go through those of pitch and roll, whose law is not linear.
    methods = {row["loop"]: row["method"] for row in document["margins"]}
    assert methods.pop("z") == "linearised" and set(methods.values()) == {"describing function"}


def test_margins_are_those_of_the_table_of_the_run(small_run, document):
    import pandas as pd

    outcome, folder = small_run
    table = read_frame(folder / "margins.npz").set_index(["point", "channel"])
    for row in document["margins"]:
        there = table.loc[(document["study"]["point"], row["loop"])]
        assert row["stable"] == bool(there["stable"])
        for name in (
            "gain_up",
            "gain_down",
            "phase_margin",
            "delay_margin",
            "ms",
            "mt",
            "disk",
            "crossover",
            "bandwidth",
        ):
            if name in row:
                assert row[name]["value"] == pytest.approx(float(there[name]), rel=1e-5)
            else:
                assert pd.isna(there[name])
    assert margin_rows(outcome) == document["margins"]


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        (lambda d: d.pop("format"), "format", "gainproof-gains"),
        (lambda d: d.update(version="7.1"), "version", "unknown version '7.1'"),
        (
            lambda d: d["controller"].update(attitude="hybird"),
            "controller.attitude",
            "unknown law 'hybird'; did you mean 'hybrid'",
        ),
        (lambda d: d["controller"].update(lag_aware=1), "controller.lag_aware", "true or false"),
        (lambda d: d["gains"].pop("roll.lambda"), "gains.roll.lambda", '"unit": "s-1"'),
        (
            lambda d: d["gains"].update({"roll.lamda": d["gains"]["roll.k2"]}),
            "gains.roll.lamda",
            "did you mean 'roll.lambda'",
        ),
        (lambda d: d["gains"].update({"rol.k2": d["gains"]["roll.k2"]}), "gains.rol.k2", "unknown gain 'rol.k2'"),
        (lambda d: d["gains"]["roll.k2"].update(unit="rad"), "gains.roll.k2.unit", "must be in s-1"),
        (lambda d: d["gains"]["roll.k2"].update(value="5"), "gains.roll.k2.value", "finite number"),
        (lambda d: d["gains"]["roll.k2"].update(value=True), "gains.roll.k2.value", "finite number"),
        (lambda d: d["gains"]["roll.k2"].update(value=float("nan")), "gains.roll.k2.value", "finite number"),
        (lambda d: d["gains"]["roll.k2"].update(valeu=5), "gains.roll.k2.valeu", "did you mean 'value'"),
        (lambda d: d["gains"]["roll.k2"].update(value=10**400), None, "more than 300 digits"),
        (lambda d: d["gains"]["roll.k2"].update(value=1e7), "gains.roll.k2.value", "allowed: 0, or a size"),
        (lambda d: d["gains"]["roll.k2"].update(value=-1.0), "gains.roll.k2.value", "at least 0"),
        (lambda d: d["gains"]["roll.k2"].update(low=9.0, high=8.0), "gains.roll.k2.low", "must not be above high = 8"),
        (lambda d: d["gains"]["roll.omega_o"].update(value=80.0), "gains.roll.omega_o.value", "75 rad/s"),
        (
            lambda d: d["controller"]["control_period"].update(value=0.0),
            "controller.control_period.value",
            "at least 1e-05",
        ),
        (
            lambda d: d["controller"]["plant_step"].update(value=0.003),
            "controller.control_period",
            "multiple of plant_step",
        ),
        (lambda d: d["controller"]["tilt_limit"].update(value=9.0), "controller.tilt_limit.value", "at most 1.05"),
        (lambda d: d["controller"].update(attitude_rate="guessed"), "controller.attitude_rate", "measured, observer"),
        (lambda d: d["airframe"].update(name=""), "airframe.name", "given ''; a name is 1 to 64 letters"),
        (lambda d: d["airframe"].pop("name"), "airframe.name", "required and missing"),
        (lambda d: d["airframe"]["numbers"].pop("mass"), "airframe.numbers.mass", '"unit": "kg"'),
        (lambda d: d["airframe"]["actuation"]["rotors"].pop(), "airframe.actuation.rotors", "a list of 4"),
        (lambda d: d["objectives"][0].update(unit="furlong"), "objectives[0].unit", "furlong"),
        (lambda d: d["study"].update(sede=1), "study.sede", "did you mean 'seed'"),
        (lambda d: d["conventions"].update(body_frame="FRD"), "conventions.body_frame", "must be 'FLU'"),
        (lambda d: d.update(sha256="abc"), "sha256", "64 hexadecimal digits"),
        (lambda d: d.update(notes=1), "notes", "unknown key 'notes'"),
        (lambda d: d.pop("gains"), "gains", "missing"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, document, change, key, words):
    change(document)
    file = written(tmp_path, document)
    with pytest.raises(InputError) as caught:
        read_gains(file)
    assert caught.value.key == key
    assert words in str(caught.value)
    assert str(file) in str(caught.value)


def test_a_gain_is_judged_by_the_period_even_where_the_hash_is_left_out(tmp_path, document):
    del document["sha256"]
    document["gains"]["yaw.k2"]["value"] *= 1.5
    assert read_gains(written(tmp_path, document)).gains[-2] == document["gains"]["yaw.k2"]["value"]
    document["controller"]["control_period"]["value"] = 0.1
    with pytest.raises(InputError, match="largest allowed value is 3 rad/s"):
        read_gains(written(tmp_path, document))


def test_an_edit_is_told(tmp_path, document):
    document["gains"]["roll.k2"]["value"] *= 1.0 + 1e-12
    with pytest.raises(InputError, match="edited by hand.*remove the key sha256") as caught:
        read_gains(written(tmp_path, document))
    assert caught.value.key == "sha256"


def test_every_problem_is_found_at_once(tmp_path, document):
    document["controller"].update(attitude="hybird", dealy=True)
    document["gains"]["x.zeta"]["unit"] = "rad"
    document["study"]["seed"] = -1
    problems = examine(written(tmp_path, document)).problems
    assert {problem.key for problem in problems} == {
        "controller.attitude",
        "controller.dealy",
        "gains.x.zeta.unit",
        "study.seed",
        "sha256",
    }
    assert all(str(tmp_path) in str(problem) and "\n" not in str(problem) for problem in problems)


def test_a_key_twice_is_refused(tmp_path, document):
    file = tmp_path / "gains.json"
    file.write_text(json.dumps(document).replace('"value": 0.004', '"value": 0.002, "value": 0.004'))
    with pytest.raises(InputError, match="occurs twice") as caught:
        read_gains(file)
    assert caught.value.key == "value"


def test_no_json(tmp_path):
    file = tmp_path / "gains.json"
    file.write_text('{"format": ')
    with pytest.raises(InputError, match="line 1"):
        read_gains(file)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[" * 50_000, "nested deeper"),
        ('{"a": ' + 5000 * "9" + "}", "not JSON that can be read"),
        ("[1]", "no JSON object"),
        ("1\t1\tMC_ROLL_P\t6.5\t9\n", "not JSON, line 1 .*tuner import FILE --from SOURCE"),
        ("\n\nMC_ROLL_P", "not JSON, line 3 "),
        ("", "not JSON, line 1 "),
    ],
)
def test_json_that_no_gains_file_is(tmp_path, text, words):
    file = tmp_path / "gains.json"
    file.write_text(text)
    with pytest.raises(InputError, match=words):
        read_gains(file)


def test_a_seed_that_no_double_holds_is_a_text():
    from tuner.gains.document import seed_entry

    assert seed_entry(2**53 - 1) == 2**53 - 1 and seed_entry(2**53 + 1) == "9007199254740993" and seed_entry(0) == 0


def test_the_same_result_is_told_from_another():
    made = whole_document()
    later = made | {"exports": [], "cost": [], "generator": {"name": "gainproof", "version": "9"}, "margins": []}
    assert same_result({**later, "sha256": made["sha256"]}, made)
    assert same_result({key: value for key, value in made.items() if key != "sha256"}, made)
    assert not same_result({**made, "sha256": 64 * "0"}, made)
    other = json.loads(json.dumps(made))
    other["gains"]["roll.k2"]["value"] += 1e-9
    assert not same_result(other, made) and not same_result({}, made) and not same_result({**made, "study": {}}, made)
    old = {"version": "0.1", "gains": {address: {"value": gain["value"]} for address, gain in made["gains"].items()}}
    assert same_result(old, made) and not same_result({"version": "0.1", "gains": 3}, made)


def test_notches_that_follow_the_rotors_are_kept(tmp_path, document):
    """They are options of the controller: written where there are some, and read as they were."""
    controller = read_gains(written(tmp_path, document))
    assert "rpm_notches" not in document["controller"]
    notched = replace(
        controller, options=replace(controller.options, rpm_notches=2, rpm_notch_q=4.0, rpm_notch_min=60.0)
    )
    again = to_document(notched, {})
    assert again["controller"]["rpm_notch_min"] == {"value": 60.0, "unit": "Hz"}
    assert read_gains(written(tmp_path, again)).options == notched.options
