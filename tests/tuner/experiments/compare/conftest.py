"""One comparison of the small run with two gains files, one of them for another airframe, written to a folder."""

import json

import pytest

from plant.quadrotor.airframes import load
from tuner.experiments.compare.entrants import read_entrants
from tuner.experiments.compare.plan import base_study, plan_comparison
from tuner.experiments.compare.run import ComparisonRun, comparison_document
from tuner.gains import content_hash
from tuner.gains.airframe_block import airframe_block
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder

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


class Counter(Watcher):
    def __init__(self):
        self.flights = 0

    def on_flights_done(self, flights):
        self.flights += flights


def compared(paths, seeds=SEEDS, threads=2, out=None):
    entrants = read_entrants(paths)
    plan = plan_comparison(entrants, base_study(entrants, None, seeds))
    watcher = Counter()
    folder = None if out is None else Folder.create(out, inside="figures")
    result = ComparisonRun(plan, folder, watcher, threads).carry_out()
    assert watcher.flights == plan.flights == result.flights
    return plan, result, comparison_document(plan, result)


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
def compared_into(paths, tmp_path_factory):
    """A folder, and what was found there."""
    out = tmp_path_factory.mktemp("compared") / "out"
    return out, compared(paths, out=out)


@pytest.fixture(scope="session")
def written(compared_into):
    return compared_into[0]


@pytest.fixture(scope="session")
def comparison(compared_into):
    return compared_into[1]
