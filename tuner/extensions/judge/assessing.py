"""Both files in the loops and in the air: margins, paired flights, rules of the firmware, verdict."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np

from objectives.margins.trim import Trim
from objectives.metrics import parse
from objectives.problem import FlightBatch, Problem
from objectives.risk.differences import WORSE
from plant.errors import InputError
from plant.quadrotor.cascade import ATTITUDE_AXES, AXES
from tuner.analysis.margins.judging import judge_quadrotor
from tuner.api.flight_setup import FlightSetup, quadrotor_setup
from tuner.api.flying import problem_of
from tuner.documents.assessment import (
    AssessedLoop,
    AssessmentDocument,
    ChangedGain,
)
from tuner.documents.parts import NumberWithUnit
from tuner.extensions.judge.firmware_rules import LoopSet, firmware_rules
from tuner.extensions.judge.opinion import Evidence, form_opinion, opinion_sentence
from tuner.extensions.judge.paired_scores import PairedScores
from tuner.extensions.judge.scenarios import (
    FAILURE,
    HAS_POSITION_LOOPS,
    NOISE,
    POSITION,
    TILT,
    YAW,
    JudgedScenario,
    judged_scenarios,
    noise_density,
)
from tuner.extensions.judge.spread_losses import spread_reasons
from tuner.extensions.judge.vehicle_files import GainsFile, Subjects
from tuner.extensions.judge.verdict_basis import configuration_notes
from tuner.gains import Controller
from tuner.search.watcher import JUDGING, Watcher, compilation

STREAM = "judge"
MIN_FLIGHTS = 2
"""Smallest number of flights of a scenario."""


@dataclass
class Stages:
    """Time of each stage [s]."""

    seconds: dict[str, float] = field(default_factory=dict[str, float])

    @contextmanager
    def measure(self, name: str) -> Iterator[None]:
        """Add the time of a stage."""
        begin = perf_counter()
        yield
        self.seconds[name] = round(self.seconds.get(name, 0.0) + perf_counter() - begin, 3)


def read_loops(file: GainsFile) -> LoopSet:
    """Return the loops of a file at hover."""
    loops, document, _ = judge_quadrotor(file.gains.controller, Trim(), None, certified=False)
    return LoopSet(loops, document, file.gains)


def assess(
    subjects: Subjects, flights: int, seed: int, threads: int | None, stages: Stages, watcher: Watcher
) -> AssessmentDocument:
    """Return the content of assessment.json.

    Args:
        subjects: Files and vehicle.
        flights: Flights of each file.
        seed: Root seed.
        threads: Threads, None for one for each core.
        stages: Time of each stage.
        watcher: Hears of compilation and flights.
    """
    after, before = subjects.after, subjects.before
    with stages.measure("margins"):
        loops = [read_loops(one) for one in (after, before) if one is not None]
    prepared = scenario_setups(subjects, flights, seed)
    flown = fly_scenarios(prepared, seed, threads, stages, watcher)
    with stages.measure("verdict"):
        spread = spread_reasons(
            [(setups[0], paired.scores[0, 0] > 0.0) for (_, setups), paired in zip(prepared, flown, strict=True)],
            after.gains.controller.airframe.vehicle,
            lambda setup: fly([setup], threads, Stages(), watcher)[0, 0] > 0.0,
        )
        evidence = replace(gather_evidence(subjects, loops, flown), spread=spread)
        verdict, reasons = form_opinion(evidence)
    first, *further = evidence.scenarios
    return AssessmentDocument(
        format="gainproof-assessment",
        version="0.1",
        verdict=verdict,
        comparison=evidence.comparison,
        sentence=opinion_sentence(evidence, verdict, reasons),
        reasons=reasons,
        unmodeled=_notes(subjects),
        unmodeled_changes=subjects.unmodeled_changes,
        guessed=subjects.guessed,
        after=after.part,
        before=None if before is None else before.part,
        airframe=subjects.airframe,
        changes=[] if before is None else changed_gains(before, after),
        loops=list(evidence.loops),
        rules=list(evidence.rules),
        scenario=first.name,
        seed=seed,
        flights=first.flights,
        gyro_noise=NumberWithUnit(value=noise_density(after.gains.controller), unit="rad/s/sqrt(Hz)"),
        metrics=list(evidence.metrics),
        lost_after=first.lost_after,
        lost_before=first.lost_before,
        further=further,
        rollback=None,
        not_restored=subjects.not_restored,
        seconds=stages.seconds,
    )


def fly_scenarios(
    prepared: Sequence[tuple[JudgedScenario, list[FlightSetup]]],
    seed: int,
    threads: int | None,
    stages: Stages,
    watcher: Watcher,
) -> list[PairedScores]:
    """Return the scores of both files in each scenario; prepared: flights of both, as of `scenario_setups`."""
    watcher.on_stage(JUDGING, sum(len(setup.draws[1]) for _, setups in prepared for setup in setups))
    return [
        PairedScores(setups[0].metrics, fly(setups, threads, stages, watcher), seed, scenario)
        for scenario, setups in prepared
    ]


def fly(setups: Sequence[FlightSetup], threads: int | None, stages: Stages, watcher: Watcher) -> np.ndarray:
    """Return the scores (files, metrics, flights) of each file's flights."""
    # Air and noise take as long to draw as to fly through: gains of one system share them.
    first, *others = (setup.system.content(setup.spec) for setup in setups)
    is_shared = all(other == first for other in others)
    groups = [setups] if is_shared else [[setup] for setup in setups]
    with stages.measure("compilation"):
        problems = [problem_of(group[0], threads) for group in groups]
        for group, problem in zip(groups, problems, strict=True):
            with nullcontext() if problem.flyer.cached else compilation(watcher):
                problem.warm_up(group[0].gains, group[0].spec)
    with stages.measure("flights"):
        return np.concatenate([score(problem, group, watcher) for group, problem in zip(groups, problems, strict=True)])


