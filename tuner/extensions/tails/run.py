"""Estimates of the tails of events under several gains."""

import json
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from math import exp, log, sqrt
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from objectives.flown_system import FlownSystem, Scenario
from plant.errors import StoreError, UnknownNameError
from plant.seeds import generator
from tuner.documents.parts import SampledValue
from tuner.documents.tail import TailEvent, TailPoint
from tuner.extensions.cluster.connect import client_at
from tuner.extensions.cluster.own_files import own_files_of
from tuner.extensions.step_records.key_inputs import DIGEST, Inputs
from tuner.extensions.step_records.keyed_folder import StepState
from tuner.extensions.tails.document import TAIL_FORMAT, TAIL_VERSION, TailDocument, TailGains, TailRatio
from tuner.extensions.tails.estimation.design_point import find_design_point, search_evaluations
from tuner.extensions.tails.estimation.estimate import ReplicaRunner, estimate_tail
from tuner.extensions.tails.estimation.intervals import FIRST
from tuner.extensions.tails.estimation.limit_function import Method, Progress, TailEstimate
from tuner.extensions.tails.estimation.planning import Plan, Request, choose_method, expected_evaluations, plan_tail
from tuner.extensions.tails.estimation.splitting import replica_evaluations
from tuner.extensions.tails.events import Event, read_event
from tuner.extensions.tails.flight_limit import FlightLimit, space_of
from tuner.extensions.tails.record import DOCUMENT, POINT_SUFFIX, TAIL, Record, point_bytes
from tuner.extensions.tails.tail_event import tail_event
from tuner.extensions.tails.time_bins import TimeBins
from tuner.search.watcher import Watcher, compilation
from tuner.store.folder import Folder
from tuner.store.manifest import digest_of
from tuner.text.numbers import count as number_text
from tuner.text.numbers import duration, significant
from tuner.text.version import version

if TYPE_CHECKING:
    from distributed import Client

STAGE = "Estimating"
FEW_BINS, STEPS = 4, 4
"""Bins and steps of the searches from several failures; from the nearest of their design points that in all bins goes on."""
GRADIENTS = 2
"""Gradients that it usually takes in all bins."""
RARE = 0.2
"""Probability from which on the flight without deviations is about as near as any."""
PILOT = 64
"""Flights by which the speed is measured."""


@dataclass(frozen=True)
class TailSubject:
    """Gains whose tails are estimated.

    Args:
        name: Name of the gains, as given.
        system: System that flies them.
        row: Gains (g,) in the order of the system.
        laws: Control laws in words.
    """

    name: str
    system: FlownSystem
    row: np.ndarray
    laws: str


@dataclass(frozen=True)
class TailSettings:
    """Settings of an estimate.

    Attributes:
        root: Root seed.
        smallest: Smallest probability of interest.
        width: Width of the 95 % interval over the probability.
        most: Flights of an event under one of the gains at most.
        threads: Number of threads, None for one per core.
        worst: Part of a flight whose design point alone is sought, None for all parts.
        dask: Cluster that runs the replicas of splitting, None for this machine.

    """

    root: int
    smallest: float
    width: float
    most: int
    threads: int | None = None
    worst: str | None = None
    dask: str | None = None


