"""`tuner validate` and `tuner schema`: exit codes and lines that a person or a script reads."""

import json

import pytest

from tests.tuner.gains.making import document, rehashed, written
from tests.tuner.gains.test_gains_versions import OLD
from tests.tuner.in_process import tuner


def test_a_valid_file_is_said_to_be_what_it_is(tmp_path, monkeypatch, capsys):
    file = written(tmp_path, document())
    code, out, err = tuner(monkeypatch, capsys, "validate", file)
    assert (code, err) == (0, "") and out == (
        f"{file}: valid: gainproof-gains 1.2, ladrc / hybrid for airframe hummingbird, 24 gains, hash ok\n"
    )


def test_a_file_without_hash_is_valid_with_a_note(tmp_path, monkeypatch, capsys):
    made = document()
    digest = made.pop("sha256")
    code, out, _ = tuner(monkeypatch, capsys, "validate", written(tmp_path, made))
    assert code == 0 and f"no hash given (it would be {digest})" in out


def test_an_old_file_is_valid(tmp_path, monkeypatch, capsys):
    file = tmp_path / "old.json"
    file.write_text(OLD)
    code, out, _ = tuner(monkeypatch, capsys, "validate", file)
    assert code == 0 and "gainproof-gains 0.1" in out and "before version 1.0" in out


def test_each_problem_has_its_line(tmp_path, monkeypatch, capsys):
    made = document()
    made["gains"]["roll.k2"]["unit"] = "1/s"
    made["gains"]["yaw.k2"]["value"] = -3
    made["typo"] = 1
    code, out, err = tuner(monkeypatch, capsys, "validate", written(tmp_path, made))
    lines = err.splitlines()
    assert (code, out, len(lines)) == (2, "", 4) and all(line.startswith("Error: ") for line in lines)
    for key in ("gains.roll.k2.unit", "gains.yaw.k2.value", "typo", "sha256"):
        assert sum(f": {key}: " in line for line in lines) == 1, key


@pytest.mark.parametrize(("value", "valid"), [(0.5, False), (1.0, True), (4.0 * (1.0 + 1e-12), True), (4.01, False)])
def test_a_value_is_held_against_the_range_beside_it(value, valid, tmp_path, monkeypatch, capsys):
    made = document()
    made["gains"]["roll.k2"] |= {"value": value, "low": 1.0, "high": 4.0}
    code, _, err = tuner(monkeypatch, capsys, "validate", written(tmp_path, rehashed(made)))
    assert code == (0 if valid else 2), err
    if not valid:
        assert f"gains.roll.k2.value: given {value:g} " in err and "outside of its range 1 to 4" in err


@pytest.mark.parametrize(
    ("change", "valid", "state"),
    [
        (lambda d: d, True, "ok"),
        (lambda d: {key: value for key, value in d.items() if key != "sha256"}, True, "missing"),
        (lambda d: d | {"x-mine": 2}, False, "wrong"),
        (lambda d: rehashed(d | {"study": {"seed": "x"}}), False, "ok"),
    ],
)
def test_a_program_is_told_the_same(tmp_path, monkeypatch, capsys, change, valid, state):
    code, out, err = tuner(monkeypatch, capsys, "validate", written(tmp_path, change(document())), "--json")
    told = json.loads(out)
    assert (code, err, told["valid"], told["hash"]) == (0 if valid else 2, "", valid, state)
    assert bool(told["problems"]) is not valid and (told["sha256"] is not None) is valid


def test_what_is_no_gains_file_is_one_line(tmp_path, monkeypatch, capsys):
    file = tmp_path / "none.json"
    for text in ("{}", "[1]", "{"):
        file.write_text(text)
        code, _, err = tuner(monkeypatch, capsys, "validate", file)
        assert code == 2 and err.count("\n") == 1 and str(file) in err


def test_the_schema_is_printed(monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "schema", "gains")
    assert code == 0 and json.loads(out)["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    code, _, err = tuner(monkeypatch, capsys, "schema", "gians")
    assert code == 2 and "did you mean 'gains'" in err
