"""One studio of the motor for all tests."""

from pathlib import Path

import pytest

from tests.tuner.extensions.studio.served import served

STUDIES = Path(__file__).parents[4] / "studies"


@pytest.fixture(scope="session")
def out(tmp_path_factory):
    return tmp_path_factory.mktemp("studio")


@pytest.fixture(scope="session")
def motor(out):
    """Bench and client of the motor's study."""
    with served(STUDIES / "dc_motor.toml", out) as both:
        yield both


@pytest.fixture
def bench(motor):
    return motor[0]


@pytest.fixture
def client(motor):
    return motor[1]
