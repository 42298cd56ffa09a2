"""Exported controllers compiled into one shared library, each under a prefix of its own, and run from NumPy rows."""

import ctypes
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plant.backends.c_code import REALS
from plant.quadrotor.gains import gain_addresses
from plant.records import size
from plant.seeds import generator
from tests.clients import program
from tests.tuner.exchange.controllers import controller
from tuner.exchange.c99.entries import AttitudeApplied, AttitudeMeasurement, AttitudeSetpoint, entries
from tuner.exchange.c99.quadrotor import c_sources

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno")
# Bits are those of any level: bundles are compiled by the flags above, a library of all laws for less time.
FAST = tuple("-O1" if flag == "-O2" else flag for flag in FLAGS)
STRICT = ("-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Werror")
# Members of inputs and outputs: reference and measurement; rotor thrusts, thrust and torque.
STEP_IN, STEP_OUT = 14 + 18, 8
ATTITUDE_IN = size(AttitudeSetpoint) + size(AttitudeMeasurement) + size(AttitudeApplied)
DRIVER = """
#include <string.h>
#include "{p}_controller.c"
int {p}_run(unsigned n, const {p}_real *start, const {p}_real (*in)[32], {p}_real (*out)[8], {p}_real *kept, int *status)
{{
    {p}_state state;
    unsigned k;
    memset(&state, 0, sizeof state);
    if ({p}_init(&state, (const {p}_measurement *)start) != {P}_OK)
        return 1;
    for (k = 0; k < n; ++k) {{
        status[k] = (int){p}_step(&state, (const {p}_reference *)in[k], (const {p}_measurement *)(in[k] + 14), ({p}_command *)out[k]);
        memcpy(kept + k * (sizeof state / sizeof *kept), &state, sizeof state);
    }}
    return 0;
}}
int {p}_attitude_run(unsigned n, const {p}_real *start, const {p}_real (*in)[16], {p}_real (*out)[3], {p}_real *kept, int *status)
{{
    {p}_attitude_state state;
    unsigned k;
    memset(&state, 0, sizeof state);
    if ({p}_attitude_init(&state, (const {p}_attitude_measurement *)start) != {P}_OK)
        return 1;
    for (k = 0; k < n; ++k) {{
        status[k] = (int){p}_attitude_step(&state, (const {p}_attitude_setpoint *)in[k],
            (const {p}_attitude_measurement *)(in[k] + 4), (const {p}_attitude_applied *)(in[k] + 10), ({p}_vec3 *)out[k]);
        memcpy(kept + k * (sizeof state / sizeof *kept), &state, sizeof state);
    }}
    return 0;
}}
int {p}_measured(const {p}_real *in, {p}_real *out)
{{
    return (int){p}_measure((const {p}_vec3 *)in, (const {p}_vec3 *)(in + 3), (const {p}_quaternion *)(in + 6),
        (const {p}_vec3 *)(in + 10), ({p}_measurement *)out);
}}
"""


@dataclass(frozen=True)
class Run:
    """Status of each step, outputs, and the states after it, with the stored output last."""

    refused: bool
    status: np.ndarray
    outputs: np.ndarray
    states: np.ndarray


@dataclass(frozen=True)
class Compiled:
    """One controller of a library."""

    library: ctypes.CDLL
    prefix: str
    real: str
    states: int
    attitude_states: int

    def step(self, start, inputs) -> Run:
        """Init at a measurement, then steps with rows of reference and measurement."""
        return self._run(f"{self.prefix}_run", start, inputs, STEP_OUT, self.states + STEP_OUT)

    def attitude_step(self, start, inputs) -> Run:
        """Init at angles and rate, then steps with rows of setpoint, measurement, applied."""
        return self._run(f"{self.prefix}_attitude_run", start, inputs, 3, self.attitude_states + 3)

    def measure(self, row):
        """Status, and the measurement of a row of position, velocity, quaternion, rate."""
        given, found = self._held(row), np.full(18, 7.0, dtype=self.dtype)
        status = getattr(self.library, f"{self.prefix}_measured")(_at(given), _at(found))
        return status, found

    @property
    def dtype(self):
        """NumPy's name for the type of all numbers."""
        return REALS[self.real].dtype

    def _held(self, rows):
        return np.ascontiguousarray(rows, dtype=self.dtype)

    def _run(self, name, start, inputs, width, kept):
        start, inputs = self._held(start), self._held(inputs)
        n = len(inputs)
        outputs, states, status = (
            np.zeros((n, width), self.dtype),
            np.zeros((n, kept), self.dtype),
            np.zeros(n, np.int32),
        )
        refused = getattr(self.library, name)(n, _at(start), _at(inputs), _at(outputs), _at(states), _at(status))
        return Run(bool(refused), status, outputs, states)


def _at(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def build(folder: Path, cases: dict[str, tuple], flags=FAST) -> dict[str, Compiled]:
    """Compile controllers, cases: prefix -> (controller, real), in one call of gcc."""
    target, names = folder / "controllers.so", []
    for prefix, (given, real) in cases.items():
        code = c_sources(given, real, prefix)
        (folder / f"{code.name}.h").write_text(code.header)
        (folder / f"{code.name}.c").write_text(code.source)
        (folder / f"{prefix}_driver.c").write_text(DRIVER.format(p=prefix, P=prefix.upper()))
        # Its driver includes the source: half as many calls of the compiler.
        names.append(f"{prefix}_driver.c")
    subprocess.run(
        [program("gcc"), *flags, "-shared", "-fPIC", *names, "-o", target.name, "-lm"], cwd=folder, check=True
    )
    return loaded(folder, cases)


def loaded(folder: Path, cases: dict[str, tuple]) -> dict[str, Compiled]:
    """Return the controllers of a library that `build` has left in a folder."""
    library, found = ctypes.CDLL(str(folder / "controllers.so")), {}
    for prefix, (given, real) in cases.items():
        bound = entries(given.cascade)
        found[prefix] = Compiled(library, prefix, real, size(bound.State), size(bound.AttitudeState))
    return found


def uneven(position, attitude, **options):
    """A controller of these laws whose gains differ from axis to axis by up to 20 %, inside their ranges."""
    plain = controller(position, attitude, **options)
    rng = generator(3, f"tests/c99/{position}/{attitude}", 0)
    changed = {}
    for gain in gain_addresses(plain.cascade):
        span = gain.span
        value = plain.gains[gain.column] * (1.0 + 0.2 * rng.uniform(-1.0, 1.0))
        changed[gain.address.replace(".", "__")] = min(max(value, span.low), span.high)
    return controller(position, attitude, **options, **changed)
