"""A good study: what it becomes, overrides, files beside it, the template, and all that stands in studies/."""

import re
import subprocess
import sys
import tomllib
from math import cos, pi, radians
from pathlib import Path
from typing import Any

import pytest

from objectives.problem import Constraint, Objective
from objectives.risk import Risk
from plant.air.gust import Gust
from plant.air.injection import Injection
from plant.air.spec import AirSpec
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.closed_loop import Limits
from plant.quadrotor.nominal import ControlOptions
from plant.quadrotor.scenarios import Bands, ScenarioSpec, Spread
from plant.quadrotor.sensors import SensorSpec
from plant.references.steps import Steps
from tests.tuner.study.study_text import STUDY, changed, write
from tuner.study.build import load_study
from tuner.study.comparison import ComparisonStudy
from tuner.study.kinds import load_any
from tuner.study.study import SearchSpec
from tuner.study.template import TEMPLATE

ROOT = Path(__file__).resolve().parents[3]
STUDIES = sorted((ROOT / "studies").glob("*.toml"))


def test_a_small_study_becomes_the_domain_with_its_defaults(tmp_path: Path):
    study = load_study(write(tmp_path, STUDY))
    assert (study.title, study.description, study.seed) == ("Test", "", 1)
    assert study.airframe == load("hummingbird")
    assert study.system.vehicle == study.airframe.vehicle
    assert (study.system.cascade.position.name, study.system.cascade.attitude.name) == ("ladrc", "hybrid")
    assert study.system.timing == Timing(0.004, 0.004)
    assert study.system.limits == Limits(5.0, cos(80.0 * pi / 180.0))
    assert study.options == ControlOptions(tilt_limit=pi / 6.0)
    (entry,) = study.scenarios
    assert (entry.search, entry.held_out) == (4, 8)
    assert entry.spec == ScenarioSpec(
        "gusts",
        2.0,
        Steps(x=1.0, time=0.5),
        AirSpec(intensity="light"),
        SensorSpec(),
        Spread(mass=0.1, lag=0.2),
        Bands(),
    )
    assert [objective.label for objective in study.objectives] == ["cvar90(itae.position)", "mean(travel)"]
    assert study.objectives[0].risk == Risk("cvar", 0.9)
    failure = study.constraints[0].objective.metric
    assert failure.text == "failure"
    assert study.constraints[0] == Constraint(Objective(failure, Risk("mean")), 0.0, confidence=0.95)
    # What a study of a moving vehicle asks at least: that it moves.
    (floor,) = study.constraints[1:]
    assert floor.objective.label == "quantile50(rms.position)@gusts" and 0.0 < floor.most < 1.0
    assert study.search == SearchSpec("gaussian_process", 8, 2, ("default",), why=study.search.why)
    assert study.pick == "knee"


def test_every_setting_arrives(tmp_path: Path):
    study = load_study(write(tmp_path, FULL))
    assert study.description == "all of it"
    assert study.options == ControlOptions("observer", "observer", False, True, radians(25.0))
    assert study.system.timing == Timing(0.005, 0.0005)
    assert study.system.limits == Limits(3.0, cos(radians(60.0)))
    first, second = study.scenarios
    injection = Injection(
        (1.0, 2.0, 3.0), (0.5, 0.5, 0.5), (0.1, 0.2, 0.3), (4.0, 5.0, 6.0), (2.0, 2.0, 2.0), (7.0, 8.0, 9.0)
    )
    air = AirSpec(
        "1797",
        7.5,
        20.0,
        1.0,
        2.0,
        45.0,
        False,
        True,
        0.4,
        "A",
        (1.0, 3.0),
        Gust(2.0, 1.0, 0.5, (0.0, 1.0, 0.0)),
        injection,
    )
    assert first.spec == ScenarioSpec(
        "a",
        5.0,
        Steps(x=1.0, y=2.0, z=0.5, yaw_deg=20.0, time=2.0),
        air,
        SensorSpec(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8),
        Spread(0.1, 0.2, 0.3, 0.4),
        Bands(0.02, 0.2, 0.3),
        3.5,
        0.25,
    )
    assert second.spec.recovery_from is None
    assert study.objectives[0].scenario == "b"
    assert study.objectives[0].label == "quantile95(rms.z)@b"
    assert study.pick == "min:quantile95(rms.z)@b"


