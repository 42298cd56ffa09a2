"""Disks that fill up, folders and files that cannot be written: one line that says so, and nothing recorded is lost.

The disk is a small tmpfs of a mount namespace of its own; where the system gives none, a limit on the size of a file, which
fails in the middle of a write as well, stands in for it.
"""

import json
import resource
import shutil
import subprocess

import pytest

from plant.output_files import ASIDE
from tests.tuner.conftest import QUICKSTART, SMALL
from tests.tuner.experiments.again.killing import command, compare, result_of
from tests.tuner.in_process import tuner

SETS = [part for key, value in SMALL.items() for part in ("--set", f"{key}={json.dumps(value)}")]
# Sizes of the disk [kB] and what is being written when it is full.
ROOMS = {
    120: "flights/search-",
    300: "flights/held-out-",
    600: "responses.npz",
    1100: "figures",
    3000: "report.html",
}
FULL, TOO_LARGE = "No space left on device", "File too large"


def run(folder):
    return ["run", QUICKSTART, "--out", folder, *SETS]


def in_namespace(script, *arguments, code=None):
    """Run a shell script where it may mount; $1, $2, ... are the arguments."""
    words = ["unshare", "--map-root-user", "--mount", "sh", "-c", script, "sh", *map(str, arguments)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=180, check=False)
    assert code is None or done.returncode == code, done.stdout + done.stderr
    return done


@pytest.fixture(scope="module")
def namespace(tmp_path_factory):
    """Skip where no small disk can be had."""
    folder = tmp_path_factory.mktemp("probe")
    if shutil.which("unshare") is None or in_namespace('mount -t tmpfs -o size=64k none "$1"', folder).returncode != 0:
        pytest.skip("no mount namespaces here")


@pytest.fixture(scope="module")
def undisturbed(small_run):
    return small_run[1]


@pytest.fixture
def finished(undisturbed, tmp_path):
    """A copy of the finished run."""
    return shutil.copytree(undisturbed, tmp_path / "r")


def assert_told(done, *words):
    assert done.returncode == 2, done.stdout + done.stderr
    assert_one_line(done.stderr, *words)


def assert_one_line(err, *words):
    assert err.startswith("Error: ") and err.count("\n") == 1, err
    assert all(word in err for word in words), err


def assert_nothing_lost(left, expected):
    """What was left is the beginning of what the undisturbed run wrote, byte for byte, and there is no half file."""
    assert not list(left.rglob(f"*{ASIDE}")) and not list(left.rglob("*.part"))
    kept, whole = result_of(left), result_of(expected)
    assert "run.json" in kept
    assert {name: content == whole[name] for name, content in kept.items()} == dict.fromkeys(kept, True)


FILL = 'mount -t tmpfs -o size="$1"k none "$2" || exit 9; shift; disk="$1"; shift; "$@"; code=$?; '


def assert_survives(room, undisturbed, tmp_path, monkeypatch, capsys):
    disk, grown, kept = tmp_path / "disk", tmp_path / "grown", tmp_path / "kept"
    for folder in (disk, grown, kept):
        folder.mkdir()
    # On the small disk; what is there is copied away, the disk is made larger, and the run goes on where it was.
    script = (
        f'{FILL} cp -a "$disk/r" "{kept}/r"; echo "code $code"; mount -o remount,size=64m "$disk" || exit 9; '
        f'{" ".join(map(repr, command("resume", disk / "r", "--json")[:2]))} "$CODE" resume "$disk/r" --json > /dev/null || exit 8; '
        f'cp -a "$disk/r" "{grown}/r"'
    )
    monkeypatch.setenv("CODE", command()[-1])
    done = in_namespace(script, room, disk, *command(*run(disk / "r"), "--json"), code=0)
    assert done.stdout == "code 2\n"
    assert_one_line(done.stderr, ROOMS[room], FULL)
    assert_nothing_lost(kept / "r", undisturbed)
    compare(result_of(grown / "r"), result_of(undisturbed))
    # Elsewhere.
    code, _, err = tuner(monkeypatch, capsys, "resume", kept / "r", "--json")
    assert (code, err) == (0, "")
    compare(result_of(kept / "r"), result_of(undisturbed))


