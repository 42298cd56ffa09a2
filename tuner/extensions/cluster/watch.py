"""Checks of the cluster while results are awaited, and errors without it."""

import time
from concurrent.futures import CancelledError
from typing import Any

from distributed import Client, Future, KilledWorker

from plant.errors import InputError

# Seconds between two looks at the cluster, and without a worker after which it is given up.
LOOK, PATIENCE = 2.0, 60.0
RESUME = "what was written is kept: go on with `tuner resume RESULTS --dask ADDRESS`, or without --dask on this machine alone"


class Watch:
    """Looks after the workers of a client's scheduler. patience: seconds that it may be without any."""

    def __init__(self, client: Client, patience: float = PATIENCE) -> None:
        self._client, self._patience = client, patience
        self._threads = 1
        self._looked = -LOOK
        self._seen = time.monotonic()

    @property
    def threads(self) -> int:
        """Number of threads of all workers, at least one; counted not long ago."""
        if time.monotonic() - self._looked > LOOK:
            self.look()
        return self._threads

    def look(self) -> None:
        """Count threads; InputError where the scheduler is gone, or where it has been without workers for too long."""
        try:
            workers: dict[str, int] = self._client.nthreads()  # pyright: ignore[reportAssignmentType]
        except (OSError, CancelledError, RuntimeError):
            raise self.gone() from None
        self._looked = time.monotonic()
        self._threads = max(sum(workers.values()), 1)
        if workers:
            self._seen = self._looked
        elif self._looked - self._seen > self._patience:
            raise InputError(
                f"the cluster has had no worker for {self._patience:g} s; start workers, for {RESUME}", key="--dask"
            )

    def gone(self) -> InputError:
        """Return the error where the scheduler does not answer."""
        return InputError(f"the scheduler does not answer any more; start it again, for {RESUME}", key="--dask")

    def result(self, future: Future) -> Any:
        """Return a task's result, however long that takes; InputError where it ended its workers or none is left."""
        while True:
            try:
                return future.result(timeout=5.0 * LOOK)
            except TimeoutError:
                self.look()
            except KilledWorker as error:
                raise InputError(
                    f"{error.allowed_failures + 1} workers ended while they flew the same block, the last one "
                    f"{getattr(error.last_worker, 'address', error.last_worker)}; look in their logs (for want of memory "
                    f"give them more, or fewer threads), for {RESUME}",
                    key="--dask",
                ) from None
            except (OSError, CancelledError):
                raise self.gone() from None