FULL = """\
title = "Full"
description = "all of it"
seed = 7
[airframe]
name = "iris"
[controller]
attitude = "pid"
position = "pid"
control_period = 0.005
plant_step = 0.0005
attitude_rate = "observer"
position_rate = "observer"
lag_aware = false
delay = true
tilt_limit_deg = 25
[limits]
position = 3
tilt_deg = 60
[gains]
"roll.kp" = {}
[[scenario]]
name = "a"
duration = 5
search = 2
held_out = 3
steady_share = 0.25
recovery_from = 3.5
reference = { kind = "steps", x = 1, y = 2, z = 0.5, yaw_deg = 20, time = 2 }
spread = { mass = 0.1, inertia = 0.2, thrust = 0.3, lag = 0.4 }
bands = { settling = 0.02, position = 0.2, attitude = 0.3 }
[scenario.sensors]
position = 0.1
velocity = 0.2
attitude = 0.3
rate = 0.4
position_bias = 0.5
velocity_bias = 0.6
attitude_bias = 0.7
rate_bias = 0.8
[scenario.air]
spec = "1797"
intensity = 7.5
altitude = 20
vehicle_speed = 1
minimum_airspeed = 2
wind_direction_deg = 45
mean_wind = false
angular_rates = true
span = 0.4
roughness = "A"
window = [1, 3]
gust = { amplitude = 2, start = 1, length = 0.5, direction = [0, 1, 0] }
[scenario.air.injection]
acceleration_sigma = [1, 2, 3]
acceleration_time = [0.5, 0.5, 0.5]
acceleration_bias = [0.1, 0.2, 0.3]
angular_sigma = [4, 5, 6]
angular_time = [2, 2, 2]
angular_bias = [7, 8, 9]
[[scenario]]
name = "b"
duration = 1
[[objective]]
metric = "rms.z"
risk = "quantile"
level = 0.95
scenario = "b"
[pick]
rule = "min:rms.z"
"""


@pytest.mark.parametrize(
    ("key", "value", "read"),
    [
        ("search.generations", 3, lambda study: study.search.generations),
        ("scenario.0.search", 9, lambda study: study.scenarios[0].search),
        ("scenario[0].search", 9, lambda study: study.scenarios[0].search),
        ("scenario.0.air.altitude", 20.0, lambda study: study.scenarios[0].spec.air.altitude),
        ("scenario.0.sensors.rate", 0.5, lambda study: study.scenarios[0].spec.sensors.rate),
        ("constraint.0.max", 0.25, lambda study: study.constraints[0].most),
        ("seed", 99, lambda study: study.seed),
        ("limits.position", 2.5, lambda study: study.system.limits.position),
        ("gains.tilt.lambda.low", 2.0, lambda study: study.space.variables[0].low),
        ("gains.roll.k1", 7.0, lambda study: study.resolved()["gains"]["roll.k1"]),
    ],
)
def test_an_override_replaces_or_adds_one_value(key: str, value: float, read: Any, tmp_path: Path):
    path = write(tmp_path, STUDY)
    before, after = load_study(path), load_study(path, {key: value})
    assert read(before) != value
    assert read(after) == value
    assert before.digest() != after.digest()
    assert path.read_text(encoding="utf-8") == STUDY


def test_overrides_leave_the_callers_values_alone(tmp_path: Path):
    table = {"population": 8, "generations": 2}
    study = load_study(write(tmp_path, STUDY), {"search": table, "search.generations": 5})
    assert study.search.generations == 5
    assert table == {"population": 8, "generations": 2}


