"""The lanes backend: the same bits wherever a flight is flown, the same flight as in plain Python, real vector code."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plant.backends import array
from plant.backends.flyer import Flyer, Recording, result_parts, to_lanes
from plant.backends.lane_layout import LANES, layout, result_rows
from plant.backends.stepping import Inputs, fly_steps, unchanged
from plant.quadrotor.closed_loop import Limits
from plant.quadrotor.rigid_body import Dynamics
from plant.records import flatten, index, pack, size
from plant.status import Status
from tests.plant.loops import LIMITS, NOMINAL, TIMING, flyer, gains, inputs, loop


def flat_lane(blocks, scenario):
    block, lane = divmod(scenario, LANES)
    return Inputs(
        blocks.dynamics[block, :, lane].tolist(),
        blocks.starts[block, :, lane].tolist(),
        blocks.disturbances[block, :, :, lane],
        blocks.noises[block, :, :, lane],
        blocks.references,
    )


@pytest.mark.parametrize(("rates", "rows"), [(False, 3), (True, 12)], ids=["wind alone", "gust rates"])
def test_a_flight_is_the_same_bits_in_any_lane_block_batch_and_thread_count(rates, rows):
    all_of_them = inputs(range(40), angular_rates=rates)
    assert all_of_them.disturbances.shape[2] == rows
    wanted = flyer().fly(gains()[None], NOMINAL, all_of_them)[0]
    for first, count in ((0, 1), (3, 2), (5, 17), (23, 17)):
        part = flyer().fly(gains()[None], NOMINAL, inputs(range(first, first + count), angular_rates=rates))[0]
        assert np.array_equal(part, wanted[first : first + count])
    many = np.tile(gains(), (5, 1))
    many[2, 0] *= 1.5
    for threads in (1, 3):
        batch = flyer(threads).fly(many, NOMINAL, all_of_them)
        assert np.array_equal(batch[0], wanted) and np.array_equal(batch[4], wanted)
        assert not np.array_equal(batch[2], wanted)


def test_a_traced_flight_ends_where_the_untraced_one_does():
    batch = inputs(range(3))
    trace = flyer().trace(gains(), NOMINAL, batch, every=1)
    meters = trace[:, -1, result_rows(loop())]
    assert np.array_equal(meters, flyer().fly(gains()[None], NOMINAL, batch)[0])
    few = flyer().trace(gains(), NOMINAL, batch, every=3, traced=[7, 0])
    assert np.array_equal(few, trace[:, ::3, [7, 0]])


def test_flights_that_are_recorded_on_the_way_are_those_that_are_not():
    batch, many, seen = inputs(range(2 * LANES + 3)), np.stack([gains(), 1.2 * gains()]), {}
    recording = Recording(LANES + 2, [7, 0], 3, lambda row, *found: seen.update({row.tobytes(): found}))
    flown = flyer(2).fly(many, NOMINAL, batch, None, recording)
    assert np.array_equal(flown, flyer(2).fly(many, NOMINAL, batch))
    for row, results in zip(many, flown, strict=True):
        trace, found, references = seen[row.tobytes()]
        assert references is batch.references
        assert np.array_equal(found, results[: LANES + 2])
        assert np.array_equal(trace, flyer().trace(row, NOMINAL, inputs(range(LANES + 2)), 3, [7, 0]))


def test_lanes_fly_what_plain_python_and_numpy_fly():
    # 0.4 s: rounding (2e-16, contracted multiply-adds) grows by the loop's own dynamics only; observed differences stay below
    # 1e-12 of the largest meter, 1e-9 leaves room for other processors. Rise times hang on crossings and are compared too.
    blocks = inputs(range(5))
    record = pack(loop().cascade.Gains, gains().tolist())
    lanes = flyer().fly(gains()[None], NOMINAL, blocks)[0]
    rows = result_rows(loop())
    for scenario in (0, 4):
        flight = fly_steps(
            loop(), unchanged, record, NOMINAL, flat_lane(blocks, scenario), blocks.targets, LIMITS, TIMING
        )
        np.testing.assert_allclose(np.array(flatten(flight))[rows], lanes[scenario], rtol=1e-9, atol=1e-9)
    all_lanes = Inputs(
        blocks.dynamics[0], blocks.starts[0], blocks.disturbances[0], blocks.noises[0], blocks.references
    )
    with np.errstate(all="ignore"):
        flights = fly_steps(loop(), array.rebinder(), record, NOMINAL, all_lanes, blocks.targets, LIMITS, TIMING)
    columns = np.stack([np.broadcast_to(leaf, LANES) for leaf in flatten(flights)], axis=1)
    np.testing.assert_allclose(columns[:5, rows], lanes, rtol=1e-9, atol=1e-9)


def test_air_that_is_known_to_be_zero_flies_as_air_that_is_zero():
    # The two loops of the plant round differently: 0.4 s of it stay far below 1e-9, as above.
    batch = inputs(range(LANES + 1))
    assert batch.disturbances.shape[2] == 3
    for rows in (4, 12):
        padded = np.pad(batch.disturbances, [(0, 0), (0, 0), (0, rows - 3), (0, 0)])
        shown, known = (
            flyer().fly(gains()[None], NOMINAL, replace(batch, disturbances=air))
            for air in (padded, batch.disturbances)
        )
        np.testing.assert_allclose(known, shown, rtol=1e-9, atol=1e-9)


def test_a_lost_lane_leaves_the_others_alone_and_its_meters_stand_still():
    batch = inputs(range(4), duration=1.0)
    healthy = flyer().fly(gains()[None], NOMINAL, batch)[0]
    broken = batch.disturbances.copy()
    broken[0, 100:, :, 2] = np.nan  # from 0.4 s on the air of scenario 2 is not a number
    results = flyer().fly(gains()[None], NOMINAL, replace(batch, disturbances=broken))[0]
    _, status, end_time = result_parts(results)
    assert status.tolist() == [0, 0, Status.NON_FINITE.code, 0]
    assert np.array_equal(results[[0, 1, 3]], healthy[[0, 1, 3]])
    # The first state that is not a number is seen one period after the first bad air; until then all is as before.
    assert end_time[2] == pytest.approx(101 * TIMING.control_period, abs=1e-12)
    until = inputs(range(4), duration=101 * TIMING.control_period)
    early = flyer().fly(
        gains()[None],
        NOMINAL,
        replace(
            batch,
            disturbances=batch.disturbances[:, :101].copy(),
            noises=batch.noises[:, :101].copy(),
            references=batch.references[:101],
        ),
    )[0]
    assert until.count == 4
    assert np.array_equal(results[2, :-2], early[2, :-2])


def test_status_is_kept_and_non_finite_outranks_tilt_outranks_position():
    batch = inputs(range(1), duration=0.6)
    n = index(Dynamics, "inverse_mass")
    assert n == 0

    def end(change, limits=LIMITS):
        air = np.pad(batch.disturbances, [(0, 0), (0, 0), (0, 9), (0, 0)])
        change(air)
        result = Flyer(loop(), limits, TIMING, 1).fly(gains()[None], NOMINAL, replace(batch, disturbances=air))
        _, status, end_time = result_parts(result[0])
        return list(Status)[int(status[0])], float(end_time[0])

    def push(air):
        air[:, 50:, 8] = 1e3  # m/s2 upwards: nothing tilts

    def push_then_nan(air):
        push(air)
        air[:, 100:, 0] = np.nan

    def push_and_twist(air):
        air[:, 50, 8], air[:, 50:, 9] = 2e6, 1e5  # both limits are passed within the same period

    def all_at_once(air):
        push_and_twist(air)
        air[:, 50, 0] = np.nan

    assert end(lambda air: None)[0] is Status.COMPLETED
    status, when = end(push)
    assert status is Status.LOST
    assert end(push_then_nan) == (status, when)
    assert end(push_and_twist, Limits(5.0, 0.99))[0] is Status.TILTED
    assert end(all_at_once, Limits(5.0, 0.99))[0] is Status.NON_FINITE


def test_spare_lanes_repeat_the_last_scenario():
    blocks = to_lanes(np.arange(LANES + 2, dtype=float)[:, None])
    assert blocks.shape == (2, 1, LANES)
    assert blocks[1, 0].tolist() == [LANES, *[LANES + 1] * (LANES - 1)]


def test_the_lane_loops_are_vector_code():
    # Counted on AVX2: 1679 packed against 137 scalar operations (those left work once a candidate); with the wind read from its
    # own array instead of the workspace, one of the plant's two lane loops stays scalar too and it is 1679 against 716.
    flyer().fly(gains()[None], NOMINAL, inputs(range(1)))
    kernel: Any = flyer()._kernel
    (compiled,) = kernel.overloads.values()
    # A kernel from the cache has no assembly, only what it was made of, in its final form.
    code = compiled.library.codegen._tm.emit_assembly(compiled.library._get_module_for_linking())
    packed = len(re.findall(r"v?f?n?m(?:add|sub)\d*pd|v?mulpd|v?addpd|v?subpd", code))
    scalar = len(re.findall(r"v?f?n?m(?:add|sub)\d*sd|v?mulsd|v?addsd|v?subsd", code))
    assert packed > 4 * scalar, (packed, scalar)


def test_workspace_rows_do_not_overlap():
    rows = layout(loop())
    starts = [rows.flight, rows.dynamics, rows.disturbance, rows.noise, rows.total]
    assert starts == sorted(starts)
    assert rows.dynamics == size(loop().Flight)
