"""gains.json: what is written is read back; what is wrong is named."""

import json

import pytest

from plant.errors import InputError
from tuner.gains_file import read_gains, to_document


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
    again = to_document(controller, {})
    assert again == {key: document[key] for key in again}


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        (lambda d: d.pop("format"), "format", "holdfast-gains"),
        (lambda d: d["controller"].update(attitude="hybird"), "controller.attitude", "did you mean 'hybrid'"),
        (lambda d: d["controller"].update(lag_aware=1), "controller.lag_aware", "true or false"),
        (lambda d: d["gains"].pop("roll.lambda"), "gains.roll.lambda", '"unit": "s^-1"'),
        (lambda d: d["gains"].update({"roll.lamda": d["gains"]["roll.k2"]}), "gains", "did you mean 'roll.lambda'"),
        (lambda d: d["gains"]["roll.k2"].update(unit="rad"), "gains.roll.k2.unit", "must be in s^-1"),
        (lambda d: d["gains"]["roll.k2"].update(value="5"), "gains.roll.k2.value", "finite number"),
        (lambda d: d["gains"]["roll.k2"].update(value=True), "gains.roll.k2.value", "finite number"),
        (lambda d: d["gains"]["roll.k2"].update(value=float("nan")), "gains.roll.k2.value", "finite number"),
        (lambda d: d["gains"]["roll.k2"].update(value=10**400), None, "more than 300 digits"),
        (lambda d: d["gains"]["roll.k2"].update(value=-1.0), "gains.roll.k2", "at least 0"),
        (lambda d: d["gains"]["roll.omega_o"].update(value=80.0), "gains.roll.omega_o", "75 rad/s"),
        (
            lambda d: d["controller"]["control_period"].update(value=0.0),
            "controller.control_period",
            "1e-05 s to 0.1 s",
        ),
        (
            lambda d: d["controller"]["plant_step"].update(value=0.003),
            "controller.control_period",
            "multiple of plant_step",
        ),
        (lambda d: d["controller"]["tilt_limit"].update(value=9.0), "controller.tilt_limit", "0.05 to 1.05 rad"),
        (lambda d: d["controller"].update(attitude_rate="guessed"), "controller.attitude_rate", "'observer'"),
        (lambda d: d["airframe"].update(name="humingbird"), "airframe.name", "did you mean 'hummingbird'"),
        (lambda d: d["airframe"].update(name="/etc/passwd"), "airframe.name", "unknown airframe '/etc/passwd'"),
        (lambda d: d["airframe"].pop("name"), "airframe.name", "required and missing"),
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
    ],
)
def test_json_that_no_gains_file_is(tmp_path, text, words):
    file = tmp_path / "gains.json"
    file.write_text(text)
    with pytest.raises(InputError, match=words):
        read_gains(file)