class TailRun:
    """The estimates of a call.

    Args:
        gains: The first is compared with.
        events: Events as texts.
        spec: Scenario.
        settings: Settings of all estimates.
        watcher: Callbacks.
        out: Folder of the record, None for none.
    """

    def __init__(
        self,
        gains: Sequence[TailSubject],
        events: Sequence[str],
        spec: Scenario,
        settings: TailSettings,
        watcher: Watcher,
        out: Path | None = None,
    ) -> None:
        self._gains, self._spec, self._settings, self._watcher, self._out = gains, spec, settings, watcher, out
        self._events = [[read_event(text, each.system, spec) for text in events] for each in gains]
        self._points: dict[str, bytes] = {}
        self._client: Client | None = None
        parts = space_of(gains[0].system, spec).parts
        if settings.worst is not None and settings.worst not in parts:
            raise UnknownNameError("part of a flight", settings.worst, parts, key="--worst")

    def carry_out(self) -> TailDocument:
        """Estimate all, write the folder and return the document."""
        with self._cluster() as self._client:
            return self._estimate_all()

    def _estimate_all(self) -> TailDocument:
        record = None if self._out is None else Record.begin(self._out, self._inputs())
        with nullcontext() if record is None else record.folder:
            made = [
                TailGains(
                    gains=each.name,
                    laws=each.laws,
                    events=[self._estimated(number, each, event, record) for event in self._events[number]],
                )
                for number, each in enumerate(self._gains)
            ]
            document = self._document(made)
            if record is not None:
                folder = record.folder.folder
                folder.write_together(self._points)
                folder.write_json(DOCUMENT, document)
                _draw(document, folder)
                record.folder.end(TAIL, StepState.DONE)
        return document

    def _cluster(self) -> AbstractContextManager["Client | None"]:
        """Return the connection to the cluster, None without."""
        if self._settings.dask is None:
            return nullcontext()
        files = {file: None for each in self._gains for file in own_files_of(each.system, [self._spec])}
        return client_at(self._settings.dask, list(files), self._settings.threads, self._watcher.on_message)

    def _runner(self, gains: TailSubject, event: Event) -> ReplicaRunner | None:
        """Return the cluster that runs an event's replicas, None without."""
        if self._client is None:
            return None
        from tuner.extensions.tails.cluster import ClusterReplicas

        watch = self._watcher.on_flights_done
        return ClusterReplicas(self._client, gains.system, event, self._spec, gains.row, self._settings.root, watch)

    def _inputs(self) -> Inputs:
        """Return the inputs that decide the bits of the result."""
        s = self._settings
        options = {"seed": s.root, "to": s.smallest, "width": s.width, "most": s.most, "worst": s.worst}
        flown = json.dumps([each.system.content(self._spec) for each in self._gains], sort_keys=True, default=str)
        gains = {str(i): each.name for i, each in enumerate(self._gains)}
        rows = json.dumps([each.row.tolist() for each in self._gains])
        return {
            "version of the product": {"version": version()},
            "gains": gains | {DIGEST: digest_of(rows.encode())},
            "flights": {"scenario": self._spec.name, DIGEST: digest_of(flown.encode())},
            "events": {str(i): event.text for i, event in enumerate(self._events[0])},
            "options": {name: str(value) for name, value in options.items() if value is not None},
        }

    def _estimated(self, number: int, gains: TailSubject, event: Event, record: Record | None) -> TailEvent:
        settings, watcher = self._settings, self._watcher
        limit = FlightLimit(event, self._spec, gains.row, settings.threads, watcher.on_flights_done)
        rate = self._announce(gains, event, limit)
        request = Request(settings.width, settings.smallest, settings.most)
        plan = plan_tail(limit, settings.root, request)
        self._announce_rest(plan, rate)
        completed = () if record is None else record.completed(number, event.text)
        ladders = len(limit.modes if plan.method is Method.CRUDE else plan.ladders)
        if any((len(each.ladders), len(each.curve)) != (ladders, len(plan.curve)) for each in completed):
            raise StoreError(
                f"{self._out} holds replicas of another version or machine; choose another folder with --out, or remove it"
            )

        def on_progress(progress: Progress) -> None:
            if record is not None:
                record.keep(number, event.text, progress.replica)

        runner = self._runner(gains, event)
        estimate = estimate_tail(limit, settings.root, request, plan, completed, on_progress, runner)
        return tail_event(event, estimate, self._points_of(estimate, limit, plan))

    def _announce(self, gains: TailSubject, event: Event, limit: FlightLimit) -> float:
        """Tell the cost of the estimate and return the flights per second.

        A few flights are timed for it.
        """
        with compilation(self._watcher) if not limit.flyer.cached else nullcontext():
            normals = generator(self._settings.root, "tail/pilot", 0).standard_normal((PILOT, limit.dimension))
            limit.values(normals[:1])
        begin = perf_counter()
        limit.values(normals)
        rate = PILOT / (perf_counter() - begin)
        flights = self._flights(self._settings.smallest)
        self._watcher.on_message(
            f"{event.text} of {gains.name}: about {number_text(flights)} flights if it is as rare as "
            f"{significant(self._settings.smallest, 2)}, {duration(flights / rate)}"
        )
        self._watcher.on_stage(f"{STAGE} {event.text} of {gains.name}", flights)
        return rate

    def _announce_rest(self, plan: Plan, rate: float) -> None:
        if plan.probability > 0.0:
            left = self._flights(plan.probability)
            # Flights of the pilot are no part of a count.
            if plan.method is Method.SPLITTING:
                left = max(left - plan.evaluations, FIRST * replica_evaluations(plan.ladders))
            self._watcher.on_message(
                f"A pilot of {number_text(plan.evaluations)} flights puts it near {plan.probability:.0e}: about "
                f"{number_text(left)} more, {duration(left / rate)}"
            )
            self._watcher.on_stage(STAGE, left)

    def _flights(self, probability: float) -> int:
        """Return the flights that an event takes, to two digits."""
        flights = expected_evaluations(min(probability, 0.5), self._settings.width, choose_method(probability))
        return min(int(float(f"{flights:.2g}")), self._settings.most)

    def _points_of(self, estimate: TailEstimate, limit: FlightLimit, plan: Plan) -> list[TailPoint | None]:
        """Return the design points of all modes; none of an event that is not rare."""
        if estimate.probability >= RARE:
            return []
        return [self._point(limit, mode, plan.failures.get(mode)) for mode in range(len(estimate.modes))]

    def _point(self, limit: FlightLimit, mode: int, failures: np.ndarray | None) -> TailPoint | None:
        """Return the design point nearest to failures.

        Its vector is kept for the folder. None where it takes too many flights.
        """
        if failures is None:
            return None
        space, worst = limit.space, self._settings.worst
        coarse, bins = TimeBins(space, FEW_BINS, worst), TimeBins(space, part=worst)
        flights = len(failures) * search_evaluations(coarse.size, STEPS) + GRADIENTS * bins.size
        if flights > self._settings.most:
            return None
        self._watcher.on_stage(f"Design point by {limit.modes[mode]}", flights)
        near = [find_design_point(limit, mode, coarse, failure, STEPS) for failure in failures]
        start = min((point for point in near if point is not None), key=np.linalg.norm, default=failures[0])
        normals = find_design_point(limit, mode, bins, start)
        if normals is None:
            return None
        name = f"point-{len(self._points) + 1}"
        self._points[name + POINT_SUFFIX] = point_bytes(normals)
        squared = float(normals @ normals)
        shares = {part: float(normals[place] @ normals[place]) / squared for part, place in space.parts.items()}
        numbers = {
            f"{part} {number}": float(value)
            for part, names in limit.names_of_draws.items()
            if part in space.parts
            for number, value in zip(names, normals[space.parts[part]], strict=False)
        }
        return TailPoint(name=name, distance=sqrt(squared), shares=shares, numbers=numbers)

    def _document(self, made: list[TailGains]) -> TailDocument:
        space = space_of(self._gains[0].system, self._spec)
        first, *others = made
        return TailDocument(
            format=TAIL_FORMAT,
            version=TAIL_VERSION,
            scenario=self._spec.name,
            duration=self._spec.duration,
            seed=self._settings.root,
            smallest=self._settings.smallest,
            width=self._settings.width,
            most_flights=self._settings.most,
            worst=self._settings.worst,
            parts={part: place.stop - place.start for part, place in space.parts.items()},
            gains=made,
            ratios=[
                TailRatio(event=event.event, gains=other.gains, first=first.gains, ratio=ratio_of(event, base))
                for other in others
                for event, base in zip(other.events, first.events, strict=True)
            ],
        )


def _draw(document: TailDocument, folder: Folder) -> None:
    """Write the figure; what draws takes half a second to import."""
    from tuner.extensions.tails.figure import write_tail_figure

    write_tail_figure(document, folder.path)


def ratio_of(event: TailEvent, base: TailEvent) -> SampledValue | None:
    """Return the ratio of two probabilities with its interval.

    None where one of the ends is 0. The interval is that of the difference of the logarithms from both intervals (G. Y. Zou,
    A. Donner, "Construction of confidence limits about effect measures", Statistics in Medicine 27(10):1693-1702, 2008), which
    holds for independent estimates; of two on the same seeds it is too wide rather than too narrow.
    """
    if min(event.low, base.low) <= 0.0:
        return None
    value = log(event.probability / base.probability)
    below = sqrt(log(event.probability / event.low) ** 2 + log(base.high / base.probability) ** 2)
    above = sqrt(log(event.high / event.probability) ** 2 + log(base.probability / base.low) ** 2)
    return SampledValue(exp(value), exp(value - below), exp(value + above))
