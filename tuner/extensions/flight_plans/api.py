"""An experiment to fly before a vehicle is identified."""

import shlex
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import cached_property
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from plant.air.spec import AirSpec
from plant.errors import InputError
from plant.quadrotor.airframes import Airframe, load
from plant.quadrotor.scenarios import ScenarioSpec
from tuner.analysis.responses import system_of
from tuner.api.flight_setup import quadrotor_setup
from tuner.api.frames import Documented, figures, frame, shown
from tuner.api.gains import GainsLike, as_gains, default_gains
from tuner.api.studies import StudyLike
from tuner.extensions.flight_plans.building import flight_plan_document
from tuner.extensions.flight_plans.document import FlightPlanDocument
from tuner.extensions.flight_plans.excitation_target import HALF_FIRST
from tuner.extensions.flight_plans.exciters import USUAL, exciter
from tuner.extensions.flight_plans.flying import SimulatedVehicle
from tuner.extensions.flight_plans.planning import Experiment, ExperimentSpec, check_names, plan_experiment
from tuner.extensions.identification.api import check_deviation, new_page
from tuner.extensions.logs.csv_writing import MAPPING, csv_table
from tuner.extensions.vehicle_fit.parameters import ARM, MASS, space_of
from tuner.search.watcher import Watcher, compilation, default_watcher
from tuner.store.folder import Folder

if TYPE_CHECKING:
    import pandas as pd

    from tuner.report.charts.paper import Figure

LOG, COLUMNS = "simulated_log.csv", "columns.toml"
"""Files of the simulated log, and of the mapping of its columns."""
LAW = "pid"
"""Attitude law that flies where no gains are given."""
LIGHT_WIND = ScenarioSpec(
    "a light wind", air=AirSpec(intensity=2.0, altitude=3.0, minimum_airspeed=1.0, mean_wind=False)
)
"""Turbulence of 2 m/s at 20 ft; a pilot holds against its mean."""
WITHIN, TILT_DEG, RATE_DEG = 0.1, 20.0, 200.0
SEED = 1
SPANS = {"within": (0.001, 1.0), "tilt": (1.0, 60.0), "rate": (5.0, 2000.0)}
"""Limits: a share, [deg], [deg/s]."""


