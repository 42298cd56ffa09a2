"""What is in the FMU and beside it: GUID, units, sources that build, gains as SSV, the same bytes every time."""

import io
import re
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from fractions import Fraction

import pytest

import tuner.extensions.fmi.export as exporter
from plant.law_registry import LAWS
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.sensors import Measurement
from plant.records import flatten, paths
from plant.references.track import Reference
from plant.vectors import Quaternion, Vec3
from tests.clients import ask, program
from tests.tuner.extensions.fmi.fmus import STEP_INPUTS, STEP_OUTPUTS, request
from tuner.exchange.c99.entries import measurement_of
from tuner.exchange.registry import settings_of
from tuner.extensions.fmi import archive
from tuner.extensions.fmi.export import TARGET, fmu
from tuner.extensions.fmi.variables import base_unit, exponents, variables
from tuner.gains import content_hash, to_document

SOURCES = ["binding.h", "fmi2_cosimulation.c", "fmi2_interface.h", "gainproof_controller.c", "gainproof_controller.h"]


def content(mock_up: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(mock_up)) as held:
        return {name: held.read(name) for name in held.namelist()}


def description(mock_up: bytes) -> ET.Element:
    return ET.fromstring(content(mock_up)["modelDescription.xml"])


def test_the_same_gains_give_the_same_bytes_and_anything_else_gives_another_guid(monkeypatch):
    program("gcc")
    mock_up = fmu(request())[0]
    assert fmu(request())[0] == mock_up
    with zipfile.ZipFile(io.BytesIO(mock_up)) as held:
        assert {entry.date_time for entry in held.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert held.namelist() == sorted(held.namelist())
    others = [
        request(factor=1.0000001),
        request(digest="f" * 64),
        request("double"),
        request(attitude="adrc"),
        request(period=0.004),
        request(delay=True),
    ]
    # The binary has no part in it.
    monkeypatch.setattr("tuner.extensions.fmi.archive.compiler", lambda: None)
    guids = [description(fmu(one)[0]).get("guid") for one in [request(), *others]]
    assert len(set(guids)) == len(guids) and guids[0] == description(mock_up).get("guid")


def test_library_and_description_have_one_guid_and_every_source_is_inside():
    program("gcc")
    parts = content(fmu(request())[0])
    guid = ET.fromstring(parts["modelDescription.xml"]).get("guid")
    assert guid and re.fullmatch(r"\{[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}\}", guid)
    assert parts["binaries/linux64/gainproof_controller.so"].count(guid.encode()) >= 1
    assert sorted(name.removeprefix("sources/") for name in parts if name.startswith("sources/")) == SOURCES
    assert guid in parts["sources/binding.h"].decode()


def test_the_sources_build_without_a_warning(tmp_path):
    gcc = program("gcc")
    for real in ("float", "double"):
        for name, text in fmu(request(real, delay=real == "double"))[1].sources.items():
            (tmp_path / name).write_text(text)
        strict = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wshadow", "-Wstrict-prototypes", "-Werror"]
        units = [name for name in SOURCES if name.endswith(".c")]
        done = subprocess.run([gcc, *strict, "-fsyntax-only", *units], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


def test_variables_have_units_and_gains_are_constants_of_the_file():
    asked = request()
    root = description(fmu(asked)[0])
    about = {one.get("name"): one for one in root.iter("ScalarVariable")}
    kinds = [one.get("causality") for one in about.values()]
    assert (kinds.count("input"), kinds.count("output")) == (STEP_INPUTS, STEP_OUTPUTS)
    assert {one.get("variability") for one in about.values() if one.get("causality") != "local"} == {"discrete"}
    gains = asked.controller.gains
    for gain in gain_addresses(asked.controller.cascade):
        one = about[f"gains.{gain.address}"]
        number = one.find("Real")
        assert one.get("variability") == "constant" and number is not None
        assert float(number.get("start", "nan")) == gains[gain.column] and number.get("unit") == gain.unit
    step = root.find("CoSimulation")
    assert step is not None and step.get("canHandleVariableCommunicationStepSize") == "false"
    experiment = root.find("DefaultExperiment")
    assert experiment is not None and float(experiment.get("stepSize", "nan")) == asked.controller.control_period
    defined = {one.get("name"): one.find("BaseUnit") for one in root.iter("Unit")}
    newton = defined["N m"]
    assert newton is not None and newton.attrib == {"kg": "1", "m": "2", "s": "-2"}
    assert defined["rad^(1/2) s^(-3/2)"] is None


@pytest.mark.parametrize(
    ("unit", "parts"),
    [
        ("1", {}),
        ("m/s^2", {"m": 1, "s": -2}),
        ("N", {"kg": 1, "m": 1, "s": -2}),
        ("s^-3", {"s": -3}),
        ("m s^-3", {"m": 1, "s": -3}),
        ("rad^(-1/2) s^(1/2)", {"rad": Fraction(-1, 2), "s": Fraction(1, 2)}),
        ("N m s/rad", {"kg": 1, "m": 2, "s": -1, "rad": -1}),
    ],
)
def test_units_as_exponents(unit, parts):
    assert exponents(unit) == parts


def test_a_multiple_of_a_base_unit_has_a_factor():
    assert base_unit("us") == {"s": 1, "factor": 1e-6} and base_unit("%") == {"factor": 0.01}


def test_every_gain_of_every_law_has_a_unit_that_can_be_taken_apart():
    for law in LAWS.values():
        for gain in law.gains:
            for loop in ("attitude", "position"):
                whole = base_unit(gain.unit_in(loop))
                assert (whole is None) == ("/2)" in gain.unit)


@pytest.mark.parametrize("attitude", ["adrc", "hybrid"])
def test_fmpy_reads_the_gains_from_the_ssv_file(attitude, tmp_path):
    asked = request(attitude=attitude)
    path = tmp_path / "gainproof.ssv"
    path.write_bytes(exporter.gain_values(asked))
    script = """
import json, sys
from fmpy.ssp.ssd import read_ssv
found = read_ssv(sys.argv[1], validate=True).parameters
print(json.dumps([[one.name, float(one.value), one.unit] for one in found]))
"""
    gains = asked.controller.gains
    wanted = [
        [f"gains.{g.address}", gains[g.column], None if "/2)" in g.unit else g.unit]
        for g in gain_addresses(asked.controller.cascade)
    ]
    assert ask("fmi", script, str(path)) == wanted


def test_without_gcc_the_fmu_is_still_valid_and_says_that_it_has_to_be_built(monkeypatch, tmp_path):
    monkeypatch.setattr(archive, "compiler", lambda: None)
    bundle = TARGET.export(request())
    assert not any(name.startswith("binaries/") for name in content(bundle.files["gainproof.fmu"]))
    assert any("sources only" in sentence for sentence in bundle.differences)
    path = tmp_path / "a.fmu"
    path.write_bytes(bundle.files["gainproof.fmu"])
    script = "import json, sys; from fmpy.validation import validate_fmu; print(json.dumps(validate_fmu(sys.argv[1])))"
    assert ask("fmi", script, path) == []


def test_the_bundle_holds_what_was_asked_and_goes_back_to_the_defaults(monkeypatch):
    monkeypatch.setattr(archive, "compiler", lambda: None)
    assert settings_of(TARGET, []) == {"real": "float"}
    asked = request(factor=1.1)
    single, double = TARGET.export(asked), TARGET.export(request("double", factor=1.1))
    assert double.held.gains == asked.controller.gains
    assert single.held.gains == pytest.approx(asked.controller.gains, rel=2.0**-24)
    assert single.held.gains != asked.controller.gains
    assert sorted(single.rollback) == ["README.txt", "gainproof.fmu", "gainproof.ssv"]
    back = request(digest=content_hash(to_document(request().controller, {})))
    assert single.rollback["gainproof.fmu"] == fmu(back)[0] != single.files["gainproof.fmu"]
    delayed = TARGET.export(request(delay=True))
    assert any("one control period" in said for said in single.differences)
    assert not any("one control period" in said for said in delayed.differences)
    for name in (
        "modelDescription.xml",
        "documentation/index.html",
        "resources/gainproof.ssv",
        "sources/gainproof_controller.h",
    ):
        text = content(single.files["gainproof.fmu"])[name].decode()
        assert asked.digest in text and "hummingbird" in text and "hybrid" in text and "gainproof" in text


def test_inputs_that_nobody_sets_are_those_of_a_vehicle_that_holds_its_place_at_rest():
    origin = Vec3(0.0, 0.0, 0.0)
    level = measurement_of(origin, origin, Quaternion(1.0, 0.0, 0.0, 0.0), origin)
    held = Reference(origin, origin, origin, 0.0, 0.0, 0.0, 0.0, hold=1.0)
    parts = (("reference", Reference, held), ("measurement", Measurement, level))
    expected = {
        f"{name}.{path}": leaf
        for name, kind, record in parts
        for path, leaf in zip(paths(kind), flatten(record), strict=True)
    }
    inputs = [each for each in variables(request().controller) if each.kind == "input"]
    assert {each.name: each.start for each in inputs} == expected
