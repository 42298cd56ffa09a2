"""README.md and Makefile of the exported C."""

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
