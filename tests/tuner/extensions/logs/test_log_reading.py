"""Every kind of log is read in SI units, FLU and our order of rotors, and hostile files end in one line."""

import importlib.util
import tracemalloc
from time import monotonic

import numpy as np
import pytest

from plant.errors import InputError, MissingPackageError
from tests.tuner.extensions.logs.written import MAPPING, WRITERS, crazyflie, truth
from tuner.extensions.logs import blackbox, ulog
from tuner.extensions.logs.flight_log import MIN_SAMPLES
from tuner.extensions.logs.reading import READERS, read_log

# Steps of the motor commands in the formats: 16 bits, 12 bits, pulses of 1 us.
STEP = 1e-3
PACKAGES = {"PX4 ULog": "pyulog", "Betaflight blackbox (.bbl)": "betaflight_chirp_core"}
ROUNDED = {"Betaflight blackbox (.bbl)": (1e-3, 3e-3)}
"""Half a step of rates [rad/s] and of specific force [m/s2] in formats of whole numbers."""
SETPOINTS = ("CSV", "PX4 ULog", "ArduPilot DataFlash (.bin)", "Betaflight blackbox (.bbl)")
"""Kinds whose writers give half of the rates as their setpoints."""
LONGEST, MAX_MEMORY = 20.0, 50e6
"""Longest time [s] and most memory [bytes] that any file of these sizes, 20 to 100 kB, may take; each takes a hundredth of the time."""


@pytest.fixture
def mapping(tmp_path):
    file = tmp_path / "columns.toml"
    file.write_text(MAPPING)
    return file


def read(kind, content, folder, mapping):
    if kind in PACKAGES and importlib.util.find_spec(PACKAGES[kind]) is None:
        pytest.skip(f"needs {PACKAGES[kind]}")
    file = folder / "log"
    file.write_bytes(content)
    return read_log(file, mapping if kind == "CSV" else None)


def test_every_reader_has_a_writer():
    assert {reader.kind for reader in READERS} | {"CSV"} == set(WRITERS)


@pytest.mark.parametrize("kind", WRITERS)
def test_what_was_written_is_read(kind, tmp_path, mapping):
    expected = truth()
    log = read(kind, WRITERS[kind](expected), tmp_path, mapping)
    assert log.kind == kind
    assert log.time - log.time[0] == pytest.approx(expected.time - expected.time[0], abs=2e-6)
    gyro, acceleration = ROUNDED.get(kind, (1e-5, 1e-5))
    assert log.gyro == pytest.approx(expected.gyro, abs=gyro)
    assert log.acceleration == pytest.approx(expected.acceleration, abs=acceleration)
    assert log.command == pytest.approx(expected.command, abs=STEP)
    if kind in SETPOINTS:
        assert log.setpoint == pytest.approx(0.5 * expected.gyro, abs=gyro)
    else:
        assert log.setpoint is None


def test_the_first_version_of_the_deck_counts_milliseconds(tmp_path, mapping):
    log = read("Crazyflie SD card", crazyflie(truth(), version=1), tmp_path, mapping)
    assert log.duration == pytest.approx(599 / 500.0, abs=2e-3)


