"""The bundle: `make test` passes in a fresh folder and fails when any constant is changed; rollback, held gains, words."""

import json
import os
import re
import subprocess
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from plant.backends.c_code import REALS
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions
from tests.clients import program
from tests.tuner.exchange.c99.compiled import FLAGS, uneven
from tuner.exchange.c99.export import TARGET, as_held
from tuner.exchange.c99.quadrotor import c_sources
from tuner.exchange.target import Request
from tuner.gains import read_gains, to_document

FILES = {"gainproof_controller.h", "gainproof_controller.c", "golden.h", "test_golden.c", "Makefile", "README.md"}
DIGEST = "5" * 64


def bundle(controller, real="float", previous=None):
    return TARGET.export(Request(controller, DIGEST, {"real": real}, previous))


@cache
def usual(position, attitude, real="float"):
    """The bundle of a controller with gains that differ from axis to axis."""
    return bundle(uneven(position, attitude), real)


@cache
def short(position, attitude):
    """The same with few golden vectors, for the tests that `briefly` marks: they look at none."""
    return usual.__wrapped__(position, attitude)


briefly = pytest.mark.usefixtures("few_golden_vectors")


def written(folder, files):
    folder.mkdir(exist_ok=True)
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return folder


def made(folder, *targets):
    return subprocess.run([program("make"), *targets], cwd=folder, capture_output=True, text=True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "real", "options"),
    [
        ("hybrid", "float", ControlOptions()),
        ("ladrc_printed", "float", ControlOptions(delay=True)),
        ("supertwisting", "double", ControlOptions("observer", "observer")),
    ],
)
def test_make_test_passes_in_a_fresh_folder(law, real, options, tmp_path):
    found = bundle(uneven(law, law, options=options), real)
    assert set(found.files) == FILES
    folder = written(tmp_path / "bundle", found.files)
    done = made(folder, "test")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "warning" not in done.stderr
    assert "the same bits: 200 steps of the cascade, 200 of the attitude loops" in done.stdout
    program("arm-none-eabi-gcc")
    assert made(folder, "arm").returncode == 0


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_make_test_passes_for_every_law(law, tmp_path):
    folder = written(tmp_path / "bundle", bundle(uneven(law, law)).files)
    assert made(folder, "test").returncode == 0


@pytest.mark.slow
def test_the_golden_vectors_hold_for_a_cpp_build(tmp_path):
    written(tmp_path, usual("hybrid", "hybrid").files)
    flags = ["-x", "c++", "-std=c++11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(
        [program("g++"), *flags, "test_golden.c", "gainproof_controller.c", "-o", "cpp"], cwd=tmp_path, check=True
    )
    done = subprocess.run(["./cpp"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def mutants(source):
    """Sources with one constant of a table that is not 0 made 0.1 % larger, and where it stands."""
    for table in re.finditer(r"static const \w+ gainproof_(\w+) = \{(.*?)\};", source, re.S):
        for entry in re.finditer(r"^ +(-?[\d.]+(?:e-?\d+)?)f, /\* (.*?) \*/$", table[2], re.M):
            if float(entry[1]) == 0.0:
                continue
            start = table.start(2) + entry.start(1)
            value = np.format_float_scientific(np.float32(float(entry[1]) * 1.001))
            yield f"{table[1]}: {entry[2]}", source[:start] + value + source[start + len(entry[1]) :]


def survivors(law, folder, every):
    """Mutants that the golden vectors do not notice."""
    files = usual(law, law).files
    written(folder, files)
    gcc = program("gcc")
    flags = ("-std=c99", "-O0", *FLAGS[2:])
    subprocess.run([gcc, *flags, "-c", "test_golden.c"], cwd=folder, check=True)
    alive, count = [], 0
    for name, source in list(mutants(files["gainproof_controller.c"].decode()))[::every]:
        (folder / "mutant.c").write_text(source)
        subprocess.run([gcc, *flags, "mutant.c", "test_golden.o", "-o", "mutant", "-lm"], cwd=folder, check=True)
        done = subprocess.run(["./mutant"], cwd=folder, capture_output=True, text=True)
        assert done.returncode in (0, 1)
        alive += [name] if done.returncode == 0 else []
        count += 1
    assert count > 3
    return alive


@pytest.mark.slow
@pytest.mark.parametrize("law", ["pid", "hybrid"])
def test_golden_vectors_notice_a_constant(law, tmp_path):
    assert survivors(law, tmp_path, 6) == []


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_golden_vectors_notice_every_constant(law, tmp_path):
    assert survivors(law, tmp_path, 1) == []


@briefly
def test_bytes_are_a_function_of_the_request():
    assert bundle(uneven("hybrid", "hybrid")).files == short("hybrid", "hybrid").files


@briefly
def test_texts_name_gains_airframe_laws_and_tool():
    found = short("ladrc", "hybrid")
    for name in FILES - {"Makefile", "gainproof_controller.c"}:
        text = found.files[name].decode()
        assert all(word in text for word in (DIGEST, "hummingbird", "ladrc", "hybrid", "gainproof")), name
    assert f'#define GAINPROOF_GAINS_DIGEST "{DIGEST}"' in found.files["gainproof_controller.h"].decode()


@briefly
def test_every_gain_stands_in_the_source_with_its_unit():
    controller = uneven("pid", "hybrid")
    source = short("pid", "hybrid").files["gainproof_controller.c"].decode()
    flat = re.sub(r"\s+", " ", source)
    document = to_document(controller, {})
    for address, entry in document["gains"].items():
        found = re.search(rf"{re.escape(address)} = (\S+) ", flat)
        assert found and float(found[1]) == pytest.approx(entry["value"], rel=1e-8), address


@briefly
def test_the_delay_is_spoken_of():
    prompt = short("pid", "hybrid").files["README.md"].decode()
    late = bundle(uneven("pid", "pid", options=ControlOptions(delay=True))).files["README.md"].decode()
    assert "None is in this code" in prompt and "comes out one step after it was decided" in " ".join(late.split())


@briefly
def test_held_gains_are_floats():
    controller = uneven("pid", "hybrid")
    found = short("pid", "hybrid")
    for asked, kept in zip(controller.gains, found.held.gains, strict=True):
        assert kept == float(np.float32(asked))
    assert as_held(controller.gains, REALS["double"]) == controller.gains
    assert found.differences


@briefly
def test_rollback_without_previous_gains_is_the_defaults():
    controller = uneven("ladrc", "hybrid")
    found = short("ladrc", "hybrid")
    assert set(found.rollback) == FILES
    defaults = replace(controller, gains=tuple(default_row(controller.cascade)))
    assert found.rollback["gainproof_controller.c"].decode() == c_sources(defaults).source
    assert found.rollback["golden.h"] != found.files["golden.h"]


@briefly
def test_rollback_is_what_flew_before(tmp_path):
    before = uneven("ladrc", "ladrc")
    file = tmp_path / "gains.json"
    file.write_text(json.dumps(to_document(before, {})))
    back = bundle(uneven("hybrid", "pid"), previous=file).rollback
    assert back["gainproof_controller.c"].decode() == c_sources(read_gains(file)).source
    assert b"ladrc" in back["README.md"]
    folder = written(tmp_path / "back", back)
    assert made(folder, "test").returncode == 0


@briefly
def test_previous_gains_that_are_none_are_refused(tmp_path):
    file = tmp_path / "gains.json"
    file.write_text("{}")
    with pytest.raises(InputError, match=re.escape(os.fspath(file))):
        bundle(uneven("pid", "pid"), previous=file)
