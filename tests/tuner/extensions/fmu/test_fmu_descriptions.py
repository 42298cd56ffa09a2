"""What an FMU says of itself is read without running it, and what cannot be trusted or used is refused in one line."""

import stat
import zipfile
from io import BytesIO

import pytest

from plant.errors import InputError, UnknownNameError
from plant.records import flatten, paths
from tests.tuner.extensions.fmu.fmus import description, write_archive, write_motor
from tuner.extensions.fmu import archive as archives
from tuner.extensions.fmu.archive import open_archive, unpacked
from tuner.extensions.fmu.description import as_name
from tuner.extensions.fmu.fmu_model import read_fmu

each_version = pytest.mark.parametrize("version", [2, 3])


@each_version
def test_records_have_names_units_and_start_values(tmp_path, version):
    motor = read_fmu(write_motor(tmp_path, version), ["torque"])
    kinds = (motor.State, motor.Input, motor.Disturbance, motor.Output)
    assert [paths(kind) for kind in kinds] == [("angle", "motor_speed"), ("voltage",), ("torque",), ("angle",)]
    assert motor.unit("State.motor_speed") == "rad/s"
    assert motor.parameters.resistance == 4.0 and flatten(motor.parameters)[0] == 3.2284e-6
    assert motor.title == "Angle of a DC motor"
    assert len(motor.interface.derivatives) == 2


@each_version
def test_states_are_those_of_the_study_or_else_the_outputs(tmp_path, version):
    silent = write_motor(tmp_path, version, states=False)
    assert paths(read_fmu(silent).State) == ("angle",)
    named = read_fmu(silent, states=["angle", "motor_speed"])
    assert paths(named.State) == ("angle", "motor_speed")
    assert named.interface.derivatives == ()


def test_units_come_from_declared_types_and_from_the_study(tmp_path):
    bare = description(2).replace('unit="V"', "").replace('unit="Ohm"', "")
    file = write_motor(tmp_path, 2, text=bare)
    with pytest.raises(InputError, match=r"voltage has no unit; write one behind units\.voltage"):
        read_fmu(file)
    assert "resistance" not in paths(read_fmu(file, units={"voltage": "V"}).Parameters)
    assert read_fmu(file, units={"voltage": "mV"}).unit("Input.voltage") == "mV"
    with pytest.raises(UnknownNameError, match="did you mean 'voltage'"):
        read_fmu(file, units={"volage": "V"})
    types = '<TypeDefinitions><SimpleType name="Volt"><Real unit="V"/></SimpleType></TypeDefinitions><ModelVariables>'
    declared = description(2).replace('unit="V"', 'declaredType="Volt"').replace("<ModelVariables>", types)
    assert read_fmu(write_motor(tmp_path, 2, text=declared)).unit("Input.voltage") == "V"


@pytest.mark.parametrize(
    ("given", "name"), [("der(x[1])", "der_x_1"), ("a.b", "a_b"), ("3way", "v3way"), ("class", "class_"), ("_", "v")]
)
def test_names_are_those_of_python(given, name):
    assert as_name(given) == name


WRONG = {
    "FMI 1": ('fmiVersion="2.0"', 'fmiVersion="1.0"', "read are FMI 2.0 and 3.0"),
    "model exchange": ("<CoSimulation", "<ModelExchange", "ModelExchange"),
    "a path in its name": ('modelIdentifier="motor"', 'modelIdentifier="../motor"', "a name of C"),
    "entities": ("<fmiModel", '<!DOCTYPE x [<!ENTITY a "b">]><fmiModel', "document type"),
    "no XML": ("</ModelVariables>", "", "no XML"),
    "no number": ('start="0.0274"', 'start="inf"', "finite number"),
    "an escape": ('description="Angle', 'description="&#x202E;Angle', r"U\+202E"),
    "a huge reference": ('valueReference="6"', 'valueReference="99999999999"', "valueReference"),
    "two names in one": ('name="friction"', 'name="inertia."', "both written inertia"),
    "no output": ('causality="output"', 'causality="local"', "no output"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_used_is_refused(tmp_path, case):
    before, after, told = WRONG[case]
    text = description(2)
    assert before in text
    with pytest.raises(InputError, match=told) as error:
        read_fmu(write_motor(tmp_path, 2, text=text.replace(before, after)))
    assert error.value.file == str(tmp_path / "motor.fmu")


@pytest.mark.parametrize("name", ["../outside", "/etc/outside", "a\\..\\b", "C:outside", "a/../../b"])
def test_no_file_leaves_its_folder(tmp_path, name):
    file = write_archive(tmp_path / "motor.fmu", {"modelDescription.xml": description(2).encode(), name: b"x"})
    with pytest.raises(InputError, match="inside its own folder"):
        open_archive(file)


def test_links_are_refused(tmp_path):
    file = write_motor(tmp_path, 2)
    with zipfile.ZipFile(file, "a") as archive:
        link = zipfile.ZipInfo("resources/link")
        link.external_attr = (stat.S_IFLNK | 0o777) << 16
        archive.writestr(link, "/etc/passwd")
    with pytest.raises(InputError, match="no plain file"):
        open_archive(file)


def test_what_would_fill_the_disk_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(archives, "MAX_CONTENT_BYTES", 2**20)
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", description(2))
        archive.writestr("resources/zeros", bytes(2**21))
    file = tmp_path / "bomb.fmu"
    file.write_bytes(content.getvalue())
    assert file.stat().st_size < 2**14
    with pytest.raises(InputError, match="at most"):
        open_archive(file)


def test_what_is_no_archive_is_refused(tmp_path):
    file = tmp_path / "motor.fmu"
    file.write_bytes(b"\x7fELF")
    with pytest.raises(InputError, match="ZIP"):
        open_archive(file)
    with pytest.raises(InputError, match=r"holds no modelDescription\.xml"):
        open_archive(write_archive(file, {"a": b"b"}))


def test_machine_code_of_another_machine_is_told(tmp_path):
    content = {"modelDescription.xml": description(2).encode(), "binaries/win16/motor.dll": b"MZ"}
    with pytest.raises(InputError, match="built for win16"):
        read_fmu(write_archive(tmp_path / "motor.fmu", content))


def test_what_has_changed_since_is_not_unpacked(tmp_path):
    found = open_archive(write_motor(tmp_path, 2))
    write_motor(tmp_path, 2, states=False)
    with pytest.raises(InputError, match="has changed since"):
        unpacked(found.file, found.digest)