def test_files_beside_a_study_are_found_from_any_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    home, elsewhere = tmp_path / "home", tmp_path / "elsewhere"
    home.mkdir()
    elsewhere.mkdir()
    path = write(home, BESIDE)
    (home / "mine.toml").write_text(load("hummingbird").path.read_text(encoding="utf-8"), encoding="utf-8")
    (home / "points.csv").write_text("t,x,y,z\n0,0,0,0\n1,1,0,0\n", encoding="utf-8")
    digests = []
    for folder, name in ((elsewhere, path), (home, Path(path.name)), (tmp_path, Path("home") / path.name)):
        monkeypatch.chdir(folder)
        study = load_study(name)
        assert study.system.vehicle == load("hummingbird").vehicle
        assert study.airframe.name == "mine"
        digests.append(study.digest())
    assert len(set(digests)) == 1


BESIDE = changed('name = "hummingbird"', 'file = "mine.toml"').replace(
    'kind = "steps"\nx = 1.0\ntime = 0.5', 'kind = "waypoints"\npath = "points.csv"'
)


def test_a_byte_order_mark_is_no_error(tmp_path: Path):
    path = tmp_path / "marked.toml"
    path.write_text(STUDY, encoding="utf-8-sig")
    assert load_study(path).digest() == load_study(write(tmp_path, STUDY)).digest()


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_every_study_of_the_project_loads(path: Path):
    study = load_any(path)
    if isinstance(study, ComparisonStudy):
        assert len(study.contenders) > 1
    else:
        assert study.space.variables
        assert {objective.metric.text for objective in study.objectives}


def test_there_are_studies():
    assert "quickstart" in {path.stem for path in STUDIES}


def template(title: str = "mine") -> str:
    return TEMPLATE.replace("@TITLE@", title)


def test_the_template_loads_and_says_what_each_line_is_for(tmp_path: Path):
    study = load_study(write(tmp_path, template()))
    assert study.title == "mine"
    assert study.space.variables
    assert study.objectives and study.constraints
    assert template().count("#") >= 30


def commented_keys() -> list[str]:
    """Return the lines of the template that are commented out and hold a key."""
    return [line for line in TEMPLATE.splitlines() if re.match(r"# \w+ = ", line)]


def uncommented(line: str) -> str:
    """Return the template with a commented line and its table switched on."""
    lines = template().splitlines()
    at = lines.index(line)
    lines[at] = line.removeprefix("# ")
    while not lines[at].lstrip("# ").startswith("["):
        at -= 1
    # A gust has three required keys, a guarantee too: they come together.
    if "gust" in lines[at] or "guarantee" in lines[at]:
        lines[at + 1 : at + 4] = [entry.removeprefix("# ") for entry in lines[at + 1 : at + 4]]
    lines[at] = lines[at].removeprefix("# ")
    if line.startswith("# file"):
        lines.remove('name = "hummingbird"            # bundled: `tuner list airframes`')
    return "\n".join(lines)


@pytest.mark.parametrize("line", commented_keys())
def test_every_line_that_the_template_offers_works(line: str, tmp_path: Path):
    (tmp_path / "my_quad.toml").write_text(load("iris").path.read_text(encoding="utf-8"), encoding="utf-8")
    text = uncommented(line)
    assert tomllib.loads(text) != tomllib.loads(template())
    load_study(write(tmp_path, text))


def test_the_template_offers_lines():
    assert len(commented_keys()) >= 10


@pytest.mark.slow
def test_reading_studies_needs_no_plotting_or_search_library_and_running_them_only_what_they_ask_for():
    heavy = ("casadi", "pandas", "plotly", "pymoo", "matplotlib", "cvxpy")
    seldom = ("plotly", "pymoo", "cmaes", "matplotlib", "cvxpy", "scipy.stats")
    code = "import sys, tuner.study.build\nprint([name for name in {} if name in sys.modules])\n".format
    assert run(code(heavy) + code(seldom).replace("tuner.study.build", "tuner.api.runs"), ROOT) == "[]\n[]"


def test_the_package_itself_imports_nothing():
    code = "import sys, tuner; print([name for name in ('numpy', 'pydantic', 'numba') if name in sys.modules])"
    assert run(code, ROOT) == "[]"


def run(code: str, folder: Path) -> str:
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout.strip()