def score(problem: Problem, setups: Sequence[FlightSetup], watcher: Watcher) -> np.ndarray:
    """Return the scores (files, metrics, flights) of files that fly one system."""
    rows, (stream, indices) = np.array([setup.gains for setup in setups]), setups[0].draws
    batch, flown = FlightBatch(setups[0].spec, stream, indices.stop, indices.start), np.ones(len(rows), dtype=bool)
    parts = [
        problem.scored(rows, flown, batch, first, last, watcher.on_flights_done)[0]
        for first, last in problem.chunks(batch)
    ]
    return np.concatenate(parts, axis=-1)


def gather_evidence(subjects: Subjects, loops: Sequence[LoopSet], flown: Sequence[PairedScores]) -> Evidence:
    """Return the evidence from margins and flights.

    Args:
        subjects: Files and vehicle.
        loops: Loops of the file, then of the one before.
        flown: Scores of each scenario, the first flight first.
    """
    channels = AXES if subjects.source in HAS_POSITION_LOOPS else ATTITUDE_AXES
    later, earlier = loops[0], loops[1] if len(loops) > 1 else None
    metrics = [row for scores in flown for row in scores.rows]
    noise_rises = any(row.metric == NOISE and row.verdict == WORSE for row in metrics)
    assessed = [
        AssessedLoop(
            channel=channel, before=None if earlier is None else earlier.figures(channel), after=later.figures(channel)
        )
        for channel in channels
    ]
    requirements = later.document.requirements
    return Evidence(
        airframe=subjects.airframe,
        loops=assessed,
        violated=[row for row in requirements if row.hard and not row.is_satisfied and row.channel in channels],
        rules=firmware_rules(subjects.source, later, earlier, noise_rises),
        metrics=metrics,
        scenarios=[scores.summary for scores in flown],
        unmodeled=len(subjects.unmodeled_changes),
    )


def scenario_setups(subjects: Subjects, flights: int, seed: int) -> list[tuple[JudgedScenario, list[FlightSetup]]]:
    """Return each scenario with the flights of both files.

    Args:
        subjects: Files and vehicle.
        flights: First flights of each file.
        seed: Root seed.
    """
    controllers = [one.gains.controller for one in (subjects.after, subjects.before) if one is not None]
    periods = {controller.control_period for controller in controllers}
    if len(periods) > 1:
        given = " and ".join(f"{1.0 / period:g} Hz" for period in sorted(periods, reverse=True))
        message = (
            f"its loops run at another rate than those before ({given}); air is the same for both at one rate only"
        )
        raise InputError(message, file=subjects.after.path)
    return [
        (scenario, [_setup(scenario, controller, flights, seed) for controller in controllers])
        for scenario in judged_scenarios(controllers[-1], subjects.source)
    ]


def changed_gains(before: GainsFile, after: GainsFile) -> list[ChangedGain]:
    """Return the gains that differ, with their ratio."""
    return [
        ChangedGain(
            name=name,
            unit=after.gains.units[name],
            before=before.gains.get(name),
            after=value,
            ratio=value / was if (was := before.gains.get(name)) else None,
        )
        for name, value in after.gains.items()
        if before.gains.get(name) != value
    ]


def _notes(subjects: Subjects) -> list[str]:
    """Return the notes of both imports, each kind once."""
    after = [*configuration_notes(subjects), *subjects.after.notes]
    kinds = {note.partition(":")[0] for note in after}
    before = [] if subjects.before is None else subjects.before.notes
    return [*after, *(f"Of the file before: {note}" for note in before if note.partition(":")[0] not in kinds)]


def _setup(scenario: JudgedScenario, controller: Controller, flights: int, seed: int) -> FlightSetup:
    """Return the flights of one file in a scenario; all scenarios have one list of metrics, so that they share a kernel."""
    setup = quadrotor_setup(scenario.vehicle_of(controller), None, 0, seed)
    return replace(
        setup,
        spec=scenario.spec,
        metrics=[parse(name, setup.system.axes) for name in (FAILURE, TILT, YAW, NOISE, POSITION)],
        draws=(STREAM, range(max(flights // scenario.share, MIN_FLIGHTS))),
    )
