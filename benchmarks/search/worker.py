"""One peer in a process of its own: a request a line, an answer a line, both JSON.

`python -m benchmarks.search.worker`. Requests are {"begin": ...}, {"ask": true} and {"tell": ...}. Before its answer a peer may
ask what is known of points without flying: a line {"excess": points}, answered by one with the numbers. Every answer has the
processor seconds that the peer took since it began.
"""

import json
import os
import sys
from time import process_time
from typing import Any

import numpy as np

from benchmarks.search.peer import Peer, Search, Start


class Lines:
    """The two ends of the pipe; what libraries print goes to standard error."""

    def __init__(self) -> None:
        self._answers = os.fdopen(os.dup(1), "w")
        os.dup2(2, 1)

    def send(self, answer: dict[str, Any]) -> None:
        """Write an answer."""
        self._answers.write(json.dumps(answer) + "\n")
        self._answers.flush()

    def excess(self, points: np.ndarray) -> np.ndarray:
        """Ask by how much points (n, d) exceed what is known without flying (n, h)."""
        self.send({"excess": points.tolist()})
        return np.array(json.loads(sys.stdin.readline())).reshape(len(points), -1)


def serve(lines: Lines) -> None:
    """Answer requests until there are none."""
    search: Search | None = None
    begin = 0.0
    for line in sys.stdin:
        asked = json.loads(line)
        answer: dict[str, Any] = {}
        try:
            if "begin" in asked:
                search = begun(asked["begin"], lines)
                begin = process_time()
            assert search is not None, "a peer begins first"
            if "ask" in asked:
                answer["points"] = search.ask().tolist()
            if "tell" in asked:
                search.tell(np.array(asked["tell"]["values"]), np.array(asked["tell"]["violations"]))
        except Exception as error:  # noqa: BLE001
            answer = {"error": f"{type(error).__name__}: {error}"[:300]}
        lines.send({**answer, "seconds": process_time() - begin})


def begun(given: dict[str, Any], lines: Lines) -> Search:
    """Return the search that a request asks for."""
    start = Start(
        np.array(given["first"]), given["batch"], given["objectives"], given["limits"], given["seed"], lines.excess
    )
    return Peer(given["module"], given["options"]).begun(start)


if __name__ == "__main__":
    serve(Lines())