@pytest.mark.parametrize("kind", WRITERS)
def test_a_log_that_is_cut_off_is_read_as_far_as_it_goes_or_refused(kind, tmp_path, mapping):
    content = WRITERS[kind](truth(1200))
    log = read(kind, content[: len(content) // 2], tmp_path, mapping)
    assert MIN_SAMPLES <= len(log.time) < 1200


def test_a_pause_breaks_a_log_and_small_gaps_are_counted(tmp_path, mapping):
    whole = truth(2000)
    kept = np.ones(2000, bool)
    kept[[300, 301, 700]] = False
    kept[1000:1200] = False
    log = read("Crazyflie SD card", crazyflie(type(whole)(*[part[kept] for part in whole])), tmp_path, mapping)
    assert [len(part.time) for part in log.stretches()] == [997, 800]
    assert log.lost == 203


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b"hello", "is no log that is known"),
        (b"\xbc\x02\x00\xff\xff" + bytes(50), "says that it has 65,535 event types"),
        (b"\xbc\x02\x00\x01\x00\x01\x00" + b"a" * 300, "a name without end"),
        (crazyflie(truth(50)), "50 usable samples"),
        (b"loopIteration, gyroADC[0]\n1, 2\n", "lacks the columns time"),
    ],
)
def test_a_log_of_no_use_is_refused_in_a_line(content, message, tmp_path):
    file = tmp_path / "log"
    file.write_bytes(content)
    with pytest.raises(InputError, match=message) as error:
        read_log(file)
    assert str(file) in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"FRD"', '"NED"', "axes: given 'NED'; allowed: FLU, FRD"),
        ('"deg/s"', '"rpm"', "gyro.unit: given 'rpm'"),
        ('"sr"], unit = "deg/s"', '"sr"], unit = "rpm"', "setpoint.unit: given 'rpm'"),
        ('"sr"]', '"s_r"]', "unknown column 's_r'; did you mean 'sr'"),
        ("idle = 1000", "idle = 3000", "command.full: given 2000; it must be above idle"),
        ('["fl", "fr", "rl", "rr"]', '["fl", "fr", "rl"]', "command.columns"),
        ('"ax"', '"a_x"', "unknown column 'a_x'; did you mean 'ax'"),
        ("axes", "axis", "axis"),
    ],
)
def test_a_mapping_that_is_wrong_is_told_with_its_key(old, new, message, tmp_path, mapping):
    mapping.write_text(MAPPING.replace(old, new))
    with pytest.raises(InputError, match=message):
        read("CSV", WRITERS["CSV"](truth()), tmp_path, mapping)


@pytest.mark.parametrize(
    ("magic", "package"), [(ulog.MAGIC, "pyulog"), (blackbox.MAGIC, "betaflight_chirp_core")], ids=["ulog", "bbl"]
)
def test_a_missing_package_is_told_with_the_line_that_installs_it(magic, package, monkeypatch, tmp_path):
    monkeypatch.setattr("plant.errors.find_spec", lambda package: None)
    file = tmp_path / "log"
    file.write_bytes(magic + bytes(100))
    with pytest.raises(MissingPackageError, match=rf"needs the package {package}; .*pip install ") as refused:
        read_log(file)
    assert package.replace("_", "-") in str(refused.value).partition("pip install")[2]


BLACKBOX = "Betaflight blackbox (.bbl)"


def test_recordings_of_a_blackbox_file_follow_each_other_and_keep_their_setpoints(tmp_path, mapping):
    made = truth()
    one, later = WRITERS[BLACKBOX](made), WRITERS[BLACKBOX](made._replace(time=made.time + 60.0))
    log = read(BLACKBOX, one + later + one, tmp_path, mapping)
    assert len(log.time) == 3 * len(made.time) and "3 recordings" in log.notes[0]
    assert [len(part.time) for part in log.stretches()] == [len(made.time)] * 3
    # The first two share a clock, the third begins anew.
    starts = [part.time[0] for part in log.stretches()]
    assert np.diff(starts) == pytest.approx([60.0, made.time[-1] - made.time[0] + 1.0], abs=1e-5)
    assert log.setpoint == pytest.approx(0.5 * log.gyro, abs=1e-3)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"P interval:1/1", b"P interval:0/1", "its head is damaged"),
        (b"I interval:32", b"I interval:9999999", "its head is damaged"),
        (b"P interval:1/1", b"P interval:0", "in the last recording"),
        (b"accSmooth[2]", b"accSmooth[7]", r"lacks the columns accSmooth\[2\]"),
        (b"acc_1G:2048", b"acc_1G:x", "in the last recording"),
        (b"by Nicholas", b"by Nicolaus", "it holds no recording"),
    ],
)
def test_a_blackbox_file_with_a_damaged_head_is_refused(old, new, message, tmp_path, mapping):
    content = WRITERS[BLACKBOX](truth())
    assert old in content
    with pytest.raises(InputError, match=message):
        read(BLACKBOX, content.replace(old, new), tmp_path, mapping)


