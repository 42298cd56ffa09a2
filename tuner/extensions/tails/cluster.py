"""Replicas of tails on workers of a Dask cluster, each a task."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from distributed import Client

from objectives.flown_system import FlightBatch, FlownSystem, OnFlightsDone, Scenario
from tuner.extensions.cluster.brief import brief_of
from tuner.extensions.cluster.watch import Watch
from tuner.extensions.cluster.worker import BriefPlugin, desk_of
from tuner.extensions.tails.estimation.estimate import LocalReplicas
from tuner.extensions.tails.estimation.limit_function import Replica
from tuner.extensions.tails.estimation.planning import Plan
from tuner.extensions.tails.events import Event, read_event
from tuner.extensions.tails.flight_limit import FlightLimit

STREAM = "tail"
SHARES = 2
"""Replicas under way for each thread."""


@dataclass(frozen=True)
class ReplicaTask:
    """All that replicas need but plan and number.

    Attributes:
        key: Key of the brief that workers have.
        event: Event as written.
        gains: A row (g,).
        seed: Root seed.
    """

    key: str
    event: str
    gains: np.ndarray
    seed: int

    def run(self, plan: Plan, number: int) -> Replica:
        """Return a replica; on a worker, in one thread."""
        desk = desk_of(self.key)
        spec = desk.brief.spec
        limit = FlightLimit(read_event(self.event, desk.system, spec), spec, self.gains, 1, lambda _: None)
        [replica] = LocalReplicas(limit, self.seed).run(plan, [number])
        return replica


class ClusterReplicas:
    """Replicas of an event on all threads of a scheduler's workers.

    Args:
        client: Client of the scheduler.
        system: System as given: workers add what the event meters.
        event: Event whose tail is estimated.
        spec: Scenario.
        gains: A row (g,).
        seed: Root seed.
        on_flights_done: Called with the flights of each replica.
    """

    def __init__(
        self,
        client: Client,
        system: FlownSystem,
        event: Event,
        spec: Scenario,
        gains: np.ndarray,
        seed: int,
        on_flights_done: OnFlightsDone,
    ) -> None:
        brief = brief_of(system, seed, FlightBatch(spec, STREAM, 1))
        client.register_plugin(BriefPlugin(brief))
        self._client, self._watch, self._on_flights_done = client, Watch(client), on_flights_done
        self._task = ReplicaTask(brief.key, event.text, gains, seed)

    def at_once(self, plan: Plan) -> int:  # noqa: ARG002
        """Return the number of replicas that keep all threads busy."""
        return SHARES * self._watch.threads

    def run(self, plan: Plan, numbers: Sequence[int]) -> list[Replica]:
        """Return the replicas of some numbers, in their order."""
        # Failures, vectors of some 300 kB each, are for design points alone.
        sent = replace(plan, failures={})
        futures = [self._client.submit(self._task.run, sent, number, pure=False) for number in numbers]
        replicas = []
        for future in futures:
            replicas.append(self._watch.result(future))
            self._on_flights_done(replicas[-1].evaluations)
        return replicas
