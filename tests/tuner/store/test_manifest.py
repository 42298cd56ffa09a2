"""manifest.json: every file of every kind of folder is in it, and whatever happens to one of them is told and mended."""

import json
import shutil

import pytest

from plant.errors import StoreError
from tests.tuner.experiments.again.killing import assert_covered, assert_sealed, manifest_of, result_of, unsealed
from tests.tuner.in_process import tuner
from tuner.experiments.again.verify import verify
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.store.manifest import FILE, first_damage, refuse_damage


@pytest.fixture
def copy(small_run, tmp_path):
    return shutil.copytree(small_run[1], tmp_path / "copy")


def checked(folder):
    return verify(folder, 1, 2, Watcher())


def test_every_file_of_a_run_is_in_it(small_run):
    assert_covered(small_run[1])
    found = checked(small_run[1])
    assert found.identical and found.files == len(manifest_of(small_run[1]).files)
    assert f"All {found.files} files are what was written" in found.words


def edited(file):
    content = file.read_bytes()
    # The file of an empty figure may hold no such byte.
    file.write_bytes(content.replace(b"0", b"1", 1) if b"0" in content else content[:-1] + bytes([content[-1] ^ 1]))


def gone(file):
    file.unlink()


def cut(file):
    file.write_bytes(file.read_bytes()[:-1])


def headline(file):
    document = json.loads(file.read_text())
    document["table"][0]["tuned"]["value"] *= 0.5
    file.write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n")


DAMAGES = [
    ("summary.json", headline), ("front.csv", gone), ("gains.json", gone), ("resolved.json", edited), ("study.toml", edited),
    ("history.csv", edited), ("environment.json", edited), ("responses.npz", cut), ("margins.npz", gone),
    ("report.html", edited), ("figures/front.png", cut), ("figures/progress.pdf", gone), ("generations/0001.npz", gone),
]  # fmt: skip


@pytest.mark.parametrize(("name", "damage"), DAMAGES)
def test_damage_is_told_with_what_mends_it(name, damage, copy, monkeypatch, capsys):
    damage(copy / name)
    code, out, err = tuner(monkeypatch, capsys, "show", copy)
    assert (code, out) == (2, "") and err.count("\n") == 1
    assert str(copy / name) in err and f"`tuner resume {copy}` writes it again" in err
    found = str(first_damage(copy))
    assert name in found and f"`tuner resume {copy}`" in found


def test_verification_names_it_too(copy):
    # As it is compared number by number where there is something to compare with, and byte by byte elsewhere.
    headline(copy / "summary.json")
    assert "summary.json, table[0].tuned.value: recorded" in checked(copy).words
    (copy / "front.csv").unlink()
    found = checked(copy)
    assert not found.identical and "front.csv" in found.words


@pytest.mark.parametrize("name", ["report.html", "figures/front.png", "study.toml", "responses.npz"])
def test_verification_misses_no_file(name, copy):
    edited(copy / name)
    found = checked(copy)
    assert not found.identical and f"{name} is not what was written; `tuner resume" in found.words


def test_what_resume_mends(copy, small_run, monkeypatch, capsys):
    for name, damage in DAMAGES:
        damage(copy / name)
    code, _, err = tuner(monkeypatch, capsys, "resume", copy, "--json")
    assert (code, err) == (0, "")
    compared = result_of(copy)
    # The study comes back from inputs/, where it is without comments.
    assert compared.pop("study.toml") == (copy / "inputs" / "quickstart.toml").read_bytes()
    assert [name for name, content in compared.items() if content != result_of(small_run[1])[name]] == []
    assert_covered(copy)
    assert_sealed(copy, small_run[1])


def test_the_report_alone_is_written_again(copy, monkeypatch, capsys):
    edited(copy / "report.html")
    (copy / "figures" / "front.png").unlink()
    assert tuner(monkeypatch, capsys, "report", copy)[0] == 0
    assert_covered(copy)


def test_an_edited_record_cannot_be_gone_on_with(copy, monkeypatch, capsys):
    (copy / "run.json").unlink()
    assert "--reuse" in tuner(monkeypatch, capsys, "show", copy)[2]
    assert "run.json is missing" in checked(copy).words


def test_what_a_person_puts_there_is_not_asked_for(copy, monkeypatch, capsys):
    (copy / "notes.txt").write_text("mine")
    assert tuner(monkeypatch, capsys, "show", copy)[0] == 0
    assert checked(copy).identical


def test_a_folder_of_an_earlier_version_says_so(copy, monkeypatch, capsys):
    (copy / FILE).unlink()
    code, out, _ = tuner(monkeypatch, capsys, "show", copy)
    assert code == 0 and "earlier versions" in out
    found = checked(copy)
    assert found.identical and found.files is None and "earlier versions" in found.words
    assert tuner(monkeypatch, capsys, "report", copy)[0] == 0
    assert not (copy / FILE).exists()
    assert tuner(monkeypatch, capsys, "resume", copy, "--json")[0] == 0
    assert_covered(copy)


def test_a_folder_that_is_not_complete_is_not_shown_as_a_result(copy, monkeypatch, capsys):
    unsealed(copy)
    code, out, _ = tuner(monkeypatch, capsys, "show", copy)
    assert code == 0 and "Not finished" in out and f"tuner resume {copy}" in out
    assert not checked(copy).finished


@pytest.mark.parametrize(
    "text",
    ["{", "[]", "{}", '{"format": "gainproof-manifest", "version": 1, "complete": true, "files": {"../x": "0"}}'],
)
def test_a_damaged_manifest_is_told_and_mended(text, copy, monkeypatch, capsys):
    (copy / FILE).write_text(text)
    code, _, err = tuner(monkeypatch, capsys, "show", copy)
    assert code == 2 and f"{FILE} is damaged; `tuner resume {copy}`" in err and err.count("\n") == 1


def test_damage_between_two_sessions_is_not_sealed_in(copy):
    """A file that the second session takes over must be what the first one wrote."""
    edited(copy / "study.toml")
    with Folder.open(copy) as folder:
        assert not folder.keep("study.toml") and folder.keep("start.json")


def test_a_judgement_is_covered(small_run, tmp_path, monkeypatch, capsys):
    folder = tmp_path / "judged"
    code, _, err = tuner(monkeypatch, capsys, "rejudge", small_run[1], "--out", folder, "--json")
    assert (code, err) == (0, "")
    assert_covered(folder)
    code, out, _ = tuner(monkeypatch, capsys, "verify", folder)
    assert code == 0 and "Intact: all" in out and "A judgement is not flown again" in out
    edited(folder / "report.html")
    code, out, _ = tuner(monkeypatch, capsys, "verify", folder)
    assert code == 1 and f"`tuner report {folder}` writes it again" in out


def test_other_folders_say_what_mends_them(tmp_path, monkeypatch, capsys):
    with Folder.create(tmp_path / "s", inside="figures") as folder:
        folder.write_json("sensitivity.json", {"a": 1})
        folder.seal()
    code, _, err = tuner(monkeypatch, capsys, "show", tmp_path / "s")
    assert code == 2 and "not the folder of a run" in err and "sensitivity.json" in err
    edited_file = tmp_path / "s" / "sensitivity.json"
    edited_file.write_text("{}")
    assert str(first_damage(tmp_path / "s")).endswith("give the command again with another --out")
    found = checked(tmp_path / "s")
    assert not found.identical
    edited_file.unlink()
    with pytest.raises(StoreError, match="is missing"):
        refuse_damage(tmp_path / "s")
