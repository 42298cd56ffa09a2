"""Both files in the loops and in the air: margins, paired flights, rules of the firmware, verdict."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from math import sqrt
from time import perf_counter

import numpy as np

from objectives.margins.trim import Trim
from objectives.metrics import parse
from objectives.problem import FlightBatch, Problem
from objectives.risk.differences import WORSE
from plant.air.spec import AirSpec
from plant.errors import InputError
from plant.quadrotor.cascade import ATTITUDE_AXES, AXES
from plant.quadrotor.scenarios import ScenarioSpec, Spread
from plant.quadrotor.sensors import SensorSpec
from plant.references.steps import Steps
from tuner.analysis.margins.judging import judge_quadrotor
from tuner.api.flight_setup import FlightSetup, quadrotor_setup
from tuner.api.flying import problem_of
from tuner.documents.assessment import (
    AssessedLoop,
    AssessmentDocument,
    ChangedGain,
)
from tuner.documents.parts import NumberWithUnit
from tuner.extensions.autopilots.sources import GAINS
from tuner.extensions.judge.firmware_rules import LoopSet, firmware_rules
from tuner.extensions.judge.opinion import Evidence, form_opinion, opinion_sentence
from tuner.extensions.judge.paired_scores import FAILURE, PairedScores
from tuner.extensions.judge.spread_losses import spread_reason
from tuner.extensions.judge.vehicle_files import GainsFile, Subjects
from tuner.extensions.judge.verdict_basis import configuration_notes
from tuner.gains import Controller
from tuner.search.watcher import JUDGING, Watcher, compilation

STREAM = "judge"
FIRST_FLIGHT = ScenarioSpec(
    "small steps in a light breeze",
    6.0,
    Steps(x=0.5, y=-0.5, z=0.25, yaw_deg=10.0, time=0.5),
    AirSpec(intensity=2.0, altitude=3.0, minimum_airspeed=1.0, mean_wind=True),
)
"""Flights that gains are judged by: 2 m/s of wind at 20 ft, Beaufort 2."""
SPREAD = Spread(mass=0.1, inertia=0.1, thrust=0.05, lag=0.2)
"""Spread of vehicles whose airframe has no uncertainty: that of the shipped studies of firmwares."""
GYRO_NOISE = 0.05 / sqrt(2000.0)
"""Density of the gyro's noise where the airframe has none [rad/s/sqrt(Hz)]: 0.05 rad/s at 4 kHz, a frame that vibrates."""
NOISE, POSITION = "noise", "rms.position"
HAS_POSITION_LOOPS = ("px4", "ardupilot", GAINS)
"""Sources whose position loops are in the file; of others they are our defaults, and no part of the verdict."""


@dataclass
class Stages:
    """Time of each stage [s]."""

    seconds: dict[str, float] = field(default_factory=dict[str, float])

    @contextmanager
    def measure(self, name: str) -> Iterator[None]:
        """Take the time of a stage."""
        begin = perf_counter()
        yield
        self.seconds[name] = round(perf_counter() - begin, 3)


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
    setups = flight_setups(subjects, flights, seed)
    paired = PairedScores(setups[0].metrics, fly(setups, threads, stages, watcher), seed)
    with stages.measure("spread"):
        spread = spread_reason(
            setups[0],
            after.gains.controller.airframe.vehicle,
            paired.scores[0, 0] > 0.0,
            lambda setup: fly([setup], threads, Stages(), watcher)[0, 0] > 0.0,
        )
    with stages.measure("verdict"):
        evidence = replace(gather_evidence(subjects, loops, paired), spread=spread)
        verdict, reasons = form_opinion(evidence)
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
        scenario=setups[0].spec.name,
        seed=seed,
        flights=flights,
        gyro_noise=NumberWithUnit(value=_noise_density(after.gains.controller), unit="rad/s/sqrt(Hz)"),
        metrics=list(evidence.metrics),
        lost_after=evidence.lost_after,
        lost_before=evidence.lost_before,
        rollback=None,
        not_restored=subjects.not_restored,
        seconds=stages.seconds,
    )


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
    watcher.on_stage(JUDGING, len(setups[0].draws[1]) * len(setups))
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


def gather_evidence(subjects: Subjects, loops: Sequence[LoopSet], paired: PairedScores) -> Evidence:
    """Return the evidence from margins and flights; loops: of the file, then of the one before."""
    channels = AXES if subjects.source in HAS_POSITION_LOOPS else ATTITUDE_AXES
    later, earlier = loops[0], loops[1] if len(loops) > 1 else None
    metrics, lost = paired.rows, paired.lost
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
        lost_after=lost[0],
        lost_before=lost[1] if len(lost) > 1 else None,
        loss=paired.loss,
        unmodeled=len(subjects.unmodeled_changes),
    )


def flight_setups(subjects: Subjects, flights: int, seed: int) -> list[FlightSetup]:
    """Return the flights of both files, the later one first."""
    controllers = [one.gains.controller for one in (subjects.after, subjects.before) if one is not None]
    periods = {controller.control_period for controller in controllers}
    if len(periods) > 1:
        given = " and ".join(f"{1.0 / period:g} Hz" for period in sorted(periods, reverse=True))
        message = (
            f"its loops run at another rate than those before ({given}); air is the same for both at one rate only"
        )
        raise InputError(message, file=subjects.after.path)
    setups = [quadrotor_setup(controller, None, 0, seed) for controller in controllers]
    spec = first_flight(controllers[-1])
    wanted = [FAILURE, "rms.tilt", NOISE, *([POSITION] if subjects.source in HAS_POSITION_LOOPS else [])]
    return [
        replace(
            setup,
            spec=spec,
            metrics=[parse(name, setup.system.axes) for name in wanted],
            draws=(STREAM, range(flights)),
        )
        for setup in setups
    ]


def first_flight(controller: Controller) -> ScenarioSpec:
    """Return a first flight: small steps in a light breeze, with the gyro's noise."""
    uncertainty = controller.airframe.uncertainty
    rate = _noise_density(controller) * sqrt(0.5 / controller.control_period)
    return replace(
        FIRST_FLIGHT,
        sensors=SensorSpec(rate=rate),
        spread=Spread() if uncertainty else SPREAD,
        uncertainty=uncertainty,
    )


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


def _noise_density(controller: Controller) -> float:
    """Return the density of the gyro's noise [rad/s/sqrt(Hz)]."""
    return controller.airframe.gyro_noise or GYRO_NOISE
