"""`python -m benchmarks.roofline`: floating-point operations per second of the lanes against the roofs of the machine.

Roofs: multiply-adds (a small C kernel) and memory (stream triad), one core, by processor time. S. Williams, A. Waterman,
D. Patterson, Roofline, Communications of the ACM 52(4), 2009. Operations are counted exactly from the model
(`benchmarks.counting`).
"""

import ctypes
import subprocess
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import thread_time
from typing import Any

import numpy as np

from benchmarks.counting import count, operations
from benchmarks.course import SUBSTEPS, Course, draw
from benchmarks.measuring import RESULTS, machine, spent, write_json
from benchmarks.peers import ceiling, lanes

SOURCE = Path(__file__).with_suffix(".c")
FLAGS = "-O3 -march=native -ffp-contract=fast -shared -fPIC".split()
ROUNDS, BATCH, PERIODS = 5, 256, 1000
FMA_ROUNDS, TRIAD_LENGTH = 20_000_000, 8_000_000
"""One pass of the triad moves 192 MB, several times any last-level cache."""


def library(folder: Path) -> ctypes.CDLL:
    """Compile the two roofs."""
    compiler = ceiling.compiler()
    if compiler is None:
        raise SystemExit("no C compiler found (clang or gcc)")
    file = folder / "roofline.so"
    subprocess.run([compiler, *FLAGS, str(SOURCE), "-o", str(file)], check=True, capture_output=True)
    found = ctypes.CDLL(str(file))
    found.multiply_adds.argtypes = [ctypes.c_long, ctypes.c_double, ctypes.POINTER(ctypes.c_double)]
    found.multiply_adds.restype = ctypes.c_double
    found.triad.argtypes = [ceiling.POINTER] * 3 + [ctypes.c_double, ctypes.c_size_t]
    return found


def peak(roofs: ctypes.CDLL) -> float:
    """Return multiply-add operations per second of one core [1/s], two a multiply-add."""
    total, begin = ctypes.c_double(), thread_time()
    done = roofs.multiply_adds(FMA_ROUNDS, 0.5, ctypes.byref(total))
    return done / (thread_time() - begin)


def bandwidth(roofs: ctypes.CDLL, arrays: list[np.ndarray]) -> float:
    """Return bytes per second of the triad on one core [B/s]."""
    pointers, begin = [array.ctypes.data_as(ceiling.POINTER) for array in arrays], thread_time()
    roofs.triad(*pointers, 0.5, TRIAD_LENGTH)
    return 3 * 8 * TRIAD_LENGTH / (thread_time() - begin)


def measure(course: Course) -> dict[str, Any]:
    """Return counts, roofs and what the lanes and the C loop achieve, per core."""
    counts = count(course)
    period = operations(counts["control step"]) + SUBSTEPS * operations(counts["plant step"])
    moved = 8 * (course.winds.shape[1] + course.noises.shape[1])
    with TemporaryDirectory() as folder:
        scratch = Path(folder)
        roofs = library(scratch)
        arrays = [np.ones(TRIAD_LENGTH) for _ in range(3)]
        works = {
            "lanes": lanes.prepare(course, BATCH, PERIODS, 1, scratch),
            "C": ceiling.prepare(course, BATCH, PERIODS, 1, scratch),
        }
        rounds = []
        for _ in range(ROUNDS):
            rates = {name: period * BATCH * PERIODS / spent(work).busy for name, work in works.items()}
            rounds.append(rates | {"peak": peak(roofs), "bandwidth": bandwidth(roofs, arrays)})
    values = {name: median(entry[name] for entry in rounds) for name in rounds[0]}
    return {
        "machine": machine(),
        "counts": counts,
        "operations": {name: operations(kinds) for name, kinds in counts.items()} | {"control period": period},
        "bytes_per_period": moved,
        "intensity": period / moved,
        **{f"{name}_per_s": value for name, value in values.items()},
        "share_of_peak": {name: median(entry[name] / entry["peak"] for entry in rounds) for name in works},
    }


def draw_figure(found: dict[str, Any], file: Path) -> None:
    """Draw the roofs and the two loops under them."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    peak_rate, flow, at = found["peak_per_s"] / 1e9, found["bandwidth_per_s"] / 1e9, found["intensity"]
    x = np.logspace(-1, 3, 200)
    figure, axes = pyplot.subplots(figsize=(7.0, 4.6), layout="constrained")
    axes.loglog(x, np.minimum(peak_rate, flow * x), color="#222222", linewidth=2)
    axes.loglog(x, np.minimum(0.5 * peak_rate, flow * x), color="#222222", linewidth=1, linestyle="--")
    axes.text(0.4, 0.22 * flow, f"memory, triad: {flow:.0f} GB/s", fontsize=9, va="center")
    axes.text(900.0, 1.08 * peak_rate, f"multiply-add peak: {peak_rate:.0f} Gop/s", fontsize=9, va="bottom", ha="right")
    axes.text(900.0, 0.54 * peak_rate, "adds and multiplications that do not fuse", fontsize=9, va="bottom", ha="right")
    marks = (("lanes", "o", "#0b6e99", -5), ("C", "s", "#b3541e", 2))
    for name, marker, colour, shift in marks:
        rate = found[f"{name}_per_s"] / 1e9
        label = f"{name}: {rate:.1f} Gop/s, {100 * found['share_of_peak'][name]:.0f} % of peak"
        axes.plot(at, rate, marker, color=colour, markersize=7)
        axes.annotate(
            label, (at, rate), xytext=(8, shift), textcoords="offset points", fontsize=9, color=colour, va="center"
        )
    axes.set(
        xlabel="operations per byte of wind and noise read [1/B]",
        ylabel="operations per second, one core [Gop/s]",
        xlim=(0.1, 1000),
        ylim=(0.3, 3 * peak_rate),
        title="Closed loop under the roofs of one core",
    )
    axes.grid(True, which="major", color="#dddddd")
    figure.savefig(file, dpi=130)
    pyplot.close(figure)


def main() -> None:
    """Measure, write roofline.json and roofline.png."""
    found = measure(draw())
    write_json(RESULTS / "roofline.json", found)
    draw_figure(found, RESULTS / "roofline.png")
    print(found["operations"], found["share_of_peak"])


if __name__ == "__main__":
    main()
