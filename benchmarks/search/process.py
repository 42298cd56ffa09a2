"""A peer as the race sees it: a search whose work is done in another process."""

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.peers.environments import ROOT, python_of, worker_environment
from benchmarks.search.peer import Peer, Start

ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


class PeerFailed(Exception):
    """A peer ended, or said why it cannot go on."""


class PeerProcess:
    """A peer's process as a `Search`; use it as a context. seconds: processor time that it took so far, imports left out."""

    def __init__(self, peer: Peer, start: Start, envs: Path) -> None:
        self.seconds = 0.0
        self._excess = start.excess
        self._process = subprocess.Popen(
            [python_of(peer.environment, peer.requires, envs), "-m", "benchmarks.search.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            cwd=ROOT,
            env=worker_environment() | ONE_THREAD | {"PYTHONHASHSEED": "0"},
        )
        self._request(
            {
                "begin": {
                    "module": peer.module,
                    "options": peer.options,
                    "first": start.first.tolist(),
                    "batch": start.batch,
                    "objectives": start.objectives,
                    "limits": start.limits,
                    "seed": start.seed,
                }
            }
        )

    def __enter__(self) -> "PeerProcess":
        return self

    def __exit__(self, *error: object) -> None:
        self._process.kill()
        self._process.communicate()

    def ask(self) -> np.ndarray:
        """Return the next batch (n, d)."""
        return np.array(self._request({"ask": True})["points"])

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Tell objectives (n, m) and violations (n, c) of the batch asked for."""
        self._request({"tell": {"values": values.tolist(), "violations": violations.tolist()}})

    def _request(self, request: dict[str, Any]) -> dict[str, Any]:
        """Return the answer to a request; questions about what is known are answered on the way."""
        answer = self._exchange(request)
        while "excess" in answer:
            answer = self._exchange(self._excess(np.array(answer["excess"])).tolist())
        if "error" in answer:
            raise PeerFailed(answer["error"])
        self.seconds = answer["seconds"]
        return answer

    def _exchange(self, message: Any) -> dict[str, Any]:
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps(message) + os.linesep)
            self._process.stdin.flush()
            return json.loads(self._process.stdout.readline() or '{"error": "the process ended"}')
        except BrokenPipeError:
            return {"error": "the process ended"}
