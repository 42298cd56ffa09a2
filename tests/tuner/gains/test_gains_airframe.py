"""The airframe in gains.json: its numbers fly, whatever is bundled under its name."""

import json
from dataclasses import replace

import pytest

from plant.errors import InputError
from plant.law_registry import LAWS
from plant.quadrotor.airframes import names
from plant.quadrotor.nominal import mixer_matrix
from plant.vectors import Rotors
from tests.tuner.gains.making import airframe, controller, document, neighbour, rehashed, written
from tuner.gains import read_gains, to_document
from tuner.gains.airframe_block import AirframePart, airframe_block
from tuner.gains.hashing import canonical_hash


def heavier(made, mass=0.75):
    """The document of a hummingbird of another mass, as its owner would have it."""
    own = airframe()
    changed = own.__class__(**{**vars(own), "vehicle": own.vehicle._replace(mass=mass)})
    return rehashed(made | {"airframe": json.loads(json.dumps(airframe_block(changed)))})


@pytest.mark.parametrize("name", names())
def test_every_airframe_is_told_bit_for_bit(name, tmp_path, capsys):
    made = document(frame=name)
    assert AirframePart(**made["airframe"]).vehicle == airframe(name).vehicle
    if name != "paper-literal":
        assert read_gains(written(tmp_path, made)).airframe == airframe(name)
    assert made["airframe"].get("allow_unphysical", False) is (name == "paper-literal")
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("position", LAWS)
def test_every_law_comes_back_bit_for_bit_in_either_place(position, tmp_path):
    for attitude in sorted({position, "pid", neighbour(position)}):
        made = controller(position, attitude)
        gains = tuple(gain * (1.0 + 1.0 / 3.0) ** 0.01 for gain in made.gains)
        made = made.__class__(**{**vars(made), "gains": gains})
        file = written(tmp_path, to_document(made, {}))
        again = read_gains(file)
        assert again.gains == gains and again.options == made.options
        assert [again.cascade.position.name, again.cascade.attitude.name] == [position, attitude]
        assert to_document(again, {}) == to_document(made, {})


def test_the_numbers_of_the_file_fly_and_a_note_says_so_once(tmp_path, capsys):
    file = written(tmp_path, heavier(document()))
    flown = read_gains(file).airframe
    assert flown.vehicle == airframe().vehicle._replace(mass=0.75) and flown.name == "hummingbird"
    assert flown.sources["mass"].value == 0.75 and "gains.json" in flown.sources["mass"].source
    note = capsys.readouterr().err
    assert note.startswith("Note: ") and note.count("\n") == 1 and "'hummingbird'" in note and "another mass" in note
    read_gains(file)
    assert capsys.readouterr().err == ""
    assert read_gains(file, "hummingbird").airframe == airframe()


def test_a_users_own_airframe_needs_no_file(tmp_path, capsys):
    made = heavier(document())
    made["airframe"]["name"] = "mine"
    flown = read_gains(written(tmp_path, rehashed(made))).airframe
    assert (flown.name, flown.vehicle.mass) == ("mine", 0.75) and capsys.readouterr().err == ""


def test_the_hash_of_the_airframe_is_that_of_its_numbers():
    one, other = document(frame="hummingbird"), document(frame="paper-corrected")
    assert (
        one["airframe"]["sha256"] != other["airframe"]["sha256"]
        or one["airframe"]["numbers"] == other["airframe"]["numbers"]
    )
    block = one["airframe"]
    expected = canonical_hash({"numbers": block["numbers"], "rotors": block["actuation"]["rotors"]})
    assert block["sha256"] == expected == airframe_block(airframe())["sha256"]


def test_actuation_is_that_of_the_vehicle():
    """Thrust at speed_max and the command at which four rotors of T = T_max u^2 carry the weight; rotors as the mixer has them."""
    made, vehicle = document()["airframe"]["actuation"], airframe().vehicle
    assert made["thrust_max"] == {"value": pytest.approx(6.947e-6 * 900.6**2), "unit": "N"}
    assert 4.0 * made["thrust_max"]["value"] * made["hover_command"]["value"] ** 2 == pytest.approx(0.698 * 9.81)
    mixer = mixer_matrix(vehicle)
    for k, rotor in enumerate(made["rotors"]):
        assert rotor["position"]["y"]["value"] == mixer[1, k] and -rotor["position"]["x"]["value"] == mixer[2, k]
        turn = {"clockwise": 1.0, "counterclockwise": -1.0}[rotor["spin"]]
        assert turn * rotor["torque_ratio"]["value"] == mixer[3, k]
    # Rotor 1 is at the front left and turns clockwise seen from above, which pushes the body about +z, to the left.
    assert made["rotors"][0]["position"]["x"]["value"] > 0.0 < made["rotors"][0]["position"]["y"]["value"]
    assert [rotor["spin"] == "clockwise" for rotor in made["rotors"]] == [spin > 0 for spin in vehicle.spin]


