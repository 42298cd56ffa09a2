"""A study that searches gains before anything flies: what it asks for, trims, the default's margins, limits out of reach."""

from collections.abc import Collection, Sequence
from math import degrees, isfinite, radians
from typing import Any

import numpy as np
from pydantic import Field

from objectives.requirements import Requirement, known_values
from plant.quadrotor.airframes.derived import quantities
from plant.quadrotor.vehicle import Vehicle
from plant.seeds import generator
from tuner.analysis.plant_step import estimated_plant_step, plant_step_of, plant_step_warnings
from tuner.documents.obstacles import UnmetConstraint
from tuner.documents.parts import NumberWithUnit, PlantStep
from tuner.documents.plan import AutomaticLimit
from tuner.experiments.planning.counts import search_flights
from tuner.experiments.planning.default_stability import (
    UnstableLoop,
    instability_texts,
    unstable_loops_at_hover,
    unstable_loops_of_plant,
)
from tuner.experiments.tuning.conflicts import automatic_limit_texts, automatic_rows
from tuner.experiments.tuning.diagnosis import Diagnosis, unreached_texts
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.experiments.tuning.problem import problem_of
from tuner.search.initial_design import latin_hypercube
from tuner.store.document import DocumentPart, Sense
from tuner.study.fitted import fitted_texts
from tuner.study.margins import INEXACT
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study
from tuner.study.trim import MeanWindTrim, mean_wind_trim

# Points of the ranges at which limits that are known without flying are asked.
DRAWS = 128
# Margin of a trim to the tilt limit [rad] below which gusts will take it.
NARROW = radians(5.0)


class VehicleRow(DocumentPart):
    """The vehicle; hover_speed_share: of the largest rotor speed."""

    name: str
    mass: NumberWithUnit
    thrust_to_weight: NumberWithUnit
    hover_speed: NumberWithUnit
    hover_speed_share: NumberWithUnit


class TrimRow(DocumentPart):
    """Steady flight in the mean wind [m/s] of a scenario; angles and thrust null where nothing balances.

    Attributes:
        tilt: Tilt [rad].
        tilt_limit: Limit of the tilt [rad].
        margin: Margin to the limit [rad].
        thrust: Thrust over the weight.
        held: Whether the vehicle holds its place.
    """

    scenario: str
    wind: float
    tilt: float | None
    tilt_limit: float
    margin: float | None
    thrust: float | None
    held: bool


class DefaultRow(DocumentPart):
    """The default at a limit that is known without flying; loop null where it is no margin of one, value null where infinite.

    state: steady state in which the value is worst, left out where there is one alone.
    """

    label: str
    loop: str | None
    value: float | None
    unit: str
    shown_unit: str | None = None
    sense: Sense
    limit: float
    hard: bool
    is_satisfied: bool = Field(alias="kept")
    state: str | None = None


class UnreachedLimit(UnmetConstraint):
    """A limit that neither the default nor a draw keeps; certain: no searched gain brings it nearer, so that no search can."""

    certain: bool


class PreviewPart(DocumentPart):
    """Preview of a study of any kind: its flights, and results that need none."""

    kind: str
    title: str

    @property
    def is_hopeless(self) -> bool:
        """Whether it asks for what nothing can reach."""
        return False


class StudyPreview(PreviewPart):
    """A study that searches gains before anything flies; a kind leaves out what it has not.

    Args:
        plant: Title of a user plant.
        channels: Its channels with their laws.
        requirements: Limits on margins; of a plant with the default's values, null where infinite.
        plant_step: With the error in what is known of the default.
    """

    plant: str | None = None
    channels: dict[str, str] = {}
    variables: int
    objectives: list[str]
    constraints: list[str]
    automatic_limits: list[AutomaticLimit]
    requirements: list[str] | dict[str, float | None]
    search_flights: int
    stop: str | None = None
    digest: str
    vehicle: VehicleRow | None = None
    plant_step: PlantStep
    trim: list[TrimRow] = []
    default: list[DefaultRow] = []
    unstable: list[UnstableLoop] = []
    out_of_reach: list[UnreachedLimit] = []
    problems: list[str] = []
    warnings: list[str]
    notes: list[str] = Field(alias="told")

    @property
    def is_hopeless(self) -> bool:
        """Whether it asks for what no search brings nearer.

        That is a hard limit that no searched gain moves, a mean wind that the vehicle cannot hold, a b0 of the wrong sign.
        """
        soft = {row.label for row in self.default if not row.hard}
        lost = any(row.certain and row.label not in soft for row in self.out_of_reach)
        return lost or any(not row.held for row in self.trim) or any(loop.other_sign for loop in self.unstable)


