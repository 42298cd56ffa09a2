"""Stability margins of exactly the sampled loop that flies, in batches.

    model = MarginModel(system.cascade, system.nominal, system.timing, system.vehicle)      # hover in still air; 0.3 s
    margins = model.evaluate(gains)                       # gains rows (n, g); about 0.8 ms a candidate
    values = model.limited(gains, requirements)           # (n, requirements), nothing else worked out; about 0.4 ms
    margins.phase.value                                   # (n, 6) [rad], channels x, y, z, roll, pitch, yaw
    margins.phase.frequency, margins.phase.case           # where it is met [rad/s], and at which of margins.cases
    margins.sensitivity.value, margins.gain_up.value      # Ms [1]; factor by which the gain may rise [1]
    margins.stable, margins.growth                        # (n, 6); rate of the slowest decay, above 0 where unstable [1/s]
    margins.multiloop.value                               # (n,) disk margin in z, roll, pitch and yaw at once
    margins.disk_range, margins.delay_periods             # what the disk guarantees; delay margin in control periods

    response = model.loop(gains[0], "roll", Case(0.1))    # loop, s and t over frequency, for plots
    limit_cycles(model, gains[0])                         # amplitude and frequency, or ()

    MarginModel(..., trim=Trim(wind=Vec3(5.0, 0.0, 0.0)))                         # in wind; Trim(hold=False): attitude mode
    MarginModel(..., others=spread_corners(vehicle, Spread(mass=0.1, lag=0.2)))   # the worst of a spread of vehicles
    MarginModel(..., cases=(Case(0.05), Case(0.5)))                               # other amplitudes of nonlinear terms

Break points. A signal v is added at the plant input of z [m/s2], roll, pitch and yaw [N m], behind the controller's model of its
command, and to the demands of the position loops of x and y [m/s2]. With T from v to the command c all other loops stay
closed: S = 1 + T, L = -T/(1 + T).

Conventions. Gain margins are factors of 1 or more, up and down. An unstable loop has factors 1, angles, delays and disks 0,
infinite peaks; a margin that no crossing limits is infinite, its frequency 0. A channel whose block is unstable is unstable.
Never NaN.

Amplitude. Laws whose terms depend on amplitude are judged at several (`describing.Case`): vanishing signals, a few amplitudes
with the describing function of each term, and the steepest slope. All terms take the same amplitude at once, each in the unit of
its own signal. A term with an infinite slope at rest, like a sign, has no margin for vanishing signals: it chatters, and
`limit_cycle` says how much.

How it is built, in the order of the work:

    injection, derivative, period    one control period as CasADi functions, with signals added and read
    trim, linearise, slow_position   trims by Newton's method, and the linear loop about them, period by period
    plant_period                     the same of a plant about its rest
    describing                       gains that represent nonlinear terms
    structure, assembly              the loop falls into blocks: x with pitch, y with roll, z, yaw at hover
    schur, frequency, curve          poles and residues; the curve T(e^jwh) sampled, crossed and refined
    classical, rejection, disk, multiloop, tracking    margins from these
    lifting, multirate, loci         loops of several rates as one of a single rate, and margins from its loci
    block, sheet, results, loop_margins    all of it for a batch, and the worst of it
    margins, plant_margins           quadrotors and plants, as `loop_margins` reads them
"""
