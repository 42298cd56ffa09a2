"""MATLAB and Octave: Octave reads the struct bit for bit, with columns for vectors, and the same numbers as gains.json."""

import json
import re
import struct
import subprocess
from dataclasses import replace

import pytest

from plant.law_registry import LAWS
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.nominal import ControlOptions
from tests.clients import program
from tests.tuner.exchange.controllers import controller
from tuner.exchange.target import Request
from tuner.extensions.matlab.export import FILE, TARGET, path
from tuner.gains import to_document

# Numbers that decimal fractions do not hold, and sizes from nano to giga.
AWKWARD = [0.1, 1.0 / 3.0, 2.0 / 3.0 * 1e-9, 123456789.12345678, 5e-324, 1.7976931348623157e308, 60.0]
DUMP = """
c = gainproof_gains();
function walk(place, value, unit)
  if isstruct(value)
    for [inner, name] = value
      if isstruct(unit) && isfield(unit, name) walk([place '.' name], inner, unit.(name)); else walk([place '.' name], inner, ''); end
    end
  elseif ischar(value)
    printf('%s|%s|text|%s\\n', place, class(value), value);
  else
    printf('%s|%s|%dx%d|%s|%s\\n', place, class(value), rows(value), columns(value), num2hex(double(value(:)))'(:)', unit);
  end
end
units = c.units; c = rmfield(c, 'units');
walk('c', c, units);
j = jsondecode(fileread('gains.json'));
for [entry, name] = j.gains
  printf('json.%s|%s|1x1|%s|%s\\n', name, class(entry.value), num2hex(entry.value), entry.unit);
end
"""


def request(given):
    return Request(given, "e" * 64, {})


def octave(folder, script):
    (folder / "ask.m").write_text("1;\n" + script)
    command = [program("octave"), "--no-gui", "--norc", "--quiet", "ask.m"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def bits(values):
    return "".join(struct.pack(">d", value).hex() for value in values)


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    """What Octave reads: a law's gains with awkward numbers in place of some, and gains.json beside it."""
    folder = tmp_path_factory.mktemp("matlab")
    given = controller("adrc", "hybrid", period=0.0035, options=ControlOptions(delay=True, tilt_limit=0.4))
    given = replace(given, gains=(*AWKWARD, *given.gains[len(AWKWARD) :]))
    (folder / FILE).write_bytes(TARGET.export(request(given)).files[FILE])
    (folder / "gains.json").write_text(json.dumps(to_document(given, {})))
    rows = [line.split("|") for line in octave(folder, DUMP)]
    return given, {row[0]: row[1:] for row in rows}


def test_every_gain_is_read_bit_for_bit_with_its_unit(read):
    given, found = read
    for gain in gain_addresses(given.cascade):
        assert found[f"c.gains.{gain.address}"] == ["double", "1x1", bits([given.gains[gain.column]]), gain.unit], (
            gain.address
        )


def test_gains_json_gives_the_same_numbers(read):
    """jsondecode turns "roll.kp" into roll_kp; Octave's takes some numbers for their neighbour, two ulp at the most."""
    given, found = read
    for gain in gain_addresses(given.cascade):
        kind, size, digits = found[f"json.{gain.address.replace('.', '_')}"][:3]
        (value,) = struct.unpack(">d", bytes.fromhex(digits))
        assert (kind, size) == ("double", "1x1")
        assert value == pytest.approx(given.gains[gain.column], rel=4.5e-16, abs=0), gain.address


def test_the_airframe_is_read_with_columns(read):
    given, found = read
    for name, value in given.airframe.vehicle._asdict().items():
        parts = value if isinstance(value, tuple) else (value,)
        kind, size, digits, unit = found[f"c.airframe.{name}"]
        assert (kind, size, digits) == ("double", f"{len(parts)}x1", bits(parts)), name
        assert unit, name
    assert found["c.airframe.inertia"][3] == "kg m2" and found["c.airframe.thrust_coefficient"][3] == "N s2"


def test_sample_time_limits_and_texts_are_read(read):
    given, found = read
    vehicle = given.airframe.vehicle
    assert found["c.sample_time"] == ["double", "1x1", bits([0.0035]), "s"]
    assert found["c.limits.tilt"] == ["double", "1x1", bits([0.4]), "rad"]
    assert found["c.limits.rotor_thrust_max"][2:] == [bits([vehicle.thrust_coefficient * vehicle.speed_max**2]), "N"]
    assert found["c.laws.delay"][0] == found["c.laws.lag_aware"][0] == "logical"
    assert found["c.laws.attitude"][-1] == "hybrid" and found["c.source.digest"][-1] == "e" * 64


def test_every_unit_stands_in_the_comment_too(read):
    given, _ = read
    text = TARGET.export(request(given)).files[FILE].decode()
    for gain in gain_addresses(given.cascade):
        line = next(line for line in text.splitlines() if line.startswith(f"c.gains.{gain.address} = "))
        assert line.endswith(f"% {gain.unit}")


@pytest.mark.parametrize("law", list(LAWS))
def test_every_law_can_be_carried(law):
    given = controller(law, law)
    bundle = TARGET.export(request(given))
    text = bundle.files[FILE].decode()
    names = re.findall(r"^(c[\w.]*) =", text, re.MULTILINE)
    assert len(names) == len(set(names))
    assert all(re.fullmatch(r"[A-Za-z]\w{0,62}", part) for name in names for part in name.split("."))
    for word in ("e" * 64, "hummingbird", law, "gainproof"):
        assert word in text
    assert bundle.held is given
    assert bundle.rollback[FILE] != bundle.files[FILE]


def test_a_quote_in_a_text_stays_a_text(tmp_path):
    given = controller()
    named = replace(given, airframe=replace(given.airframe, name="o'hare"))
    (tmp_path / FILE).write_bytes(TARGET.export(request(named)).files[FILE])
    assert octave(tmp_path, "c = gainproof_gains(); disp(c.airframe.name)") == ["o'hare"]


@pytest.mark.parametrize("name", ["end", "1st", "a-b", "_x", "x" * 64])
def test_a_name_that_matlab_does_not_take_is_our_mistake(name):
    with pytest.raises(AssertionError, match="takes no field"):
        path(f"gains.{name}")


def test_the_rollback_is_the_previous_gains_json(tmp_path):
    flown = controller("pid", "pid", roll__kp=71.5)
    previous = tmp_path / "gains.json"
    previous.write_text(json.dumps(to_document(flown, {})))
    back = TARGET.export(replace(request(controller()), previous=previous)).rollback[FILE].decode()
    assert "c.gains.roll.kp = 71.5;" in back and "flown before" in back
