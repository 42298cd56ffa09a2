"""One comparison of the small run with two gains files, one of them for another airframe, written to a folder."""

import json

import pytest

from plant.airframes import load
from tuner.experiments.compare.compare import comparison_document, fly_comparison, prospect
from tuner.experiments.compare.entrants import read_entrants
from tuner.experiments.compare.shared import base_study
from tuner.experiments.compare.writing import write_comparison
from tuner.gains import content_hash
from tuner.gains.airframe_block import airframe_block
from tuner.search.watcher import Watcher

SEEDS = 16


def changed_gains(source, target, factor=1.0, airframe=None, **controller):
    """Write the gains of a file with the omega_c of all position loops times a factor."""
    document = json.loads(source.read_text())
    for address, entry in document["gains"].items():
        if address.endswith("omega_c"):
            entry["value"] *= factor
    if airframe is not None:
        document["airframe"] = airframe_block(load(airframe))
    document["controller"] |= controller
    target.write_text(json.dumps(document | {"sha256": content_hash(document)}))
    return target


def compared(paths, seeds=SEEDS, threads=2):
    entrants = read_entrants(paths)
    asked = prospect(entrants, base_study(entrants, None, seeds))
    on_flights_done = []
    result = fly_comparison(asked, threads, on_flights_done.append)
    assert sum(on_flights_done) == asked.flights == result.flights
    return asked, result, comparison_document(asked, result)


@pytest.fixture(scope="session")
def paths(small_run, tmp_path_factory):
    """The small run, the same gains as a file, softer ones, and softer ones on another airframe."""
    folder, home = small_run[1], tmp_path_factory.mktemp("gains")
    gains = folder / "gains.json"
    return [
        folder,
        changed_gains(gains, home / "same.json"),
        changed_gains(gains, home / "softer.json", 0.5),
        changed_gains(gains, home / "larger.json", 0.5, airframe="f450"),
    ]


@pytest.fixture(scope="session")
def comparison(paths):
    return compared(paths)


@pytest.fixture(scope="session")
def written(comparison, tmp_path_factory):
    _, result, document = comparison
    out = tmp_path_factory.mktemp("compared") / "out"
    write_comparison(out, result, document, 2, Watcher())
    return out
