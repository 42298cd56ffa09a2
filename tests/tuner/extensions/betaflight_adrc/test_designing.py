"""Tunes by margin: each keeps it at every throttle and with every pack, and a faster one does not."""

import re

import pytest

import tuner
from plant.errors import InputError
from tuner.extensions.betaflight_adrc.designing import MIN_PHASE, design_front, designed_settings
from tuner.extensions.betaflight_adrc.linear_loop import AxisPlant, Sampling
from tuner.extensions.betaflight_adrc.ringing import DEFAULT_GROWTH, plants_of_b0, rings, worst_ring
from tuner.extensions.betaflight_adrc.settings import AXES, default_tune
from tuner.extensions.betaflight_adrc.vehicle_plants import BY_B0, VehicleAxis, VehiclePlants

SAMPLING = Sampling(312e-6, 312e-6, ())
TUNE = default_tune().with_numbers({"adrc_b0_roll": 6560.0, "adrc_b0_pitch": 3936.0, "adrc_b0_yaw": 2624.0})
PACKS = (1.0, 1.2)
WANTED = 2.0


def craft_of(factor=1.0):
    plants = plants_of_b0(TUNE).items()
    return VehiclePlants(
        {axis: VehicleAxis(AxisPlant(factor * p.gain, p.lag, p.dead_time, p.zero), BY_B0) for axis, p in plants}
    )


@pytest.fixture(scope="module")
def front():
    return design_front(TUNE, craft_of(), SAMPLING, DEFAULT_GROWTH, PACKS, WANTED, max_noise=10.0)


def margins_of(changes, axis):
    """Return the smallest gain margin and phase margin in flight of a changed tune."""
    plants = {axis: plants_of_b0(TUNE)[axis]}
    rows = list(rings(TUNE.with_numbers(changes), plants, SAMPLING, packs=PACKS))
    worst = worst_ring(rows, TUNE.schedule)
    return worst.gain_margin or 0.0, worst.phase_margin or 0.0


@pytest.mark.parametrize("axis", AXES)
def test_the_margin_holds_at_every_throttle_and_with_every_pack(front, axis):
    row = next(row for row in front if (row.axis, row.wanted) == (axis, WANTED))
    gain, phase = margins_of({f"adrc_wc_{axis}": row.wc, f"adrc_wo_{axis}": row.wo}, axis)
    assert gain == pytest.approx(row.gain_margin, rel=1e-6) and gain >= WANTED and phase >= MIN_PHASE
    faster = {f"adrc_wc_{axis}": row.wc + 2.0, f"adrc_wo_{axis}": round((row.wc + 2.0) * row.wo / row.wc)}
    assert margins_of(faster, axis)[0] < WANTED


@pytest.mark.parametrize("axis", AXES)
def test_margin_costs_bandwidth_and_noise_goes_with_it(front, axis):
    rows = sorted((row for row in front if row.axis == axis), key=lambda row: row.wanted)
    assert len(rows) > 3
    for name in ("bandwidth", "stiffness", "noise"):
        values = [getattr(row, name) for row in rows]
        assert values == sorted(values, reverse=True)


def test_a_design_is_no_noisier_than_the_present_tune():
    """The present tune has a margin of 2.7 at hover: with half of it the noise is the limit, and b0 stays."""
    rows = design_front(TUNE, craft_of(), SAMPLING, DEFAULT_GROWTH, (1.0,), 1.3)
    quiet = next(row for row in rows if (row.axis, row.wanted) == ("roll", 1.3))
    assert 0.9 < quiet.noise <= 1.0 and quiet.stiffness > 0.9
    assert set(designed_settings(rows, 1.3)) == {f"adrc_{name}_{axis}" for name in ("wc", "wo") for axis in AXES}


@pytest.mark.parametrize(
    ("wanted", "factor", "said"), [(1.0, 1.0, "give a gain margin above 1"), (3.0, 60.0, "roll keeps 1 with")]
)
def test_margins_that_no_tune_keeps(wanted, factor, said):
    with pytest.raises(InputError, match=re.escape(said)):
        design_front(TUNE, craft_of(factor=factor), SAMPLING, DEFAULT_GROWTH, (1.0,), wanted)


def test_the_command_designs_draws_and_writes(vehicle, tmp_path):
    made = tuner.adrc(vehicle(), gyro_rate=3205.0, packs=[0.85], design=1.5, front=tmp_path / "front.png")
    worst = made.document.rings[made.document.worst]
    assert 1.5 <= (worst.gain_margin or 0.0) < 1.65 and {row.wanted for row in made.document.design} >= {1.5, 2.0}
    assert f"set adrc_wc_yaw = {made.profile.tune.of('wc', 'yaw'):.0f}\n" in made.lines
    assert (tmp_path / "front.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("name", "design", "packs", "said"),
    [
        ("other.png", None, (), "--front: needs --design"),
        ("front.svg", 2.0, (), "--front: give a name that ends in .png or .pdf"),
        ("other.png", 2.0, (0.1,), "--pack: given 0.1; give a voltage over the usual one, from 0.3 to 3"),
    ],
)
def test_options_that_are_refused(vehicle, tmp_path, name, design, packs, said):
    with pytest.raises(InputError, match=re.escape(said)):
        tuner.adrc(vehicle(), packs=packs, design=design, front=tmp_path / name)


def test_a_pack_of_more_voltage_lowers_the_margin_by_speed_and_slope(vehicle):
    """At one collective the rotors turn faster by r and answer by r more: with a growth of 1 the gain rises by r^2."""
    rows = tuner.adrc(vehicle(), gyro_rate=3205.0, growth=1.0, packs=[1.2]).document.rings
    gains = {
        row.pack: row.gain_margin or 0.0
        for row in rows
        if (row.axis, row.throttle, row.schedule) == ("yaw", 0.5, "FIXED")
    }
    assert gains[1.0] / gains[1.2] == pytest.approx(1.44)


def test_the_plants_of_a_first_file_stay_where_b0_changes(vehicle, tmp_path):
    first = tmp_path / "first.txt"
    first.write_text(vehicle().read_text())
    before = tuner.adrc(first, gyro_rate=3205.0).document
    after = tuner.adrc(vehicle(adrc_b0_yaw="7172"), gyro_rate=3205.0, plants=first).document
    assert [row.gain for row in before.plants] == [row.gain for row in after.plants] and not after.is_limit
    gains = [
        next(row.gain_margin or 0.0 for row in document.rings if row.axis == "yaw" and row.schedule == "FIXED")
        for document in (before, after)
    ]
    assert gains[1] == pytest.approx(2.0 * gains[0])
