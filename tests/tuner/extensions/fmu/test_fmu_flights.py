"""Flights of an FMU are those of the same plant in Python, on any number of workers; one that it breaks is lost and no other."""

import re
from functools import cache, partial
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, cast

import numpy as np
import pytest

from objectives.margins.plant_margins import PlantMargins
from objectives.margins.quantities import QUANTITIES
from objectives.metrics.address import parse
from objectives.problem import score_flights
from plant.backends.flyer import result_parts
from plant.errors import InputError, MissingPackageError
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.plan import Actuator, Channel, LoopPlan, plan_loop
from plant.model.scenario import PlantScenario, SensorNoise
from plant.model.signals import Coloured, Step
from plant.records import flatten, paths, rows
from plant.status import Status
from tests.plant.model.plants import pid, stepped, system_of
from tests.tuner.extensions.fmu.fmus import write_motor
from tuner.extensions.fmu.flyer import FmuFlyer
from tuner.extensions.fmu.fmu_model import read_fmu
from tuner.extensions.fmu.messages import Refused
from tuner.extensions.fmu.process import WorkerLostError
from tuner.extensions.fmu.system import FmuSystem
from tuner.study.plant_study import with_timing

SPEC = PlantScenario(
    "turn",
    0.2,
    {"angle": Step(1.0, 0.01)},
    {"torque": Coloured(0.001, 0.05)},
    {"angle": SensorNoise(2e-4)},
    {"inertia": 0.2, "friction": 0.3},
)
CHANNELS = [pid("angle", "angle", "voltage", limit=10.0)]
ACTUATORS = [Actuator("voltage", -12.0, 12.0, delay=0.001)]
TIMING = Timing(0.001, 0.0005)
GAINS = np.array([[3.0, 2.0, 0.06, 0.001], [8.0, 5.0, 0.1, 0.001]])
FLIGHTS = 6
FAULTS = ("CRASH", "HANG", "NOT_A_NUMBER", "AN_ERROR")
each_version = pytest.mark.parametrize("version", [2, 3])


@cache
def folder() -> Path:
    return Path(mkdtemp(prefix="fmu-tests-"))


@cache
def fmu(version, *options, actuators=(), timing=TIMING, patience=60.0, fault=0.0, name=None, states=(), **changes):
    """Return the motor's FMU under the same loop as `native`."""
    name = name or f"motor{version}{''.join(options).replace('=', '')}{''.join(changes)}"
    plant = read_fmu(write_motor(folder(), version, *options, name=name, **changes), ["torque"], states)
    parameters = plant.parameters._replace(fault=fault)
    return FmuSystem(plant, plan_loop(plant, CHANNELS, actuators or ACTUATORS), parameters, timing, patience=patience)


@cache
def native(actuators=(), timing=TIMING):
    return system_of("dc_motor", CHANNELS, list(actuators) or ACTUATORS, timing)


def flown(system, count=FLIGHTS, threads=1, gains=GAINS, say=None):
    inputs = system.sample(SPEC, 7, "search", range(count))
    flyer = system.flyer(threads)
    if say is not None:
        flyer.say = say
    return flyer.fly(gains, system.nominal, inputs)


@cache
def wanted():
    return flown(native())


