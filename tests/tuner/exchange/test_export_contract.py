"""What every exporter promises; a new entry of the registry is tested by all of this."""

import json
import re
from dataclasses import replace
from importlib.metadata import version
from pathlib import PurePosixPath

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.gains import gain_addresses
from tests.tuner.exchange.controllers import controller, pid
from tuner.api.catalogue import targets
from tuner.exchange.registry import exporter, exporters, settings_of
from tuner.exchange.run import bundle_of, check_laws
from tuner.exchange.target import Request

VERSION = version("gainproof")
DIGEST = "0123456789abcdef" * 4
# What an option that must be given is given in these tests.
GIVEN = {"ardupilot": ("firmware=4.7",)}
CONTROLLERS = {
    "pid": pid(period=0.002),
    "ladrc": controller("ladrc", "ladrc", period=0.002, roll__zeta=1.0, pitch__zeta=1.0, yaw__zeta=1.0),
    "hybrid": controller("ladrc", "hybrid", period=0.002),
    "px4": controller("px4_position", "px4", period=0.002, every=4),
    "crazyflie": controller("pid", "crazyflie", period=0.002, every=5),
    "betaflight_adrc": controller("pid", "betaflight_adrc", period=0.002),
}
# Resolution of a target in our gains: float32 is 6e-8; integers of a command line are coarse.
RESOLUTION = {"betaflight": 0.2}


def request_of(entry, given, digest=DIGEST):
    return Request(given, digest, settings_of(entry, GIVEN.get(entry.name, ())))


def carries(entry, given):
    try:
        check_laws(entry, Request(given, DIGEST, {}))
    except InputError:
        return False
    return True


CARRIED = [
    (entry, name) for entry in exporters().values() for name, given in CONTROLLERS.items() if carries(entry, given)
]
BUNDLES = {}
PAIRS = [pytest.param(entry, CONTROLLERS[name], id=f"{entry.name}-{name}") for entry, name in CARRIED]
# Compilers take 2 s a mock-up unit; tests/tuner/extensions/fmi has the same bytes of compiled ones.
pytestmark = pytest.mark.usefixtures("few_golden_vectors", "uncompiled")


def exported(entry, given):
    """Return the bundle of an exporter, made once: golden vectors and compilers take half a second a time."""
    key = entry.name, given.cascade.attitude.name
    if key not in BUNDLES:
        BUNDLES[key] = entry.export(request_of(entry, given))
    return BUNDLES[key]


def test_every_exporter_carries_something():
    assert {entry.name for entry, _ in CARRIED} == set(exporters())


def test_registry_names_and_listing():
    assert all(name == entry.name and entry.title for name, entry in exporters().items())
    assert [row["target"] for row in targets()] == list(exporters())
    with pytest.raises(InputError, match="did you mean 'px4'"):
        exporter("px5")


@pytest.mark.parametrize(("entry", "given"), PAIRS)
def test_same_gains_same_bytes_other_gains_other_bytes(entry, given):
    first, again = exported(entry, given), entry.export(request_of(entry, given))
    assert dict(first.files) == dict(again.files) and dict(first.rollback) == dict(again.rollback)
    more = replace(given, gains=tuple(1.3 * gain if abs(gain) != 1.0 else gain for gain in given.gains))
    assert dict(entry.export(request_of(entry, more)).files) != dict(first.files)


@pytest.mark.parametrize(("entry", "given"), PAIRS)
def test_files_and_rollback_are_there_and_safely_named(entry, given):
    bundle = exported(entry, given)
    assert bundle.files and bundle.rollback
    for name, content in (*bundle.files.items(), *bundle.rollback.items()):
        path = PurePosixPath(name)
        assert not path.is_absolute() and ".." not in path.parts and re.fullmatch(r"[\w./-]+", name), name
        assert isinstance(content, bytes) and (content or name.endswith("__init__.py"))


@pytest.mark.parametrize(("entry", "given"), PAIRS)
def test_some_text_names_the_gains_the_airframe_and_the_tool(entry, given):
    bundle = exported(entry, given)
    texts = [content.decode(errors="replace") for content in bundle.files.values()]
    for word in (DIGEST[:12], given.airframe.name, "gainproof"):
        assert any(word in text for text in texts), word


@pytest.mark.parametrize(("entry", "given"), PAIRS)
def test_bundle_and_rollback_name_the_version_of_the_tool(entry, given):
    bundle = exported(entry, given)
    for files in (bundle.files, bundle.rollback):
        assert any(f"gainproof {VERSION}" in content.decode(errors="replace") for content in files.values())


@pytest.mark.parametrize(("entry", "given"), PAIRS)
def test_nothing_tells_of_the_machine_or_the_hour(entry, given):
    bundle = exported(entry, given)
    for name, content in bundle.files.items():
        text = content.decode(errors="replace")
        assert not re.search(r"\b20\d\d-\d\d-\d\d\b|/(?:home|tmp|root)/", text), name


@pytest.mark.parametrize(("entry", "given"), PAIRS)
def test_what_is_held_is_what_was_asked_to_the_targets_resolution(entry, given):
    """A target without a place for our derivative filter holds none, or its own, and says so."""
    bundle = exported(entry, given)
    held = bundle.held
    assert held.cascade.position.name == given.cascade.position.name
    assert held.cascade.attitude.name == given.cascade.attitude.name
    assert held.airframe == given.airframe
    filters = [gain.column for gain in gain_addresses(given.cascade) if gain.info.name == "t_f"]
    mine, its = np.array(given.gains), np.array(held.gains)
    if not np.allclose(its[filters], mine[filters], rtol=3e-7, atol=0.0):
        assert any("filter" in sentence for sentence in bundle.differences)
        its[filters] = mine[filters]
    np.testing.assert_allclose(its, mine, rtol=RESOLUTION.get(entry.name, 3e-7), atol=1e-12)


@pytest.mark.parametrize(("entry", "given"), PAIRS)
def test_losses_are_sentences(entry, given):
    for sentence in exported(entry, given).differences:
        assert re.fullmatch(r"\S.{20,}[.)]", sentence, re.DOTALL) and "\n" not in sentence, sentence


@pytest.mark.parametrize(("entry", "given"), PAIRS)
def test_parameters_lie_in_their_ranges_and_have_units(entry, given):
    names = set()
    for parameter in exported(entry, given).parameters:
        assert parameter.low <= parameter.held <= parameter.high, parameter
        assert parameter.unit and parameter.name not in names
        names.add(parameter.name)


@pytest.mark.parametrize(("entry", "given"), PAIRS)
@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_a_gain_that_is_no_number_is_refused(entry, given, value):
    for gain in gain_addresses(given.cascade):
        gains = list(given.gains)
        gains[gain.column] = value
        with pytest.raises(InputError) as caught:
            bundle_of(entry, request_of(entry, replace(given, gains=tuple(gains))))
        assert caught.value.key == gain.address


@pytest.mark.parametrize("entry", exporters().values(), ids=exporters())
def test_documents_are_json(entry):
    """Options can be listed, and each that has no default has choices or says its unit."""
    rows = json.loads(json.dumps([vars(option) for option in entry.options]))
    assert all(row["about"] for row in rows)