def at(block, key):
    for part in key.split("."):
        block = block[int(part)] if part.isdigit() else block[part]
    return block


@pytest.mark.parametrize(
    ("key", "value", "named", "words"),
    [
        ("numbers.mass", 0.8, "airframe.actuation.hover_thrust.value", "from the airframe's numbers follows 1.962"),
        ("numbers.mass", 2.5, "airframe.numbers", "thrust"),
        ("numbers.inertia.z", 0.1, "airframe.numbers", "triangle inequality"),
        (
            "numbers.thrust_coefficient",
            1e-40,
            "airframe.numbers.thrust_coefficient.value",
            "allowed: 0, or a size from",
        ),
        ("numbers.speed_max", 1e200, "airframe.numbers.speed_max.value", "allowed: 0, or a size from"),
        ("numbers.lag_up", -0.02, "airframe.numbers.lag_up.value", "above 0"),
        ("numbers.drag_linear.x", -1.0, "airframe.numbers.drag_linear.x.value", "at least 0"),
        ("actuation.thrust_max", 6.0, "airframe.actuation.thrust_max.value", "given 6"),
        ("actuation.lag", 0.01, "airframe.actuation.lag.value", "follows 0.02"),
        ("actuation.thrust_curve.factor", 0.5, "airframe.actuation.hover_command.value", "correct either"),
        ("actuation.rotors.0.position.y", 0.5, "airframe.sha256", "another hash"),
        ("actuation.rotors.2.torque_ratio", 0.02, "airframe.actuation.rotors[2].torque_ratio.value", "follows 0.03523"),
    ],
)
def test_numbers_that_contradict_each_other_are_refused(tmp_path, key, value, named, words):
    made = document()
    at(made["airframe"], key)["value"] = value
    with pytest.raises(InputError) as caught:
        read_gains(written(tmp_path, rehashed(made)))
    assert caught.value.key == named and words in str(caught.value)


def test_a_thrust_curve_of_another_factor_is_kept(tmp_path):
    made = document()
    actuation = made["airframe"]["actuation"]
    actuation["thrust_curve"]["factor"]["value"] = 0.0
    actuation["hover_command"]["value"] = actuation["hover_thrust"]["value"] / actuation["thrust_max"]["value"]
    assert read_gains(written(tmp_path, rehashed(made))).airframe == airframe()


def test_an_airframe_with_a_thrust_curve_comes_back(tmp_path):
    """Its factor and hover command follow from thrust_linear; 1.3 is steeper than the square."""
    for linear in (0.4, -0.3):
        plain = airframe()
        bent = replace(plain, vehicle=plain.vehicle._replace(thrust_linear=linear))
        made = rehashed(document() | {"airframe": json.loads(json.dumps(airframe_block(bent)))})
        assert made["airframe"]["actuation"]["thrust_curve"]["factor"]["value"] == pytest.approx(1.0 - linear)
        assert read_gains(written(tmp_path, made)).airframe.vehicle == bent.vehicle


def test_rotors_that_make_no_torques_are_refused(tmp_path):
    own = airframe()
    still = own.__class__(**{**vars(own), "vehicle": own.vehicle._replace(rotor_x=Rotors(0.0, 0.0, 0.0, 0.0))})
    made = rehashed(document() | {"airframe": json.loads(json.dumps(airframe_block(still)))})
    with pytest.raises(InputError, match="no independent roll, pitch and yaw"):
        read_gains(written(tmp_path, made))


def test_what_no_real_airframe_can_be_must_be_allowed(tmp_path):
    made = document(frame="paper-literal")
    made["controller"]["plant_step"]["value"] = 0.001
    file = written(tmp_path, rehashed(made))
    assert read_gains(file).airframe == airframe("paper-literal")
    del made["airframe"]["allow_unphysical"]
    with pytest.raises(InputError, match='no real airframe.*"allow_unphysical": true'):
        read_gains(written(tmp_path, rehashed(made)))
