"""`tuner margins` of gains of a plant of one's own: table, JSON, limits, certificates, figures, and what it refuses."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import tuner
from objectives.margins.quantities import REPORTED
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.plan import Channel
from tests.plant.model.plants import system_of
from tests.tuner.conftest import QUICKSTART
from tests.tuner.extensions.certificates.test_plant_axis import impulse
from tuner.analysis.margins.readings import plant_subject
from tuner.api.studies import load_study
from tuner.cli.main import app
from tuner.cli.printers.margins import heading
from tuner.documents.margins import MarginsDocument
from tuner.documents.opening import open_results
from tuner.extensions.certificates.peak_gain import disturbed
from tuner.extensions.certificates.plant_axis import PlantAxis
from tuner.extensions.certificates.plant_rows import plant_certificate_rows
from tuner.extensions.certificates.supertwisting import largest_rate
from tuner.gains import plant_gains_document
from tuner.store.document import json_text
from tuner.study.plant_study import PlantStudy

FOLDER = QUICKSTART.parent
MOTOR = FOLDER / "dc_motor.toml"


def asked(*arguments):
    return CliRunner().invoke(app, ["margins", *map(str, arguments)])


@pytest.fixture(scope="module")
def study():
    return load_study(MOTOR, kind=PlantStudy)


@pytest.fixture(scope="module")
def gains(study, tmp_path_factory):
    """A gains.json of the motor's default, in no results folder."""
    file = tmp_path_factory.mktemp("motor") / "gains.json"
    file.write_text(
        json_text(plant_gains_document(study.system, study.default_row, study.code_digest)), encoding="utf-8"
    )
    return file


def test_values_are_those_of_the_report_and_limits_those_of_the_study(gains, study, tmp_path):
    told = asked(gains, "--study", MOTOR, "--json", "--certificates", "--out", tmp_path / "out")
    content = json.loads(told.stdout)
    assert told.exit_code == (0 if content["passed"] else 1)
    assert content["plant"] == "dc_motor" and content["channel_laws"] == {"angle": "pid"} and "airframe" not in content
    assert content["limit_cycles"] == []
    (channel,) = content["channels"]
    assert list(channel["quantities"]) == list(REPORTED)
    margins = study.margin_model().evaluate(study.default_row[None])
    assert channel["quantities"]["ms"]["value"] == pytest.approx(margins.sensitivity.value[0, 0], rel=1e-9)
    assert [(row["label"], row["limit"]) for row in content["requirements"]] == [("ms", 1.8)]
    assert [row["name"] for row in content["certificates"]] == ["peak_gain", "common_lyapunov"]
    assert content["certificates"][0]["unit"] == "rad/(N m)"
    kept = MarginsDocument.read(tmp_path / "out" / "margins.json")
    assert kept.content() == content
    assert {file.stem for file in (tmp_path / "out").glob("*.png")} == {"bode", "nyquist", "nichols"}
    assert open_results(tmp_path / "out").document.plant == "dc_motor"


def test_without_a_results_folder_a_study_says_what_the_loops_are(gains, study):
    found = tuner.margins(gains, study=study)
    assert found.from_study and found.table.index.tolist() == ["angle"]
    with pytest.raises(tuner.InputError, match="lies in no results folder"):
        tuner.margins(gains)


def test_what_is_of_quadrotors_or_of_another_plant_is_refused(gains, study):
    assert "pid on dc_motor" in asked(gains, "--study", MOTOR).stdout
    with pytest.raises(tuner.InputError, match="quadrotors; leave them out"):
        tuner.margins(gains, study=study, yaw=0.1)
    with pytest.raises(tuner.InputError, match="a study of a quadrotor"):
        tuner.margins(gains, study=QUICKSTART)
    with pytest.raises(tuner.InputError, match="channels angle instead of position"):
        tuner.margins(gains, study=FOLDER / "two_masses.toml")


def test_proofs_of_super_twisting_count_the_plant_as_it_is_driven():
    """With b0 right the largest rate is that of the law alone; a plant that answers twice as strongly has twice the gains."""
    found = []
    for b0 in (50.0, 25.0):
        channel = Channel("angle", LAWS["supertwisting"], "angle", "torque", b0=b0, rate_output="speed")
        system = system_of("pendulum", [channel], [], Timing(0.002, 0.001))
        (row,) = plant_certificate_rows(plant_subject(system, np.array([5.0, 20.0, 60.0])))
        found.append(row.value)
    assert found == pytest.approx([largest_rate(20.0, 60.0).value, largest_rate(40.0, 120.0).value], rel=1e-6)


def test_a_process_whose_output_answers_a_disturbance_at_once_has_bounds_too():
    study = load_study(FOLDER / "dead_time.toml", kind=PlantStudy)
    rows = plant_certificate_rows(plant_subject(study.system, study.default_row))
    assert [row.name for row in rows] == ["peak_gain", "peak_gain", "common_lyapunov"]
    # What shifts the output is in it before any controller answers, and then comes what the controller makes of it.
    answer = disturbed(PlantAxis(study.system, tuple(study.default_row), "level", "shift"))
    t = np.linspace(0.0, 60.0, 60_001)
    afterwards = float(np.trapezoid(np.abs(impulse(answer, t)), t))
    assert rows[1].value is not None and 1.0 + afterwards < rows[1].value < 1.0 + 2.0 * afterwards


def test_the_load_index_of_a_plant_has_the_units_of_its_channel():
    motor, vehicle = (MarginsDocument.model_construct(plant=plant) for plant in ("dc_motor", None))
    assert heading("load_index", "s^-3", motor) == "load [input/(output s)]"
    assert heading("load_index", "s^-3", vehicle) == "load [s^-3]"
    assert heading("phase_margin", "deg", motor) == "phase [deg]"
