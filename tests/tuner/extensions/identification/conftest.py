"""Fits at which several files of this folder look, each made once: a fit takes seconds."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from plant.quadrotor.airframes import Airframe, load
from tests.tuner.extensions.identification.known_flights import AIRFRAME, AXES, KnownFlight, known_flights
from tuner.extensions.identification.building import earlier_posterior, identification_document
from tuner.extensions.identification.document import IdentificationDocument
from tuner.extensions.identification.identify import Identified, identify_vehicle
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.logs.reading import read_log
from tuner.extensions.vehicle_fit import fit
from tuner.extensions.vehicle_fit.parameters import EarlierPosterior

CRAZYFLIE = Path(__file__).parents[1] / "logs" / "crazyflie" / "log15_70_to_85"


@pytest.fixture(scope="session")
def crazyflie() -> Identified:
    """The fit of a real flight."""
    return identify_roughly([read_log(CRAZYFLIE)], airframe=load("crazyflie-pybullet"))


@pytest.fixture(scope="session")
def side_by_side() -> list[KnownFlight]:
    """Two flights with all axes shaken, one with roll and lift only, and a calm one; the first of 18 s, the others of 9 s."""
    return known_flights(
        4,
        duration=[18.0, 9.0, 9.0, 9.0],
        excited=[AXES, AXES, ("roll", "lift"), ()],
        turbulence=np.array([1.0, 1.0, 1.0, 0.2]),
    )


@pytest.fixture(scope="session")
def long_flight(side_by_side: list[KnownFlight]) -> KnownFlight:
    return side_by_side[0]


@pytest.fixture(scope="session")
def flown(side_by_side: list[KnownFlight]) -> list[KnownFlight]:
    """As long each: the first half of the long flight, and the others."""
    long_flight, *others = side_by_side
    return [long_flight._replace(log=long_flight.log.between(0.0, 9.0)), *others]


@pytest.fixture(scope="session")
def flights(flown: list[KnownFlight]) -> list[KnownFlight]:
    return flown[:2]


def identify_roughly(
    logs: list[FlightLog],
    earlier: EarlierPosterior | None = None,
    airframe: Airframe = AIRFRAME,
    noise_fits: int = 2,
) -> Identified:
    """Identify with two fits of the noise at most, not five: no property that is tested here needs more.

    With one, no other dead time is tried, which takes most of the time.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fit, "MAX_NOISE_FITS", noise_fits)
        return identify_vehicle(logs, airframe, earlier=earlier)


@pytest.fixture(scope="session")
def identified(flights: list[KnownFlight]) -> list[Identified]:
    return [identify_roughly([flight.log]) for flight in flights]


class Halves(NamedTuple):
    """A flight of 18 s in two logs: the fits of the first, of both, and of the second on top of the first's document."""

    flight: KnownFlight
    logs: list[FlightLog]
    first: Identified
    earlier: EarlierPosterior
    both: Identified
    second: Identified


@pytest.fixture(scope="session")
def halves(long_flight: KnownFlight, flights: list[KnownFlight], identified: list[Identified]) -> Halves:
    return halves_of(long_flight, flights[0], identified[0], 2)


@pytest.fixture(scope="session")
def rough_halves(long_flight: KnownFlight, flights: list[KnownFlight], identified: list[Identified]) -> Halves:
    """The same by quick fits, where numbers are moved or left out and not tested."""
    return halves_of(long_flight, flights[0], identified[0], 1)


def halves_of(flight: KnownFlight, begin: KnownFlight, first: Identified, noise_fits: int) -> Halves:
    logs = [begin.log, flight.log.between(9.0, 18.0)]
    both = identify_roughly(logs, noise_fits=noise_fits)
    document = IdentificationDocument.parse(identification_document(first, [], None).text())
    earlier = earlier_posterior(document, AIRFRAME, Path("first.json"))
    return Halves(flight, logs, first, earlier, both, identify_roughly(logs[1:], earlier, noise_fits=noise_fits))
