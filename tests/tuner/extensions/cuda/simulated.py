"""Fly the tests' flights in Numba's CUDA simulator and write the results to the file that is given; NUMBA_ENABLE_CUDASIM=1."""

import sys
from dataclasses import replace
from unittest.mock import patch

import numpy as np

from objectives.flown_system import FlightBatch
from objectives.metrics.columns import COLUMNS
from objectives.system import System
from tests.plant.loops import LIMITS, NOMINAL, TIMING, VEHICLE, loop, spec
from tests.tuner.extensions.cuda.flights import CASES, batch, rows
from tuner.extensions.cuda import flights as cuda_flights
from tuner.extensions.cuda.engine import CudaEngine
from tuner.extensions.cuda.flights import CudaFlyer


def main():
    found = {}
    for precision, pair in CASES:
        flyer = CudaFlyer(loop(*pair), LIMITS, TIMING, precision)
        found["/".join((precision, *pair))] = flyer.fly(rows(*pair), NOMINAL, batch())
    double = CudaFlyer(loop(), LIMITS, TIMING, "float64")
    on_flights_done = []
    cuda_flights.LARGEST_LAUNCH = 4
    found["launches"] = double.fly(rows(count=3), NOMINAL, batch(0.2), on_flights_done.append)
    found["on_flights_done"] = np.array(on_flights_done)
    found["one"] = double.fly(rows(count=3)[1:2], NOMINAL, batch(0.2, 2))
    found.update(disturbed(double))
    scenarios_make_room(double)
    found.update(streamed())
    np.savez(sys.argv[1], **found)


def disturbed(flyer):
    """Flights with gusts of rotation and injections, without noise, and with air that is not a number from 0.2 s on."""
    calm = batch()
    air = np.pad(calm.disturbances, [(0, 0), (0, 0), (0, 9), (0, 0)])
    air[:, :, 3:] = 0.1 * np.random.default_rng(1).standard_normal(air[:, :, 3:].shape)
    full = replace(calm, disturbances=air, noises=calm.noises[:, :, :0])
    broken = calm.disturbances.copy()
    broken[0, 50:, :, 1] = np.nan
    return {
        "full": flyer.fly(rows(count=1), NOMINAL, full),
        "broken": flyer.fly(rows(count=1), NOMINAL, replace(calm, disturbances=broken)),
        "air": air,
    }


def scenarios_make_room(flyer):
    """What is on the card is not copied again, and goes when there is no room: the oldest first, never the one in use."""
    first, second = batch(0.2, 1), batch(0.2, 2)
    kept = flyer._inputs(first)
    flyer._inputs(second)
    assert flyer._inputs(first) is kept
    # 50 instants of 3 rows of air, 12 of noise and 14 of reference, 38 numbers of the vehicle and 17 of its start, 8 bytes each.
    assert kept.bytes == 8 * (50 * (3 + 12 + 14) + 38 + 17)
    with patch.object(cuda_flights, "SCENARIOS_BYTES", 2.5 * kept.bytes):
        third = flyer._inputs(batch(0.2, 1))
    assert [id(entry) for entry in flyer._on_card.values()] == [id(kept), id(third)]
    with patch.object(cuda_flights, "free_memory", float):
        alone = flyer._inputs(second)
        assert list(flyer._on_card.values()) == [alone] and flyer._candidates(3) == 1


def streamed():
    """Parts of many gains rows, one of them empty, through the engine; flights of each launch are as many as fill the card."""
    engine = CudaEngine(System(VEHICLE, loop().cascade, NOMINAL, LIMITS, TIMING), 7)
    flights, launches = FlightBatch(spec(0.2), "search", 4), []
    assert engine.arithmetic.startswith("cuda-float64, ") and not engine.ready(flights)
    engine._flyer.resident = 5
    given = [rows(count=5)[:2], rows()[:0], rows(count=5)[2:3], rows(count=5)[3:]]
    parts = list(engine.stream(given, flights, 1, 4, launches.append))
    results = len(COLUMNS) + 2
    assert [part.shape for part in parts] == [(candidates, 3, results) for candidates in (2, 0, 1, 2)]
    return {"stream": np.concatenate(parts, axis=0), "stream_launches": np.array(launches)}


if __name__ == "__main__":
    main()