def test_a_damaged_message_at_the_end_of_a_ulog_is_refused_at_once(tmp_path, mapping, capsys):
    # pyulog steps back further than it could read, and so for ever.
    with pytest.raises(InputError, match="reading it does not end"):
        read("PX4 ULog", ulog.MAGIC + bytes(9) + b"\xff\xff\0" + bytes(40), tmp_path, mapping)
    assert capsys.readouterr().out == ""


def test_setpoints_of_a_table_are_read_and_left_out_where_one_is_no_number(tmp_path, mapping):
    head, *rows = WRITERS["Betaflight blackbox as CSV"](truth()).decode().split("\n")
    head += "".join(f", setpoint[{i}]" for i in range(3))
    whole = [f"{row}, 90, {k}, 0" for k, row in enumerate(rows[:-1])]
    log = read("Betaflight blackbox as CSV", "\n".join([head, *whole]).encode(), tmp_path, mapping)
    assert log.setpoint is not None and log.setpoint[7] == pytest.approx([np.pi / 2.0, np.radians(7.0), 0.0])
    whole[5] = whole[5].replace(" 90,", " x,")
    log = read("Betaflight blackbox as CSV", "\n".join([head, *whole]).encode(), tmp_path, mapping)
    assert log.setpoint is None and "setpoints are left out" in log.notes[-1]


def test_the_first_row_of_a_table_may_be_cut(tmp_path, mapping):
    head, first, rest = WRITERS["Betaflight blackbox as CSV"](truth()).split(b"\n", 2)
    log = read("Betaflight blackbox as CSV", b"\n".join((head, first[:40], rest)), tmp_path, mapping)
    assert len(log.time) == 599


def mutated(content, draw):
    """A file that is cut, has bits turned, a part doubled or a part of another kind in it."""
    data, how, place = bytearray(content), draw.integers(5), int(draw.integers(len(content)))
    if how == 0:
        return bytes(data[:place])
    if how == 1:
        for k in draw.integers(len(data), size=20):
            data[k] ^= 1 << int(draw.integers(8))
    elif how == 2:
        data[place : place + 8] = draw.bytes(8)
    elif how == 3:
        data[place:place] = data[: int(draw.integers(4000))]
    else:
        # Heads hold counts and lengths.
        k = int(draw.integers(min(len(data), 300)))
        data[k] = int(draw.integers(256))
    return bytes(data)


@pytest.fixture
def traced_memory():
    """Python's and NumPy's memory, counted while a test runs."""
    tracemalloc.start()
    yield
    tracemalloc.stop()


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("count", [16, pytest.param(400, marks=pytest.mark.slow)])
def test_damaged_files_are_read_or_refused_in_a_line(kind, count, tmp_path, mapping, traced_memory):
    content = WRITERS[kind](truth(300))
    for i in range(count):
        tracemalloc.reset_peak()
        begin = monotonic()
        try:
            log = read(kind, mutated(content, np.random.default_rng((count, i))), tmp_path, mapping)
        except InputError as error:
            assert "\n" not in str(error)
        else:
            assert np.all(np.isfinite(log.gyro)) and np.all(np.diff(log.time) > 0.0)
        assert monotonic() - begin < LONGEST
        assert tracemalloc.get_traced_memory()[1] < MAX_MEMORY


def test_a_column_that_stands_twice_is_refused():
    from tuner.extensions.logs.csv_table import read_columns

    with pytest.raises(InputError, match="has 2 columns 'a'"):
        read_columns(b"a,b,a\n1,2,3\n4,5,6\n", "log.csv", ["a"])
    assert read_columns(b"a,b,a\n1,2,3\n4,5,6\n", "log.csv", ["b"]).tolist() == [[2.0], [5.0]]