@pytest.mark.parametrize("version", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_outcomes_are_those_of_the_plant_in_python(version):
    """Every meter, and so every metric, to 1e-6 of its size; steps of the FMU are those of Runge and Kutta too."""
    found = flown(fmu(version))
    sizes = np.abs(wanted()).max(axis=(0, 1))
    assert (result_parts(found)[1] == 0).all()
    assert (np.abs(found - wanted()) <= 1e-6 * sizes).all()


def test_a_law_is_given_the_difference_of_what_it_sees_as_in_python():
    """The law of PX4's multicopter position takes the rate as it is given it."""
    channels = [Channel("angle", LAWS["px4_position"], "angle", "voltage", b0=2100.0, limit=10.0)]
    gains = np.array([[0.95, damping, 0.4, 0.0, 9.8, 5.0, 1.0] for damping in (1.8, 18.0)])
    plant = fmu(2).plant
    mine = FmuSystem(plant, plan_loop(plant, channels, ACTUATORS), fmu(2).parameters, TIMING)
    found = flown(mine, 3, gains=gains)
    system = system_of("dc_motor", channels, ACTUATORS, TIMING)
    drawn = system.sample(SPEC, 7, "search", range(3))
    # Step by step: these lanes would be compiled for this test alone.
    theirs = np.array([[flatten(stepped(system, row, drawn, lane)[1].meters) for lane in range(3)] for row in gains])
    assert theirs.any(axis=(0, 1)).sum() > 5
    assert (np.abs(found[..., : theirs.shape[-1]] - theirs) <= 1e-6 * np.abs(theirs).max(axis=(0, 1))).all()


def test_a_trace_is_that_of_the_plant_in_python():
    system, other = fmu(2), native()
    kind = system.loop.Flight
    traced = [*range(*rows(kind, "body.shown").indices(999)), *range(*rows(kind, "control.command").indices(999))]
    theirs = [paths(other.loop.Flight).index(paths(kind)[row]) for row in traced]
    inputs = [each.sample(SPEC, 7, "search", range(3)) for each in (system, other)]
    mine = system.flyer(1).trace(GAINS[0], system.nominal, inputs[0], 3, traced)
    np.testing.assert_allclose(
        mine, other.flyer(1).trace(GAINS[0], other.nominal, inputs[1], 3, theirs), rtol=1e-9, atol=1e-10
    )


@pytest.mark.slow
def test_bits_do_not_depend_on_workers_or_order():
    one = flown(fmu(3), threads=1)
    assert np.array_equal(one, flown(fmu(3), threads=3))
    assert np.array_equal(one[1:, :4], flown(fmu(3), 4, 1, GAINS[1:]))


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
def test_a_failure_costs_its_flight_and_no_other(fault):
    """Those that pass 1.25 rad fail; the others have the bits that they have where nothing fails."""
    said = []
    # On a busy machine a crash takes a second, too.
    broken = fmu(2, f"-DFAULT={fault}", fault=1.25, patience=1.0 if fault == "HANG" else 30.0)
    gains = np.array([GAINS[0], [30.0, 200.0, 0.1, 0.001]])
    found, whole = flown(broken, 3, gains=gains, say=said.append), flown(fmu(2), 3, gains=gains)
    status = result_parts(found)[1]
    assert status.tolist() == [[0] * 3, [Status.NON_FINITE.code] * 3]
    assert np.array_equal(found[0], whole[0])
    assert (found[1, :, -1] < SPEC.duration).all()
    assert len(said) == (fault != "NOT_A_NUMBER")
    told = {
        "CRASH": "it crashed (SIGABRT)",
        "HANG": "it gave no answer for 1 s",
        "AN_ERROR": "DoStep failed with status 3 (error)",
    }
    for line in said:
        assert line.startswith("The FMU") and "in 3 of 6 flights" in line and told[fault] in line and "\n" not in line


class Failing:
    """A worker whose FMU fails in every flight: in one way under the first gains, in another under others."""

    def ask(self, request, patience):
        if np.array_equal(request.gains, GAINS[0]):
            return Refused("it refused")
        raise WorkerLostError(f"gave no answer for {patience:g} s")

    def close(self):
        pass


def test_each_way_to_fail_is_told_once_with_its_own_number_of_flights():
    said, system = [], fmu(2)
    flyer = FmuFlyer(system, cast(Any, Failing), 7.0, 2)
    flyer.say = said.append
    inputs = system.sample(SPEC, 7, "search", range(2))
    for _ in range(2):
        results = flyer.fly(np.array([GAINS[0], GAINS[1], GAINS[1]]), system.nominal, inputs)
        assert result_parts(results)[1].tolist() == [[Status.NON_FINITE.code] * 2] * 3
    ways = [re.findall(r"failed in (\d) of (\d) flights: ([^.]*)\.", line) for line in said]
    assert sorted(ways) == [[("2", "6", "it refused")], [("4", "6", "it gave no answer for 7 s")]]


def test_a_failed_flight_costs_more_than_any_other():
    system: Any = fmu(2, "-DFAULT=CRASH", fault=1.25, patience=30.0)
    gains = np.array([GAINS[0], [30.0, 200.0, 0.1, 0.001]])
    metrics = [parse(text, system.axes) for text in ("itae.angle", "travel")]
    spec: Any = SPEC
    scores, failed = score_flights(system, metrics, flown(system, 2, gains=gains), spec, system.targets(spec))
    assert failed.tolist() == [[False, False], [True, True]]
    assert (scores[:, 1] > scores[:, 0]).all()


def test_an_fmu_that_cannot_be_loaded_is_told(tmp_path):
    file = write_motor(tmp_path, 2)
    plant = read_fmu(write_motor(tmp_path, 3, text=None, name="other"), ["torque"])
    object.__setattr__(plant.interface, "token", "another")
    system = FmuSystem(plant, plan_loop(plant, CHANNELS, ACTUATORS), plant.parameters, TIMING)
    with pytest.raises(InputError, match="cannot be loaded: Failed to instantiate"):
        flown(system, 1)
    assert file.exists()


def test_without_fmpy_the_command_that_installs_it_is_told(monkeypatch):
    system = fmu(2)
    monkeypatch.setattr("plant.errors.find_spec", lambda name: None)
    with pytest.raises(MissingPackageError, match=r"pip install 'fmpy>="):
        system.flyer(1)


def margins(system, gains=GAINS):
    return PlantMargins(system, 0.5 * GAINS[0], 2.0 * GAINS[1]).evaluate(gains)


@cache
def margins_of(version, *options, **changes):
    return margins(fmu(version, *options, **changes))


@cache
def native_margins():
    return margins(native())


@each_version
@pytest.mark.parametrize(("directional", "near"), [(True, 1e-5), (False, 1e-7)])
def test_margins_are_those_of_the_plant_in_python(version, directional, near):
    """By directional derivatives sampling is exact, and Runge and Kutta err by 1e-6; by differences it is what flies."""
    found, known = margins_of(version, directional=directional), native_margins()
    assert known.stable.all() and np.array_equal(found.stable, known.stable)
    for name in ("phase_margin", "gain_margin", "ms", "mt"):
        np.testing.assert_allclose(*[QUANTITIES[name].values(each) for each in (found, known)], rtol=near)


def test_an_fmu_that_refuses_its_derivatives_is_differentiated():
    found, known = (
        QUANTITIES["ms"].values(each) for each in (margins_of(2, "-DNO_SLOPE"), margins_of(2, directional=False))
    )
    assert np.array_equal(found, known)


@pytest.mark.slow
def test_outcomes_with_a_lag_go_to_those_of_the_plant_with_the_square_of_the_step():
    lagging = (Actuator("voltage", -12.0, 12.0, delay=0.001, lag=0.002),)
    known = flown(native(lagging, Timing(0.001, 0.000125)), 4)
    found = [flown(fmu(2, actuators=lagging, timing=Timing(0.001, step)), 4) for step in (0.0005, 0.00025)]
    itae = paths(native().loop.Meters).index("angle.itae")
    errors = [np.abs(each[..., itae] / known[..., itae] - 1.0).max(axis=None) for each in found]
    assert errors[0] < 1e-4
    assert errors[1] < 0.3 * errors[0]


@pytest.mark.slow
def test_margins_with_a_lag_are_near_those_of_the_plant_in_python():
    lagging, timing = (Actuator("voltage", -12.0, 12.0, delay=0.001, lag=0.002),), Timing(0.001, 0.00025)
    both = [
        margins(fmu(2, actuators=lagging, timing=timing, directional=each)).sensitivity.value for each in (True, False)
    ]
    np.testing.assert_allclose(both[0], both[1], rtol=1e-5)
    np.testing.assert_allclose(both[0], margins(native(lagging, timing)).sensitivity.value, rtol=5e-3)


@pytest.mark.parametrize("directional", [True, False])
def test_states_that_an_fmu_hides_are_found_out(directional):
    with pytest.raises(InputError, match="answers a step of voltage otherwise"):
        margins(fmu(2, "-DHIDDEN", directional=directional))


def test_margins_need_all_states():
    with pytest.raises(InputError, match=r"name all of its states in \[plant\] states"):
        margins(fmu(3, states=("angle",), name="half"))


def test_margins_need_an_fmu_that_rests():
    system = fmu(2, "-DMOVING", name="moving")
    with pytest.raises(InputError, match="does not rest where it starts: motor_speed"):
        margins(system)


def test_a_lag_beside_an_fmu_is_at_least_half_a_step():
    """Of an FMU nobody knows the equations: it is driven in the steps that are written, by default the control period."""
    fmu: Any = object()
    period = 0.04

    def timing(lag, plant_step=None):
        actuators = (Actuator("power", lag=lag),)
        made = partial(FmuSystem, fmu, LoopPlan((), actuators), None)
        return with_timing(made, actuators, period, plant_step).timing

    assert timing(0.02).plant_step == period
    with pytest.raises(InputError, match="must be at most twice the lag of power") as caught:
        timing(0.001)
    advised = float(str(caught.value).split("plant_step = ")[1].split(",")[0])
    assert timing(0.001, advised).steps == 20
