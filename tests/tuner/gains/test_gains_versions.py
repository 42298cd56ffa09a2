"""Versions: what was written before is read for ever, what was written later is refused with what to do."""

import json

import pytest

from objectives.margins.steady_state import SteadyState
from plant.errors import InputError, UnknownNameError
from plant.quadrotor.airframes import load
from tests.tuner.gains.making import airframe, document, whole_document, written
from tuner.gains import content_hash, content_sha256, read_gains, to_document
from tuner.gains.examining import examine

# A file that version 0.1 wrote, without most of its objectives.
OLD = """{
  "format": "holdfast-gains", "version": "0.1",
  "airframe": {"name": "hummingbird", "title": "AscTec Hummingbird, corrected set of the seed study"},
  "controller": {
    "position": "ladrc", "attitude": "hybrid", "control_period": {"value": 0.004, "unit": "s"},
    "plant_step": {"value": 0.001, "unit": "s"}, "tilt_limit": {"value": 0.5235987755982988, "unit": "rad"},
    "attitude_rate": "measured", "position_rate": "measured", "lag_aware": true, "delay": true
  },
  "gains": {
    "x.omega_c": {"value": 2.0625991680581834, "unit": "rad/s"}, "x.zeta": {"value": 0.9616832633212279, "unit": "1"},
    "x.omega_o": {"value": 14.362267631134905, "unit": "rad/s"}, "y.omega_c": {"value": 2.0625991680581834, "unit": "rad/s"},
    "y.zeta": {"value": 0.9616832633212279, "unit": "1"}, "y.omega_o": {"value": 14.362267631134905, "unit": "rad/s"},
    "z.omega_c": {"value": 2.0625991680581834, "unit": "rad/s"}, "z.zeta": {"value": 0.9616832633212279, "unit": "1"},
    "z.omega_o": {"value": 14.362267631134905, "unit": "rad/s"}, "roll.omega_o": {"value": 16.712745797118554, "unit": "rad/s"},
    "roll.lambda": {"value": 6.101534951543213, "unit": "s^-1"},
    "roll.k1": {"value": 0.22985187166559012, "unit": "rad^(1/2) s^(-3/2)"}, "roll.k2": {"value": 9.602306652262454, "unit": "s^-1"},
    "roll.delta": {"value": 0.1, "unit": "rad/s"}, "pitch.omega_o": {"value": 16.712745797118554, "unit": "rad/s"},
    "pitch.lambda": {"value": 6.101534951543213, "unit": "s^-1"},
    "pitch.k1": {"value": 0.22985187166559012, "unit": "rad^(1/2) s^(-3/2)"},
    "pitch.k2": {"value": 9.602306652262454, "unit": "s^-1"}, "pitch.delta": {"value": 0.1, "unit": "rad/s"},
    "yaw.omega_o": {"value": 16.712745797118554, "unit": "rad/s"}, "yaw.lambda": {"value": 6.101534951543213, "unit": "s^-1"},
    "yaw.k1": {"value": 0.22985187166559012, "unit": "rad^(1/2) s^(-3/2)"}, "yaw.k2": {"value": 9.602306652262454, "unit": "s^-1"},
    "yaw.delta": {"value": 0.1, "unit": "rad/s"}
  },
  "study": {
    "name": "qlog.toml", "title": "Quickstart: one metre steps in moderate turbulence", "seed": 2,
    "digest": "6e88f077f95289f1bd3efec4", "point": "p0435"
  },
  "objectives": [
    {
      "label": "mean(travel)", "unit": "1/s", "kind": "objective", "limit": null,
      "default": {"value": 18.405464261804532, "low": 18.36134042993333, "high": 18.451757045708632},
      "tuned": {"value": 9.22405504511941, "low": 9.20585263035286, "high": 9.240579852008363},
      "difference": {"value": -9.181409216685122, "low": -9.21832737517186, "high": -9.14424437357531}, "verdict": "better"
    }
  ]
}
"""
POSITION = (2.0625991680581834, 0.9616832633212279, 14.362267631134905)
ATTITUDE = (16.712745797118554, 6.101534951543213, 0.22985187166559012, 9.602306652262454, 0.1)
NEWER = {"generator": {"name": "gainproof", "version": "3.2.1"}}


