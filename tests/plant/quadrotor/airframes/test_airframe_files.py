"""Reading airframe files: users' files work as bundled ones do, and every mistake names file, key and remedy."""

import pickle
import subprocess
import sys
from pathlib import Path

import pytest

from plant.errors import InputError, UnknownNameError
from plant.quadrotor.airframes import load

GOOD = load("hummingbird").path.read_text()


def written(folder: Path, text: str, name: str = "mine.toml") -> Path:
    """Return the path of an airframe file with this text."""
    path = folder / name
    path.write_text(text)
    return path


def changed(old: str, new: str) -> str:
    """Return the good file with one place changed."""
    assert GOOD.count(old) == 1, old
    return GOOD.replace(old, new)


def test_a_users_file_is_read_like_a_bundled_one(tmp_path: Path) -> None:
    """Same text, same vehicle; by Path and by text; the name is the file's."""
    path = written(tmp_path, GOOD)
    by_path, by_text = load(path), load(str(path))
    assert by_path == by_text
    assert by_path.vehicle == load("hummingbird").vehicle
    assert (by_path.name, by_path.path) == ("mine", path)


def test_every_number_reaches_its_own_field(tmp_path: Path) -> None:
    """Raising any one number of the file by 1 % changes that field of the vehicle, and no other."""
    base = load("hummingbird")
    for key, number in base.sources.items():
        heading, _, leaf = key.rpartition(".")
        section = GOOD.index(f"[{heading}]") if heading else 0
        start = GOOD.index(f"\n{leaf} = ", section) + 1
        line = GOOD[start : GOOD.index("\n", start)]
        text = line.split("value = ")[1].split(",")[0]
        raised = 1.01 * number.value + (0.001 if number.value == 0.0 else 0.0)
        moved = GOOD[:start] + line.replace(f"value = {text}", f"value = {raised!r}") + GOOD[start + len(line) :]
        vehicle = load(written(tmp_path, moved)).vehicle
        differing = [name for name in vehicle._fields if getattr(vehicle, name) != getattr(base.vehicle, name)]
        assert differing == (["rotor_x", "rotor_y"] if key == "arm" else [heading or leaf])
        if heading:
            assert getattr(getattr(vehicle, heading), leaf) == raised
        elif key != "arm":
            assert getattr(vehicle, leaf) == raised


def test_mirror_spin(tmp_path: Path) -> None:
    """The other spin turns every reaction torque round."""
    mirrored = load(written(tmp_path, changed('spin = "+--+"', 'spin = "-++-"'))).vehicle
    assert mirrored.spin == tuple(-s for s in load("hummingbird").vehicle.spin)


def test_wide_x_takes_levers() -> None:
    """Iris: 0.13 m fore and aft, 0.22 m to the sides, front left first."""
    vehicle = load("iris").vehicle
    assert vehicle.rotor_x == (0.13, 0.13, -0.13, -0.13)
    assert vehicle.rotor_y == (0.22, -0.22, 0.22, -0.22)


