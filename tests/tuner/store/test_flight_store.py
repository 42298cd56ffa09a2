"""The memory of flights: what is kept is recalled to the bit, damage is noticed, nothing else is ever believed."""

import numpy as np
import pytest

from objectives.flown_system import FlightBatch
from objectives.memory import scenario_key
from plant.quadrotor.scenarios import HELD_OUT, SEARCH
from plant.seeds import generator
from tests.tables import read_frame
from tests.tuner.conftest import QUICKSTART
from tuner.store.flights import RESULTS, FlightStore
from tuner.store.folder import Folder
from tuner.study.build import load_study

COLUMNS = ("x.omega_c", "x.zeta", "roll.k1")


@pytest.fixture(scope="module")
def batch():
    return FlightBatch(load_study(QUICKSTART, {"margin": []}).scenarios[0].spec, SEARCH, 8)


def made(count, flights=8, stream="made"):
    draw = generator(1, f"test/{stream}", 0)
    return draw.uniform(size=(count, len(COLUMNS))), draw.normal(size=(count, flights, len(RESULTS)))


def stored(folder, batch, gains, results, first=0, key="key"):
    store = FlightStore(Folder.open_or_create(folder), COLUMNS)
    store.keep(key, batch, gains, first, results)
    store.commit("search-0000")
    return FlightStore(None, COLUMNS, (folder,))


def test_what_was_kept_is_recalled_to_the_bit(tmp_path, batch):
    gains, results = made(5)
    store = stored(tmp_path / "r", batch, gains, results)
    for row, expected in zip(gains, results, strict=True):
        np.testing.assert_array_equal(store.recall("key", row, 0, 8), expected)
        np.testing.assert_array_equal(store.recall("key", row, 2, 5), expected[2:5])


def test_nothing_is_recalled_for_other_gains_scenarios_or_flights(tmp_path, batch):
    gains, results = made(2)
    store = stored(tmp_path / "r", batch, gains, results)
    assert store.recall("key", np.nextafter(gains[0], 1.0), 0, 8) is None
    assert store.recall("other", gains[0], 0, 8) is None
    assert store.recall("key", gains[0], 4, 9) is None
    assert FlightStore(None, (*COLUMNS, "roll.k2"), (tmp_path / "r",)).recall("key", gains[0], 0, 8) is None


def test_blocks_that_follow_one_another_are_recalled_together(tmp_path, batch):
    gains, results = made(1, 8)
    store = FlightStore(Folder.create(tmp_path / "r"), COLUMNS)
    store.keep("key", batch, gains, 4, results[:, 4:])
    store.commit("search-0000")
    store.keep("key", batch, gains, 0, results[:, :4])
    store.commit("search-0001")
    again = FlightStore(None, COLUMNS, (tmp_path / "r",))
    np.testing.assert_array_equal(again.recall("key", gains[0], 0, 8), results[0])
    np.testing.assert_array_equal(again.recall("key", gains[0], 3, 6), results[0, 3:6])


def test_more_flights_than_are_gathered_are_written_in_parts(tmp_path, batch, monkeypatch):
    monkeypatch.setattr("tuner.store.flights.GATHERED", 1000)
    gains, results = made(4)
    store = FlightStore(Folder.create(tmp_path / "r"), COLUMNS)
    for i in range(4):
        store.keep("key", batch, gains[i : i + 1], 0, results[i : i + 1])
    store.commit("held-out")
    assert len(list((tmp_path / "r" / "flights").glob("part-search-*.npz"))) == 4
    again = FlightStore(None, COLUMNS, (tmp_path / "r",))
    for row, expected in zip(gains, results, strict=True):
        np.testing.assert_array_equal(again.recall("key", row, 0, 8), expected)


def test_equal_flights_give_equal_files(tmp_path, batch):
    gains, results = made(3)
    stored(tmp_path / "a", batch, gains, results)
    stored(tmp_path / "b", batch, gains, results)
    one, other = (next((tmp_path / name / "flights").iterdir()) for name in "ab")
    assert one.name == other.name and one.read_bytes() == other.read_bytes()


def test_a_person_can_read_the_file(tmp_path, batch):
    gains, results = made(2)
    stored(tmp_path / "r", batch, gains, results, first=16)
    table = read_frame(next((tmp_path / "r" / "flights").iterdir()))
    assert list(table.flight) == [*range(16, 24)] * 2
    assert set(table.scenario) == {batch.spec.name} and set(table.stream) == {SEARCH}
    np.testing.assert_array_equal(table["gain:roll.k1"].to_numpy()[[0, 8]], gains[:, 2])
    np.testing.assert_array_equal(table["end_time"].to_numpy(), results[:, :, -1].ravel())


@pytest.mark.parametrize("place", [0, 60, 0.5, 0.9, -1])
def test_one_damaged_byte_anywhere_sets_the_file_aside(tmp_path, batch, place):
    gains, results = made(2)
    stored(tmp_path / "r", batch, gains, results)
    file = next((tmp_path / "r" / "flights").iterdir())
    content = bytearray(file.read_bytes())
    content[int(place * len(content)) if isinstance(place, float) else place] ^= 0x10
    file.write_bytes(content)
    passed_over = FlightStore(None, COLUMNS, (tmp_path / "r",))
    assert passed_over.damaged == [str(file)] and file.exists()
    own = FlightStore(Folder.open(tmp_path / "r"), COLUMNS)
    assert own.damaged == [str(file)] and not file.exists()
    assert file.with_suffix(".damaged").read_bytes() == content
    assert own.recall("key", gains[0], 0, 8) is None


def test_a_file_that_is_cut_off_is_set_aside(tmp_path, batch):
    stored(tmp_path / "r", batch, *made(2))
    file = next((tmp_path / "r" / "flights").iterdir())
    file.write_bytes(file.read_bytes()[:100])
    assert FlightStore(Folder.open(tmp_path / "r"), COLUMNS).damaged == [str(file)]


BASE = {"margin": []}
CHANGES = {
    "wind": {"scenario.0.air.altitude": 12.0},
    "target": {"scenario.0.reference.x": 1.5},
    "band": {"scenario.0.bands.settling": 0.02},
    "spread": {"scenario.0.spread.mass": 0.06},
    "noise": {"scenario.0.sensors.attitude": 0.001},
    "seed": {"seed": 2026},
    "period": {"controller.control_period": 0.002},
    "plant step": {"controller.plant_step": 0.0005},
    "delay": {"controller.delay": False},
    "vehicle": {"airframe.name": "iris"},
    "limits": {"limits.position": 4.0},
    "law": {"controller.attitude": "ladrc", "gains": {}},
    "name": {"scenario.0.name": "other"},
}


def keys(changes, stream=SEARCH):
    study = load_study(QUICKSTART, {**BASE, **changes})
    return [scenario_key(study.system, study.seed, FlightBatch(entry.spec, stream, 4)) for entry in study.scenarios]


@pytest.mark.parametrize("change", CHANGES)
def test_whatever_decides_a_flight_changes_its_key(change):
    assert keys({}) != keys(CHANGES[change])


def test_what_decides_no_flight_leaves_its_key():
    free = {"objective.0.level": 0.9, "search.population": 8, "scenario.0.search": 5, "title": "x", "constraint": []}
    assert keys({}) == keys(free)
    assert keys({}) != keys({}, HELD_OUT)