@dataclass(frozen=True)
class FlightPlan(Documented):
    """An experiment to fly.

    Attributes:
        document: Output of `tuner identify --plan --json`.
        made: The excitations and the simulated flights behind it.
        folder: Folder of the target's files and the simulated log, None if none was written.
        airframe: The airframe as it was given, a name or a file.

    """

    document: FlightPlanDocument
    made: Experiment
    folder: Path | None = None
    airframe: str = ""

    @property
    def trial(self) -> str:
        """Command that identifies the vehicle from the simulated log; "" where no folder was written."""
        if self.folder is None:
            return ""
        log, columns = self.folder / LOG, self.folder / COLUMNS
        return shlex.join(["tuner", "identify", str(log), "--mapping", str(columns), "--airframe", self.airframe])

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each number: half-widths of its 95 % intervals before, foreseen, and obtained from a simulated log."""
        return frame(self.document.numbers, "name")

    def figure(self) -> "Figure":
        """Draw the commanded over the simulated motion of each axis.

        Returns:
            The figure, made without pyplot.

        """
        return figures("flight plan", self.made).draw("excitations")

    def _repr_html_(self) -> str:
        return shown(f"An experiment of {self.document.duration:.0f} s", [self.document.verdict], self.table)


def plan_flight(
    airframe: str | Path,
    *,
    numbers: Sequence[str] = (),
    within: float = WITHIN,
    tilt_deg: float = TILT_DEG,
    rate_deg: float = RATE_DEG,
    mass: float = MASS,
    arm: float = ARM,
    gains: GainsLike | None = None,
    study: StudyLike | None = None,
    to: str = USUAL,
    out: str | Path | None = None,
    report: str | Path | None = None,
    watcher: Watcher | None = None,
) -> FlightPlan:
    """Plan the flight whose log identifies a vehicle to an accuracy.

    The log is for `identify`.

    Args:
        airframe: Prior: a bundled airframe or a TOML file.
        numbers: Names of the numbers that are to be known; by default all that such a flight identifies so well.
        within: Half-width of a 95 % interval over its number [1]; of the dead time over the mean lag, of the centre of mass over
            the arm.
        tilt_deg: Largest tilt of the flight [deg].
        rate_deg: Largest body rate of the flight [deg/s].
        mass: Relative standard deviation of the airframe's mass [1].
        arm: Relative standard deviation of the airframe's lengths [1].
        gains: Gains that fly the vehicle; by default those of `pid` for the airframe.
        study: Study whose first scenario says what air and which sensors are met; by default a light wind.
        to: Target that flies it: "csv", "ardupilot" or "betaflight".
        out: New folder for plan.json, the target's files, and a simulated log with the mapping of its columns.
        report: Page (HTML) to write; it must not be there yet.
        watcher: Callbacks that hear of progress.

    Returns:
        Excitations axis by axis, intervals before and after, and what the flight comes to of its limits.

    Raises:
        InputError: No flight identifies the parameters within the limits; or a name is unknown.
        UnphysicalError: No vehicle has the numbers of the airframe.
        StoreError: The folder holds something already, or cannot be written.

    Examples:
        >>> tuner.plan_flight("crazyflie-pybullet", numbers=["mass"])
        Traceback (most recent call last):
        plant.errors.InputError: --numbers: given mass, which no flight identifies; weigh or measure it, and say how well with
        --mass >>> planned = tuner.plan_flight("crazyflie-pybullet", numbers=["lag_up"], within=0.05)  # doctest: +SKIP
        >>> planned.table.loc["lag_up", "foreseen"] < 0.05  # doctest: +SKIP
        True

    """
    for name, value in (("within", within), ("tilt", tilt_deg), ("rate", rate_deg)):
        low, high = SPANS[name]
        if not low <= value <= high:
            raise InputError(f"given {value:g}; allowed: {low:g} to {high:g}", key=f"--{name}")
    check_deviation(mass, "--mass")
    check_deviation(arm, "--arm")
    target, page = exciter(to), None if report is None else new_page(Path(report))
    heard, prior = watcher or default_watcher(), load(airframe)
    check_names(numbers, space_of(prior.vehicle, []))
    request = ExperimentSpec(tuple(numbers), within, radians(tilt_deg), radians(rate_deg), mass, arm)
    folder = None if out is None else Folder.create(Path(out), inside="", empty=True)
    with folder or nullcontext():
        simulated = craft_of(prior, airframe, gains, study)
        if not simulated.flyer.cached:
            with compilation(heard):
                simulated.flown([], "warm-up", 1)
        made = plan_experiment(simulated, prior, request, target.capabilities, heard.on_message)
        files = target.all_files(made.excitations, simulated)
        document = flight_plan_document(
            made, target.name, [*target.notes, HALF_FIRST], [] if folder is None else sorted(files)
        )
        if folder is not None:
            log = {LOG: csv_table(made.proof.logs[0]).encode(), COLUMNS: MAPPING.encode()}
            folder.write_together({**files, **log})
            folder.write_json("plan.json", document)
    if page is not None:
        # The library that draws its charts takes a second to import.
        from tuner.extensions.flight_plans.page import flight_plan_page
        from tuner.report.page import put_page

        put_page(page.parent, flight_plan_page(made, document), page.name)
    return FlightPlan(document, made, None if folder is None else folder.path, str(airframe))


def craft_of(
    prior: Airframe, airframe: str | Path, gains: GainsLike | None, study: StudyLike | None
) -> SimulatedVehicle:
    """Return the airframe with the gains, in the air of the study.

    The air is that of its first scenario.
    """
    given = default_gains(LAW, airframe=str(airframe)) if gains is None else as_gains(gains)
    refusal = "holds gains of a plant of one's own; a flight is planned for a quadrotor"
    controller = replace(given.quadrotor(refusal), airframe=prior)
    if study is None:
        spec, seed = LIGHT_WIND, SEED
    else:
        setup = quadrotor_setup(controller, study, 0, SEED)
        flown, seed = cast(ScenarioSpec, setup.spec), setup.root
        spec = replace(LIGHT_WIND, name=flown.name, air=flown.air, sensors=flown.sensors)
    spec = replace(spec, uncertainty=prior.uncertainty)
    return SimulatedVehicle(system_of(controller), np.array(controller.gains), spec, seed)