def test_a_file_of_version_0_1_is_read(tmp_path, capsys):
    file = tmp_path / "gains.json"
    file.write_text(OLD)
    controller = read_gains(file)
    assert controller.gains == (*3 * POSITION, *3 * ATTITUDE)
    assert (controller.control_period, controller.plant_step, controller.options.tilt_limit) == (
        0.004,
        0.001,
        0.5235987755982988,
    )
    assert controller.options.delay and controller.options.lag_aware and controller.airframe == load("hummingbird")
    assert controller.cascade.position.name == "ladrc" and controller.cascade.attitude.name == "hybrid"
    assert content_sha256(file) == content_hash(json.loads(OLD)) and capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        (lambda d: d["gains"].pop("roll.k1"), "gains.roll.k1", "required and missing"),
        (lambda d: d["gains"]["roll.k2"].update(unit="rad"), "gains.roll.k2.unit", "must be in s-1"),
        (
            lambda d: d["gains"].update({"roll.lamda": d["gains"]["roll.k2"]}),
            "gains.roll.lamda",
            "did you mean 'roll.lambda'",
        ),
        (lambda d: d["gains"]["roll.k2"].update(unit="1/furlong"), "gains.roll.k2.unit", "given unit '1/furlong'"),
        (lambda d: d["controller"].pop("delay"), "controller.delay", "required and missing"),
        (lambda d: d["controller"].update(tilt=1), "controller.tilt", "unknown key 'tilt'"),
        (lambda d: d["airframe"].update(name="humingbird"), "airframe.name", "did you mean 'hummingbird'"),
        (
            lambda d: d["airframe"].update(name="/etc/passwd"),
            "airframe.name",
            "given '/etc/passwd'; a name is 1 to 64 letters",
        ),
        (lambda d: d["airframe"].update(name=3), "airframe.name", "this must be a text"),
        (lambda d: d["airframe"].pop("name"), "airframe.name", "required and missing"),
        (lambda d: d.pop("airframe"), "airframe.name", "required and missing"),
        (lambda d: d.pop("gains"), "gains", "required and missing"),
        (lambda d: d.update(gains=[]), "gains", "must be an object"),
        (lambda d: d.update(controller="pid"), "controller", "must be an object"),
    ],
)
def test_what_is_wrong_in_a_file_of_version_0_1_is_named(tmp_path, change, key, words):
    old = json.loads(OLD)
    change(old)
    with pytest.raises(InputError, match=".*") as caught:
        read_gains(written(tmp_path, old))
    assert caught.value.key == key and words in str(caught.value) and str(tmp_path) in str(caught.value)


def test_the_airframe_that_a_run_of_version_0_1_kept_flies_and_not_its_namesake(tmp_path, capsys):
    """A user's own hummingbird is not the bundled one; a study may bear the name too."""
    file = tmp_path / "gains.json"
    file.write_text(OLD)
    (tmp_path / "inputs").mkdir()
    kept = tmp_path / "inputs" / "hummingbird.toml"
    kept.write_text('title = "a study"\nseed = 1\n')
    assert read_gains(file).airframe.vehicle == airframe().vehicle
    kept.write_text(airframe().path.read_text().replace("mass = { value = 0.698", "mass = { value = 0.75"))
    (tmp_path / "hummingbird.toml").write_text("no airframe")
    assert read_gains(file).airframe.vehicle == airframe().vehicle._replace(mass=0.75)
    assert "another mass" in capsys.readouterr().err


