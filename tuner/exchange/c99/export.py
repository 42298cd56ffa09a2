"""The C99 bundle: controller, golden vectors, the program that compares them, Makefile and README."""

from dataclasses import replace

import numpy as np

from plant.backends.c_code import REALS, Real
from tuner.exchange.aboard import rollback_request
from tuner.exchange.c99.golden import golden
from tuner.exchange.c99.golden_text import golden_header, golden_program
from tuner.exchange.c99.sources import c_sources
from tuner.exchange.target import Bundle, Option, Request, Target
from tuner.exchange.texts import c_comment, markdown, tool
from tuner.gains import Controller

MAKEFILE = """\
# Written by {tool}. make test: the golden vectors on this machine; make arm: an object for a Cortex-M4F.
CFLAGS = -std=c99 -O2 -ffp-contract=off -fno-math-errno -Wall -Wextra
ARM_CC = arm-none-eabi-gcc
ARM_CPU = -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16

test: test_golden
	./test_golden

test_golden: test_golden.c {p}_controller.c {p}_controller.h golden.h
	$(CC) $(CFLAGS) -o $@ test_golden.c {p}_controller.c -lm

arm: {p}_controller.arm.o

{p}_controller.arm.o: {p}_controller.c {p}_controller.h
	$(ARM_CC) $(ARM_CPU) $(CFLAGS) -c -o $@ {p}_controller.c

clean:
	rm -f test_golden {p}_controller.arm.o

.PHONY: test arm clean
"""

README = """\
# Flight controller for {title}, in C99

{sentence}

| | |
|---|---|
| airframe | {airframe}, mass {mass} kg |
| laws | position {position}, attitude {attitude} |
| period | {period} s |
| numbers | {real} |
| gains | sha256 {digest} |
| written by | {tool} |

## Files

- `{p}_controller.h`, `{p}_controller.c`: the controller. The header says what every number means.
- `golden.h`, `test_golden.c`: {steps} steps of the whole cascade and {attitude_steps} of the attitude loops alone,
  with inputs, outputs and states; `make test` holds the compiler's work against them bit for bit.
- `Makefile`: `make test` on this machine, `make arm` for a Cortex-M4F.

## Use

    static {p}_state state;                     /* yours, as many as you fly */

    {p}_measure(&position, &velocity, &quaternion, &gyro, &m);
    {p}_init(&state, &m);                       /* when the loops are closed, and after every pause */
    ...
    {p}_measure(&position, &velocity, &quaternion, &gyro, &m);
    {p}_step(&state, &reference, &m, &command); /* once every {period} s */

`{p}_attitude_init` and `{p}_attitude_step` are the three attitude loops alone, from angles to torque.

**Frames and units.** World x east, y north, z up; body x forward, y left, z up. Quaternion scalar first, body into
world. Angles roll, pitch, yaw in rad, positive pitch is nose down. m, s, rad, N, N m. From north-east-down and
forward-right-down: swap x and y of the world and turn the sign of z; turn the signs of y and z of the body.

**Period.** All constants hold for {period} s. If you step at another period h the controller does not notice:
integrals and observers then run {period}/h times as fast as they should, and poles move. A late step now and then does
little; another rate needs another export.

**What is refused.** If anything that goes in is infinite or NaN, or so large that a result or a sum overflows, the
call returns `{P}_REFUSED`, leaves the state as it was and gives the last good output again, that of hover right
after an init. So the state stays finite whatever comes in. How many refusals in a row you bear is yours to decide.

**Compute delay.** {delay}

## Flags

`-ffp-contract=off` keeps the compiler from joining multiply and add, which rounds once instead of twice: without it
a Cortex-M4F gives other last bits than the golden vectors, though no worse control. `-fno-math-errno` turns sqrt
into one instruction. Never use `-ffast-math`: it deletes the check for NaN. Nothing is linked but sqrt, fabs and
memcpy; no global is written, no heap is used.

## Into a flight stack

- **PX4**, external module (`EXTERNAL_MODULES_LOCATION`): step every {period} s on the estimator's newest output,
  converted from NED and FRD. Divide thrust and torque by what the control allocator takes as 1, and publish them as
  thrust and torque setpoints in place of the rate controller's.
- **ArduPilot**, custom controller (`AC_CustomControl`): call the attitude loops in `update()`, feed them with angles,
  gyro and the torque that the motors last took, and return torque over the full torque of each axis.
- **Crazyflie**, out-of-tree controller: in `controllerOutOfTree` step every {period} s, set `controlModeForceTorque`
  and write `thrustSi`, `torqueX`, `torqueY`, `torqueZ`, which are SI. `tuner export --to crazyflie` writes that wrapper.
"""
DELAYED = """\
These gains were tuned with a compute delay of one period, and the delay is in this code: a command
comes out one step after it was decided, as in the simulation. If your own loop is that late by itself, put
`state.pending` in force in place of the command."""
PROMPT = """\
None is in this code: these gains were tuned for a command that acts in the period it is decided in."""


PREFIX = "holdfast"


def export(request: Request) -> Bundle:
    """Write the bundle, and that of the gains to go back to."""
    back, sentence = rollback_request(request)
    real = REALS[request.settings["real"]]
    return Bundle(
        files(request, "These gains were tuned by holdfast."),
        files(back, sentence),
        held(request.controller, real),
        LOSSY[real.name],
        "C99",
    )


LOSSY = {
    "float": (
        "Every number is a float: constants are worked out in double precision and rounded once, to 6e-8 of their size, and "
        "every operation rounds to as much; far from the origin, positions are then known to 6e-8 of their size.",
    ),
    "double": (
        "Every number is a double, as in the simulator; a Cortex-M4F works these out in software, in some fifty times as many "
        "instructions.",
    ),
}


def held(controller: Controller, real: Real) -> Controller:
    """Return the controller whose gains are the numbers of that type nearest to the given ones."""
    return replace(controller, gains=tuple(float(real.dtype(gain)) for gain in np.array(controller.gains).tolist()))


def files(request: Request, sentence: str) -> dict[str, bytes]:
    """Write the files for a controller; sentence: what its gains are."""
    controller, real = request.controller, REALS[request.settings["real"]]
    code = c_sources(controller, real.name, PREFIX, request.digest)
    vectors = golden(controller, real)
    position, attitude = controller.cascade.position.name, controller.cascade.attitude.name
    words = {
        "p": PREFIX, "P": PREFIX.upper(), "digest": c_comment(request.digest), "airframe": c_comment(controller.airframe.name),
        "laws": f"position {position}, attitude {attitude}", "tool": tool(),
    }  # fmt: skip
    readme = README.format(
        **words | {"digest": markdown(request.digest), "airframe": markdown(controller.airframe.name)},
        title=markdown(controller.airframe.title),
        sentence=markdown(sentence),
        mass=f"{controller.airframe.vehicle.mass:g}",
        position=position,
        attitude=attitude,
        period=f"{controller.control_period:g}",
        real=real.name,
        steps=len(vectors.step.inputs),
        attitude_steps=len(vectors.attitude_step.inputs),
        delay=DELAYED if controller.options.delay else PROMPT,
    )
    texts = {
        f"{code.name}.h": code.header,
        f"{code.name}.c": code.source,
        "golden.h": golden_header(vectors, real, words),
        "test_golden.c": golden_program(real, words),
        "Makefile": MAKEFILE.format(**words),
        "README.md": readme,
    }
    return {name: text.encode() for name, text in texts.items()}


TARGET = Target(
    "c99",
    "C99 source with golden vectors, for any firmware",
    export,
    options=(Option("real", "type of all numbers", ("float", "double"), "float"),),
)