def vehicle_row(name: str, vehicle: Vehicle) -> VehicleRow:
    """Return a vehicle's mass, thrust-to-weight ratio and hover speed."""
    derived = quantities(vehicle)
    hover, ratio = derived["hover_speed"], derived["thrust_to_weight"]
    return VehicleRow(
        name=name,
        mass=NumberWithUnit(value=vehicle.mass, unit="kg"),
        thrust_to_weight=NumberWithUnit(value=ratio.value, unit=ratio.unit),
        hover_speed=NumberWithUnit(value=hover.value, unit=hover.unit),
        hover_speed_share=NumberWithUnit(value=hover.value / vehicle.speed_max, unit="1"),
    )


def trim_rows(study: Study) -> list[TrimRow]:
    """Return the steady flight of each scenario with a mean wind."""
    result = [(entry.spec.name, mean_wind_trim(entry.spec, study.system)) for entry in study.scenarios]
    return [_trim_row(name, trim) for name, trim in result if trim is not None]


def _trim_row(scenario: str, trim: MeanWindTrim) -> TrimRow:
    tilt, limit, balanced = trim.tilt, trim.tilt_limit, isfinite(trim.tilt)
    return TrimRow(
        scenario=scenario,
        wind=trim.wind,
        tilt=tilt if balanced else None,
        tilt_limit=limit,
        margin=limit - tilt if balanced else None,
        thrust=trim.thrust if balanced else None,
        held=trim.held,
    )


def default_rows(study: Study, diagnosis: Diagnosis) -> list[DefaultRow]:
    """Return the default's exact values and verdicts for limits without flights; loop by loop."""
    row = study.default_row
    rows = zip(diagnosis.probes, diagnosis.exact(row[None])[0].tolist(), diagnosis.worst_states(row), strict=True)
    return [_default_row(probe.requirement, probe.loop, value, state) for probe, value, state in rows]


def _default_row(limit: Requirement, loop: str | None, value: float, state: str | None) -> DefaultRow:
    row = DefaultRow(
        label=limit.label,
        loop=loop,
        value=limit.in_file(value) if isfinite(value) else None,
        unit=limit.unit,
        sense=limit.sense,
        limit=limit.in_file(limit.limit),
        hard=limit.hard,
        kept=bool(limit.is_satisfied(np.array([value]))[0]),
    )
    return row.model_copy(update=limit.units() | ({} if state is None else {"state": state}))


def beyond_reach(study: Study, diagnosis: Diagnosis, broken: Collection[str]) -> list[UnreachedLimit]:
    """Return the broken limits that none of `DRAWS` draws keeps, with causes.

    broken: labels of those that the default breaks. diagnosis: of the values in which draws are compared.
    """
    if not broken:
        return []
    searched = len(study.space.variables)
    drawn = latin_hypercube(DRAWS, searched, generator(study.seed, "check/reach", 0)) if searched else np.empty((0, 0))
    points = np.concatenate([study.space.point(study.default_row)[None].reshape(1, searched), drawn])
    names = ["the default", *[f"draw {i + 1}" for i in range(len(drawn))]]
    values = diagnosis.values(study.space.gains(points))
    # A search reads margins beside position loops that wait coarsely, to this share of a limit.
    slack = INEXACT if study.system.cascade.position_every > 1 else 0.0
    met = np.stack([probe.broken(values[:, i]) <= slack for i, probe in enumerate(diagnosis.probes)], axis=1)
    labels = [probe.requirement.label for probe in diagnosis.probes]
    unreached = [
        label
        for label in dict.fromkeys(labels)
        if label in broken and not met[:, [i for i, other in enumerate(labels) if other == label]].all(axis=1).any()
    ]
    # No search can help where nothing that is searched moves it.
    return [
        UnreachedLimit.model_validate({**entry.content(), "certain": not entry.moved_by}, strict=False)
        for entry in diagnosis.obstacles(points, names, unreached)
    ]


def plant_step_row(study: Study) -> PlantStep:
    """Return the plant's integration step; with the error in the default's flights where the kernel is compiled already."""
    problem = problem_of(study, None, None)
    if not problem.flyer.cached:
        return plant_step_of(study)
    return estimated_plant_step(problem, study, study.default_row[None])