def test_an_airframe_of_version_0_1_beside_the_gains_is_found(tmp_path):
    old = json.loads(OLD)
    old["airframe"]["name"] = "mine"
    file = written(tmp_path, old)
    with pytest.raises(UnknownNameError, match="unknown airframe 'mine'"):
        read_gains(file)
    (tmp_path / "mine.toml").write_text(airframe("iris").path.read_text())
    assert read_gains(file).airframe.vehicle == airframe("iris").vehicle
    assert read_gains(file, "iris").airframe.name == "iris"


def test_a_file_of_version_1_0_is_read(tmp_path):
    made = document() | {"version": "1.0"}
    del made["sha256"]
    assert read_gains(written(tmp_path, made)).gains == read_gains(written(tmp_path, document(), "now.json")).gains


def test_the_vehicle_that_gains_were_imported_from_is_read_and_written_again(tmp_path):
    whole = written(tmp_path, whole_document())
    read = read_gains(whole)
    assert read.vehicle is not None and read.vehicle.parameters == {"MC_ROLL_P": 6.5, "MC_ROLLRATE_D": 0.003}
    assert to_document(read, {})["vehicle"] == whole_document()["vehicle"]
    assert read_gains(written(tmp_path, document(), "other.json")).vehicle is None


@pytest.mark.parametrize("version", ["1.3", "1.12"])
def test_a_later_minor_version_says_who_wrote_it_and_what_to_do(tmp_path, version):
    made = document() | NEWER | {"version": version}
    with pytest.raises(
        InputError,
        match=rf"version {version} of the format by gainproof 3\.2\.1.*reads 0\.1, 1\.0, 1\.1 and 1\.2: update",
    ) as caught:
        read_gains(written(tmp_path, made))
    assert caught.value.key == "version"


@pytest.mark.parametrize("version", ["2.0", "0.2", "1", "1.0.0", 1.0, None, ["1.0"], "1.x", "٠.١"])
def test_an_unknown_version_is_refused(tmp_path, version):
    with pytest.raises(InputError, match="unknown version .*reads 0.1, 1.0, 1.1 and 1.2"):
        read_gains(written(tmp_path, document() | {"version": version}))


def test_a_missing_version_is_refused(tmp_path):
    made = document()
    del made["version"]
    with pytest.raises(InputError, match='write "version": "1.2"'):
        examine(written(tmp_path, made))


def test_the_steady_states_of_a_study_are_read_and_written_again(tmp_path):
    """Version 1.2; a file of 1.1 has none, and one with a vector of two numbers is refused by its place."""
    wind = [{"value": value, "unit": "m/s"} for value in (6.0, -2.5, 0.0)]
    still = [{"value": 0.0, "unit": "m/s"}] * 3
    state = {"name": "6.5 m/s wind", "yaw": {"value": 0.4, "unit": "rad"}, "velocity": still, "wind": wind}
    read = read_gains(
        written(tmp_path, {key: part for key, part in document().items() if key != "sha256"} | {"states": [state]})
    )
    assert read.states == (SteadyState("6.5 m/s wind", 0.4, (0.0, 0.0, 0.0), (6.0, -2.5, 0.0)),)
    assert to_document(read, {})["states"] == [state]
    assert read_gains(written(tmp_path, document(), "other.json")).states == ()
    short = document() | {"states": [state | {"wind": wind[:2]}]}
    del short["sha256"]
    with pytest.raises(InputError, match=r"states\[0\]\.wind"):
        read_gains(written(tmp_path, short, "short.json"))


def test_a_file_under_the_former_name_of_the_project_is_read_with_its_own_hash(tmp_path):
    """Format, generator and hash are those that version 0.2 wrote."""
    old = document() | {"format": "holdfast-gains", "generator": {"name": "holdfast", "version": "0.2.0"}}
    old["sha256"] = content_hash(old)
    file = tmp_path / "gains.json"
    file.write_text(json.dumps(old))
    assert read_gains(file).gains == read_gains(written(tmp_path, document(), "new.json")).gains
    assert content_sha256(file) == old["sha256"]
    file.write_text(json.dumps(old | {"format": "fastholding-gains"}))
    with pytest.raises(InputError, match="this must be 'gainproof-gains'"):
        read_gains(file)
