"""Setup of flights: a system with gains, through a scenario."""

from dataclasses import dataclass

import numpy as np

from objectives.flown_system import FlownSystem, Scenario
from objectives.metrics import MetricAddress
from plant.backends.flyer import FlightInputs
from plant.errors import InputError
from plant.quadrotor.scenarios import HELD_OUT
from tuner.analysis.judged_metrics import shown_metrics
from tuner.analysis.responses import LIMITS, system_of, usual_scenario
from tuner.api.studies import StudyLike, tuning_study
from tuner.gains import Controller
from tuner.study.plant_controller import PlantController
from tuner.study.study import TuningStudy


@dataclass(frozen=True)
class FlightSetup:
    """Flights to be made.

    Attributes:
        system: Flies the gains, a row (g,), through the scenario `spec`.
        root: Root seed of the draws.
        laws: Laws in words.
        metrics: Addresses that such flights can be judged by.
        draws: Stream and numbers of the flights.
        single: The one flight that is flown instead, None for those of the draws.

    """

    system: FlownSystem
    gains: np.ndarray
    spec: Scenario
    root: int
    laws: str
    metrics: list[MetricAddress]
    draws: tuple[str, range] = (HELD_OUT, range(0))
    single: FlightInputs | None = None

    def inputs(self, indices: range) -> FlightInputs:
        """Return flights of the draws by their numbers, or the single one."""
        if self.single is not None:
            return self.single
        return self.system.sample(self.spec, self.root, self.draws[0], indices)


def quadrotor_setup(controller: Controller, study: StudyLike | None, scenario: int, seed: int) -> FlightSetup:
    """Return the scenario and limits of a study, or the usual ones."""
    row = np.array(controller.gains)
    laws = f"{controller.cascade.position.name} / {controller.cascade.attitude.name}"
    if study is None:
        system = system_of(controller, LIMITS)
        spec, root, named = usual_scenario(system), seed, []
    else:
        given = tuning_study(study, "tuner fly --study")
        system = system_of(controller, given.system.limits)
        spec, root, named = spec_of(given, scenario), given.seed, given.judged_metrics
    return FlightSetup(system, row, spec, root, laws, shown_metrics(system, spec, named))


def plant_setup(controller: PlantController, scenario: int) -> FlightSetup:
    """Return a scenario of the study that closes a plant's loops."""
    study = controller.study
    spec, laws = spec_of(study, scenario), dict(study.about)["laws"]
    metrics = shown_metrics(study.system, spec, study.judged_metrics)
    return FlightSetup(study.system, np.array(controller.gains), spec, study.seed, laws, metrics)


def spec_of(study: TuningStudy, scenario: int) -> Scenario:
    """Return a scenario of a study by its number from 0; InputError where there is none."""
    if scenario >= len(study.scenarios):
        raise InputError(
            f"given scenario {scenario}; allowed: 0 to {len(study.scenarios) - 1}", file=study.path, key="--scenario"
        )
    return study.scenarios[scenario].spec