WITHOUT_DAMPING = GOOD.split("[rate_damping]")[0]
MASS = 'mass = { value = 0.698, unit = "kg"'
MISTAKES = {
    "misspelt key": (changed("mass = {", "mas = {"), "mas", "did you mean 'mass'"),
    "misspelt header": (changed("title = ", "tilte = "), "title", "is missing"),
    "unknown key": (GOOD + '\n[extra]\ncolour = "red"\n', "extra", "unknown key 'extra'"),
    "unknown axis": (changed("[inertia]\nx =", "[inertia]\nw ="), "inertia.w", "did you mean 'inertia."),
    "length of another frame": (changed("arm = {", "lever_side = {"), "lever_side", "unknown key 'lever_side'"),
    "missing key": (changed("lag_up = {", "#lag_up = {"), "lag_up", "is missing; write lag_up = {"),
    "missing axis": (changed("[rate_damping]\nx =", "[rate_damping]\n#x ="), "rate_damping.x", "is missing"),
    "missing vector": (WITHOUT_DAMPING, "rate_damping.x", "is missing"),
    "vector as a number": ("rate_damping = 0.0\n" + WITHOUT_DAMPING, "rate_damping", "it must give x, y and z"),
    "bare number": (changed(MASS, 'mass = 0.698\n#{ value = 0.698, unit = "kg"'), "mass", 'unit = "kg", source ='),
    "missing value": (changed(MASS, 'mass = { unit = "kg"'), "mass.value", "is missing; it must be a finite number"),
    "missing unit": (changed(MASS, "mass = { value = 0.698"), "mass.unit", 'is missing; only unit = "kg"'),
    "misspelt part": (changed(MASS, 'mass = { valeu = 0.698, unit = "kg"'), "mass.valeu", "did you mean 'value'"),
    "wrong unit": (changed(MASS, 'mass = { value = 698, unit = "g"'), "mass.unit", "is 'g'; only unit = \"kg\""),
    "text for a number": (changed(MASS, 'mass = { value = "0.698", unit = "kg"'), "mass.value", "is '0.698'"),
    "true for a number": (changed(MASS, 'mass = { value = true, unit = "kg"'), "mass.value", "is True"),
    "nan": (changed(MASS, 'mass = { value = nan, unit = "kg"'), "mass.value", "finite number in kg"),
    "infinite": (changed(MASS, 'mass = { value = inf, unit = "kg"'), "mass.value", "finite number in kg"),
    "zero": (changed(MASS, 'mass = { value = 0, unit = "kg"'), "mass.value", "must be positive"),
    "negative": (changed(MASS, 'mass = { value = -0.698, unit = "kg"'), "mass.value", "is -0.698 kg; it must be"),
    "negative speed": (changed("value = 115.2", "value = -1"), "speed_min.value", "must be not negative"),
    "empty source": (changed('"Misin, as above: g"', '" "'), "gravity.source", "say where the value comes from"),
    "unknown frame": (changed('frame = "x"', 'frame = "cross"'), "frame", "unknown frame 'cross'"),
    "missing frame": (changed('frame = "x"', '#frame = "x"'), "frame", "it must be one of 'x', 'plus', 'wide-x'"),
    "spin that cannot fly": (changed('spin = "+--+"', 'spin = "+-+-"'), "spin", "valid: +--+, -++-"),
    "empty title": (changed("AscTec Hummingbird, corrected set of the seed study", ""), "title", "must be a text"),
    "flag as a number": ("allow_unphysical = 1\n" + GOOD, "allow_unphysical", "must be true or false"),
}


@pytest.mark.parametrize(("text", "key", "says"), MISTAKES.values(), ids=MISTAKES.keys())
def test_mistakes_name_file_key_and_remedy(tmp_path: Path, text: str, key: str, says: str) -> None:
    """Each mistake is an input error at its dotted key."""
    path = written(tmp_path, text)
    with pytest.raises(InputError) as caught:
        load(path)
    assert caught.value.file == str(path)
    assert caught.value.key == key
    assert says in caught.value.message


@pytest.mark.parametrize("key", [key for key in load("hummingbird").sources if key != "drag_height"])
def test_no_other_number_may_be_negative(tmp_path: Path, key: str) -> None:
    """Whatever the field, a value of -1 is refused at its own key."""
    heading, _, leaf = key.rpartition(".")
    start = GOOD.index(f"\n{leaf} = ", GOOD.index(f"[{heading}]") if heading else 0)
    rest = GOOD[start:].split("value = ", 1)[1].split(",", 1)[1]
    path = written(tmp_path, f"{GOOD[:start]}\n{leaf} = {{ value = -1,{rest}")
    with pytest.raises(InputError, match="it must be (positive|not negative)") as caught:
        load(path)
    assert caught.value.key == f"{key}.value"


def test_height_of_drag_may_be_negative(tmp_path: Path) -> None:
    """A centre of pressure below the centre of mass is real."""
    text = changed("drag_height = { value = 0.05", "drag_height = { value = -0.05")
    assert load(written(tmp_path, text)).vehicle.drag_height == -0.05


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"title = ", "not TOML"),
        (b"\xff\xfe\x00", "not UTF-8 text"),
        (b"a = " + 9999 * b"[", "nested"),
        (None, "bundled"),
    ],
)
def test_unreadable_files(tmp_path: Path, content: bytes | None, words: str) -> None:
    """Broken TOML, bytes that are no text, and no file at all."""
    path = tmp_path / "mine.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load(path)
    assert caught.value.file == str(path)
    assert words in caught.value.message


def test_folder_is_not_a_file(tmp_path: Path) -> None:
    """A folder given for a file is an input error, too."""
    with pytest.raises(InputError, match="cannot be read"):
        load(tmp_path)


def test_unknown_name() -> None:
    """A misspelt bundled name comes with the nearest one."""
    with pytest.raises(UnknownNameError, match="unknown airframe 'humingbird'; did you mean 'hummingbird'"):
        load("humingbird")


def test_airframes_survive_pickling() -> None:
    """Workers on other machines receive airframes whole."""
    airframe = load("iris")
    assert pickle.loads(pickle.dumps(airframe)) == airframe


def test_loading_needs_no_numpy() -> None:
    """Listing airframes must not cost the import of NumPy."""
    code = "import sys; from plant.quadrotor.airframes import load; load('iris'); sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