@pytest.mark.slow
def test_a_full_disk(namespace, undisturbed, tmp_path, monkeypatch, capsys):
    assert_survives(600, undisturbed, tmp_path, monkeypatch, capsys)


@pytest.mark.slow
@pytest.mark.parametrize("room", sorted(set(ROOMS) - {600}))
def test_a_disk_that_is_full_sooner_or_later(room, namespace, undisturbed, tmp_path, monkeypatch, capsys):
    assert_survives(room, undisturbed, tmp_path, monkeypatch, capsys)


# Largest file [bytes]: flights of the first generation take 37 kB, of the held-out check 92 kB, responses 570 kB.
@pytest.mark.parametrize(
    ("largest", "name"),
    [
        pytest.param(30_000, "flights/search-0000", marks=pytest.mark.slow),
        pytest.param(60_000, "flights/held-out-", marks=pytest.mark.slow),
        pytest.param(300_000, "responses.npz", marks=pytest.mark.slow),
        pytest.param(1_000_000, "report.html", marks=pytest.mark.slow),
    ],
)
def test_a_write_that_fails_halfway(largest, name, undisturbed, tmp_path, monkeypatch, capsys):
    folder = tmp_path / "r"

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))

    words = command(*run(folder), "--json")
    done = subprocess.run(words, capture_output=True, text=True, timeout=180, preexec_fn=limit, check=False)
    assert_told(done, name, TOO_LARGE)
    assert_nothing_lost(folder, undisturbed)
    code, _, err = tuner(monkeypatch, capsys, "resume", folder, "--json")
    assert (code, err) == (0, "")
    compare(result_of(folder), result_of(undisturbed))


def test_a_folder_in_the_place_of_a_file(finished, undisturbed, monkeypatch, capsys):
    (finished / "front.csv").unlink()
    (finished / "front.csv").mkdir()
    code, _, err = tuner(monkeypatch, capsys, "resume", finished, "--json")
    assert code == 2
    assert_one_line(err, "front.csv cannot be written")
    (finished / "front.csv").rmdir()
    assert_nothing_lost(finished, undisturbed)
    assert tuner(monkeypatch, capsys, "resume", finished, "--json")[0] == 0
    compare(result_of(finished), result_of(undisturbed))


def test_a_file_in_the_place_of_a_folder(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("mine")
    code, _, err = tuner(monkeypatch, capsys, *run(tmp_path / "file" / "r"))
    assert code == 2
    assert_one_line(err, "cannot be made", "--out")
    assert (tmp_path / "file").read_text() == "mine" and len(list(tmp_path.iterdir())) == 1


READ_ONLY = 'mount --bind "$1" "$1" && mount -o remount,ro,bind "$1" || exit 9; shift; "$@"'


@pytest.mark.slow
def test_a_read_only_folder(namespace, finished, undisturbed, tmp_path):
    """Neither is a run begun in one, nor one in it gone on with; to look at it needs no writing."""
    parent = tmp_path / "parent"
    parent.mkdir()
    begun = in_namespace(READ_ONLY, parent, *command(*run(parent / "r"), "--json"))
    assert_told(begun, str(parent / "r"), "cannot be made", "Read-only file system", "--out")
    gone_on = in_namespace(READ_ONLY, finished, *command("resume", finished, "--json"))
    assert_told(gone_on, str(finished), "Read-only file system")
    assert list(parent.iterdir()) == []
    compare(result_of(finished), result_of(undisturbed))


def test_an_unwritable_file(finished, undisturbed, monkeypatch, capsys):
    """Root may write whatever its permissions say, but for a file that is immutable."""
    file = finished / "summary.json"
    frozen = shutil.which("chattr") and subprocess.run(["chattr", "+i", file], capture_output=True, check=False)
    if not frozen or frozen.returncode != 0:
        pytest.skip("no file can be made immutable here")
    try:
        code, _, err = tuner(monkeypatch, capsys, "resume", finished, "--json")
    finally:
        subprocess.run(["chattr", "-i", file], check=True)
    assert code == 2
    assert_one_line(err, "summary.json cannot be written", "Operation not permitted")
    assert_nothing_lost(finished, undisturbed)
    assert tuner(monkeypatch, capsys, "resume", finished, "--json")[0] == 0
    compare(result_of(finished), result_of(undisturbed))
