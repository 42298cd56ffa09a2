"""`[scenario.spread] from = "airframe"`: the vehicles of a study are those that its airframe's file leaves open."""

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load
from plant.quadrotor.rigid_body import Dynamics
from plant.quadrotor.scenarios import SEARCH, drawn_numbers, sample_scenarios
from plant.records import paths
from tests.tuner.study.study_text import changed
from tuner.study.build import load_study

UNCERTAINTY = """
[uncertainty]
source = "identified from a log"
names = ["mass", "inertia.x", "inertia.y"]
deviations = [0.02, 0.1, 0.1]
correlation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.99], [0.0, 0.99, 1.0]]
"""
CURVED = """
[uncertainty]
source = "identified from a log"
names = ["thrust_linear", "dead_time"]
deviations = [0.05, 0.003]
correlation = [[1.0, 0.2], [0.2, 1.0]]
"""
MARGIN = """
[[margin]]
quantity = "phase_margin"
axis = "attitude"
min = 30.0
spread = true
"""


@pytest.fixture
def study(tmp_path):
    def write(uncertainty=UNCERTAINTY, spread='from = "airframe"', more="", numbers=""):
        text = load("hummingbird").path.read_text().replace("[inertia]", f"{numbers}\n[inertia]", 1)
        (tmp_path / "mine.toml").write_text(text + uncertainty)
        text = changed('name = "hummingbird"', 'file = "mine.toml"', changed("mass = 0.1", spread))
        (tmp_path / "study.toml").write_text(text + more)
        return load_study(tmp_path / "study.toml")

    return write


def test_the_vehicles_that_fly_are_drawn_from_the_airframe(study):
    found = study()
    spec, system = found.scenarios[0].spec, found.system
    rows = sample_scenarios(spec, system.vehicle, system.timing, found.seed, SEARCH, range(64)).dynamics
    x, y = (rows[:, paths(Dynamics).index(f"inverse_inertia.{axis}")].ravel()[:64] for axis in "xy")
    assert np.std(np.log(x)) == pytest.approx(0.1, rel=0.3)
    assert np.corrcoef(np.log(x), np.log(y))[0, 1] > 0.95
    # Nothing else is spread: not the lag, which a study spreads by itself.
    assert len(set(rows[:, paths(Dynamics).index("rise")].ravel().tolist())) == 1


def test_curve_and_dead_time_of_the_vehicles_that_fly_are_drawn(study):
    """The loop has both, and a line as long as the longest dead time that is drawn."""
    given = 'thrust_linear = { value = 0.4, unit = "1", source = "a test" }\n'
    given += 'dead_time = { value = 0.01, unit = "s", source = "a test" }\n'
    found = study(CURVED, numbers=given)
    spec, system = found.scenarios[0].spec, found.system
    assert system.fitted.name == f"_upto{round(0.019 / system.timing.control_period)}late_curved"
    rows = sample_scenarios(spec, system.vehicle, system.timing, found.seed, SEARCH, range(64)).dynamics
    square, late = (rows[:, paths(Dynamics).index(name)].ravel()[:64] for name in ("curve.square", "dead_time"))
    assert [np.mean(1.0 - square), np.std(square)] == pytest.approx([0.4, 0.05], rel=0.3)
    assert [np.mean(late), np.std(late)] == pytest.approx([0.01, 0.003], rel=0.3)


def test_the_numbers_that_were_drawn_are_those_of_the_vehicles_that_fly(study):
    found = study()
    spec, system = found.scenarios[0].spec, found.system
    drawn = drawn_numbers(spec, system.vehicle, found.seed, SEARCH, range(16))
    flown = sample_scenarios(spec, system.vehicle, system.timing, found.seed, SEARCH, range(16)).dynamics
    at = paths(Dynamics).index("inverse_inertia.x")
    moved = np.log(1.0 / flown[:, at].ravel()[:16] / system.vehicle.inertia.x)
    assert 0.1 * drawn[:, 1] == pytest.approx(moved, abs=1e-12) and np.ptp(moved) > 0.1


def test_the_uncertainty_is_part_of_what_a_study_is(study):
    assert study().digest() != study(UNCERTAINTY.replace("0.02", "0.03")).digest()
    assert study().resolved()["scenario"][0]["spread"]["from"] == "airframe"


def test_margins_are_those_of_the_extremes_too(study):
    found = study(more=MARGIN)
    asked = found.screens[0].analyse(found.default_row[None])
    plain = study(more=MARGIN.replace("spread = true", "spread = false"))
    assert asked[0, 0] < plain.screens[0].analyse(plain.default_row[None])[0, 0]


@pytest.mark.parametrize(
    ("uncertainty", "spread", "message"),
    [
        ("", 'from = "airframe"', "has no \\[uncertainty\\]; write one with `tuner identify"),
        (UNCERTAINTY, 'from = "airframes"', "did you mean 'airframe'"),
        (UNCERTAINTY, 'from = "airframe"\nmass = 0.1', "takes the place of mass; leave either out"),
    ],
)
def test_what_cannot_be_drawn_from_is_told(study, uncertainty, spread, message):
    with pytest.raises(InputError, match=rf"scenario\[0\]\.spread\.from: .*{message}"):
        study(uncertainty, spread)
