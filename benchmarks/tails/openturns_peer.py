"""Estimates of OpenTURNS, run in an environment of its own: `python openturns_peer.py ALGORITHM REPEATS PROBABILITY JUDGE`.

Prints JSON: for each seed the estimate, the ends of its 95 % interval, and the evaluations. Settings are OpenTURNS's own, but for
the number of states of a step: `STEP`.
"""

import json
import sys

import openturns as ot

from benchmarks.tails.judges import Judge, judges

STEP = {"SubsetSampling": 10_000, "NAIS": 1_000}


def estimate(algorithm: str, judge: Judge, seed: int) -> tuple[float, float, float, int]:
    """Return the estimate, the ends of its interval, and the evaluations."""
    import numpy as np

    rows = 0

    def evaluate(sample: ot.Sample) -> list[list[float]]:
        nonlocal rows
        normals = np.array(sample)
        rows += len(normals)
        return judge.values(normals).tolist()

    ot.RandomGenerator.SetSeed(seed + 1)
    function = ot.PythonFunction(judge.dimension, 1, func_sample=evaluate)
    vector = ot.RandomVector(ot.Normal(judge.dimension))
    event = ot.ThresholdEvent(ot.CompositeRandomVector(function, vector), ot.GreaterOrEqual(), 1.0)
    if algorithm == "SubsetSampling":
        run = ot.SubsetSampling(event)
        run.setMaximumOuterSampling(STEP[algorithm] // 100)
        run.setBlockSize(100)
    else:
        run = ot.NAIS(event)
        run.setMaximumOuterSampling(1)
        run.setBlockSize(STEP[algorithm])
    run.run()
    result = run.getResult()
    center, half = result.getProbabilityEstimate(), 0.5 * result.getConfidenceLength(0.95)
    return center, center - half, center + half, rows


def main() -> None:
    """Print the estimates of all seeds."""
    algorithm, repeats, probability, name = sys.argv[1:]
    judge = judges(float(probability))[name]
    print(json.dumps([estimate(algorithm, judge, seed) for seed in range(int(repeats))]))


if __name__ == "__main__":
    main()