def study_preview(described: Study) -> StudyPreview:
    """Return a quadrotor study's preview, computed without flying.

    Draws are compared at hover alone; so is the default where its margins would take 0.4 s in each trim.
    """
    at_hover = Diagnosis(described, at_hover=True)
    default = default_rows(described, at_hover if _is_slow_in_trims(described) else Diagnosis(described))
    beyond = beyond_reach(described, at_hover, {row.label for row in default if not row.is_satisfied})
    trims = trim_rows(described)
    unstable = unstable_loops_at_hover(described) if any(_is_unstable(row) for row in default) else []
    certain = [row for row in beyond if row.certain]
    drawn = [row for row in beyond if not row.certain]
    return _preview(
        described,
        plant_step_row(described),
        fitted_texts(described.system),
        [*instability_texts(unstable, "loop"), *unreached_texts(drawn)],
        kind="study",
        requirements=[requirement.label for requirement in described.requirements],
        stop=described.search.stop,
        vehicle=vehicle_row(described.airframe.name, described.system.vehicle),
        trim=trims,
        default=default,
        unstable=unstable,
        out_of_reach=beyond,
        problems=[*trim_problems(trims), *unreached_texts(certain)],
    )


def _is_slow_in_trims(study: Study) -> bool:
    """Return True if margins in trims take long: of position loops that wait, or of a spread of vehicles."""
    return study.system.cascade.position_every > 1 or any(entry.spread for entry in study.loop_requirements())


def _is_unstable(row: DefaultRow) -> bool:
    """Return True if a margin is that of an unstable loop."""
    return row.loop is not None and (row.value is None if row.sense == "max" else row.value == 0.0)


def plant_preview(study: PlantStudy) -> StudyPreview:
    """Return a plant study's preview, with the default's values without flights."""
    values = known_values(study.screens, study.default_row[None], complete=True)[0].tolist() if study.screens else []
    unstable = unstable_loops_of_plant(study)
    wrong = [loop for loop in unstable if loop.other_sign]
    return _preview(
        study,
        plant_step_of(study, study.default_row[None]),
        warned=instability_texts([loop for loop in unstable if not loop.other_sign], "channel"),
        kind="plant",
        unstable=unstable,
        problems=instability_texts(wrong, "channel"),
        plant=study.system.plant.title,
        channels={channel.name: channel.law.name for channel in study.system.plan.channels},
        requirements={
            entry.label: value if isfinite(value) else None
            for entry, value in zip(study.requirements, values, strict=True)
        },
        default=[
            _default_row(entry, None, value, None) for entry, value in zip(study.requirements, values, strict=True)
        ],
    )


def _preview(
    study: Study | PlantStudy,
    plant_step: PlantStep,
    fitted: Sequence[str] = (),
    warned: Sequence[str] = (),
    **of_its_kind: Any,
) -> StudyPreview:
    """Return the preview of a study, with what only its kind has; fitted, warned: sentences of its notes and warnings."""
    searched = [study.search.text, *study.start_texts] if study.space.variables else []
    return StudyPreview(
        title=study.title,
        variables=len(study.space.variables),
        objectives=[objective.label for objective in study.objectives],
        constraints=[entry.objective.label for entry in study.constraints],
        automatic_limits=automatic_rows(study.automatic_limits),
        search_flights=search_flights(study),
        digest=study.digest(),
        plant_step=plant_step,
        warnings=[*warned, *warnings_before_run(study), *plant_step_warnings(plant_step, study.plant_step_key)],
        told=[*searched, *fitted, *automatic_limit_texts(study.automatic_limits)],
        **of_its_kind,
    )


def trim_problems(trims: list[TrimRow]) -> list[str]:
    """Return a sentence for each scenario with little or no tilt margin; in its mean wind."""
    return [_problem(row) for row in trims if not row.held or (row.margin or 0.0) < NARROW]


def _problem(row: TrimRow) -> str:
    wind = f'scenario "{row.scenario}": the mean wind of {row.wind:.3g} m/s'
    if row.held:
        return f"{wind} leaves {degrees(row.margin or 0.0):.1f} deg to the tilt limit, which gusts will take."
    remedy = "choose a weaker intensity or mean_wind = false, or raise controller.tilt_limit_deg"
    return f"{wind} is more than the vehicle holds its place in; {remedy}."
