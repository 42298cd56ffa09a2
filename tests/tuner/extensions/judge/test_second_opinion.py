"""A second opinion before arming: failures that were published, files of all firmwares, bad input, what is written."""

import pytest

import tuner
from plant.quadrotor.airframes import load
from tests.tuner.exchange.reading import write
from tuner.documents.assessment import AssessmentDocument
from tuner.extensions.judge import assessing
from tuner.extensions.judge.document import ReadBackDocument
from tuner.extensions.judge.vehicle_files import name_files, read_subjects

HEAD = "# Betaflight / STM32F7X2 (S7X2) 2026.6.0 Jul  1 2026 / 00:00:00 (abc) MSP API: 1.48\nprofile 0\n"
FILTERS = {"dterm_lpf1_static_hz": 75, "dterm_lpf1_dyn_min_hz": 75, "dterm_lpf2_static_hz": 150}
DEFAULTS = {"p_roll": 45, "i_roll": 80, "d_roll": 30, "p_pitch": 47, "i_pitch": 84, "d_pitch": 34, **FILTERS}
DOUBLED = {name: 2 * value for name, value in FILTERS.items()}
# Gains with the peak sensitivities of roll and pitch that betaflight-configurator #5406 measured, on racer5.
HEALTHY = {**DEFAULTS, "p_roll": 50, "i_roll": 89, "p_pitch": 46, "i_pitch": 83}
BY_MARGIN = {"p_roll": 129, "i_roll": 230, "p_pitch": 114, "i_pitch": 204}
# The advice before it: pi of roll 146, D halved on each axis; filters of D doubled by the coherence of a clean log.
PER_AXIS = {"p_roll": 66, "i_roll": 117, "d_roll": 15, "d_pitch": 17, **DOUBLED}
FLIGHTS = 8


@pytest.fixture(scope="module", autouse=True)
def _loops_are_read_once():
    """Read the loops of a controller once for all files that hold it."""
    judge, answers = assessing.judge_quadrotor, {}

    def remembered(controller, *asked, **named):
        flown = controller.cascade, controller.options, controller.control_period, controller.plant_step
        key = flown, controller.gains, controller.airframe.vehicle, asked, str(named)
        if key not in answers:
            answers[key] = judge(controller, *asked, **named)
        return answers[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(assessing, "judge_quadrotor", remembered)
        yield


def settings(folder, values, name, head=HEAD):
    return write(folder, head + "".join(f"set {key} = {value}\n" for key, value in values.items()), name)


def judged(folder, after, before=DEFAULTS, **options):
    files = settings(folder, after, "after.txt"), settings(folder, before, "before.txt")
    return tuner.judge(*files, **{"airframe": "racer5", "flights": FLIGHTS, **options})


def ms(opinion, channel) -> tuple[float, float]:
    loop = next(loop for loop in opinion.document.loops if loop.channel == channel)
    assert loop.before is not None and loop.before.ms is not None and loop.after.ms is not None
    return loop.before.ms, loop.after.ms


def test_gains_by_phase_margin_alone_are_refused_for_their_peak_sensitivity(tmp_path):
    """Betaflight-configurator #5406: a phase margin that is kept raised Ms in roll from 1.74 to 3.28, in pitch from 1.57 to 2.71."""
    opinion = judged(tmp_path, BY_MARGIN, HEALTHY)
    assert ms(opinion, "roll") == pytest.approx((1.74, 3.28), abs=0.01)
    assert ms(opinion, "pitch") == pytest.approx((1.57, 2.71), abs=0.02)
    assert opinion.verdict == "do not fly" and not opinion.passed
    assert [reason.partition(":")[0] for reason in opinion.document.reasons] == [
        "peak sensitivity Ms, roll",
        "peak sensitivity Ms, pitch",
    ]
    assert "#5406" in opinion.document.sentence


def test_gains_by_axis_are_refused(tmp_path):
    """Betaflight-configurator #5320: what was advised for each axis, applied to it, flew away."""
    opinion = judged(tmp_path, PER_AXIS)
    assert opinion.verdict == "do not fly" and ms(opinion, "roll")[1] > 3.0


def test_a_filter_by_coherence_is_refused_for_its_noise(tmp_path):
    """Betaflight-configurator #5258: a D filter that follows the coherence of a chirp flew away on arming."""
    opinion = judged(tmp_path, DOUBLED)
    assert opinion.verdict == "do not fly"
    assert all("D-term low-pass" in reason and "#5259" in reason for reason in opinion.document.reasons)
    noise = opinion.table.loc["noise"]
    assert noise["verdict"] == "worse" and noise["low"] > 0.4
    assert opinion.document.comparison == "worse" and "; in flight: worse: rms.tilt" in opinion.page


@pytest.mark.slow
def test_published_failures_are_refused_on_the_class_too(tmp_path):
    opinion = judged(tmp_path, DOUBLED, airframe=None, flights=64)
    assert opinion.verdict == "do not fly" and "class of a 5 inch racer" in opinion.document.sentence
    assert judged(tmp_path, BY_MARGIN, HEALTHY, airframe=None).verdict == "do not fly"


def test_a_filter_that_is_switched_off_is_refused(tmp_path):
    opinion = judged(tmp_path, {"dterm_lpf2_static_hz": 0})
    assert opinion.verdict == "do not fly" and "infinite, max 1 (150 Hz before, off after" in opinion.document.sentence


@pytest.mark.parametrize(
    ("level", "tilt", "noise", "verdict"),
    [(75, "better", "worse", "stiffer and louder"), (30, "worse", "better", "quieter and softer")],
)
def test_an_attitude_that_follows_closer_for_more_noise_is_a_trade(level, tilt, noise, verdict, tmp_path):
    opinion = judged(tmp_path, {"angle_p_gain": level}, {**DEFAULTS, "angle_p_gain": 50})
    assert opinion.table.loc["rms.tilt", "verdict"] == tilt and opinion.table.loc["noise", "verdict"] == noise
    assert opinion.verdict == verdict and opinion.passed
    # By 2 to 10 % of the noise, which was no difference by the bar of before.
    assert 0.02 < abs(opinion.table.loc["noise", "difference"]) < 0.1


@pytest.mark.parametrize("factor", [0.5, 0.8])
def test_weaker_rate_loops_are_not_better(factor, tmp_path):
    """Findings of a stranger: P, I and D halved were "better", for a breeze of 2 m/s excites little that they are for."""
    weaker = {name: round(factor * value) for name, value in DEFAULTS.items() if not name.startswith("dterm")}
    opinion = judged(tmp_path, weaker)
    assert opinion.document.comparison == "quieter and softer"
    torque = opinion.table.loc["rms.tilt (torque step)"]
    # The angle that a torque leaves goes with the gain of the rate loop.
    assert torque["difference"] > 0.8 * (1.0 / factor - 1.0) and torque["verdict"] == "worse"
    # Halved gains leave the level loop, which stays, a peak sensitivity above 2.
    assert opinion.verdict == ("do not fly" if factor == 0.5 else "quieter and softer")
    assert [row.name for row in opinion.document.further] == ["torque step", "gust", "strong manoeuvre"]


def test_a_lower_filter_is_not_refused(tmp_path):
    opinion = judged(tmp_path, {name: value - 5 for name, value in FILTERS.items()})
    assert opinion.passed and ms(opinion, "roll")[1] > ms(opinion, "roll")[0]


def test_the_same_gains_cannot_be_told_apart(tmp_path):
    opinion = judged(tmp_path, DEFAULTS)
    document = opinion.document
    assert opinion.verdict == "no practical difference" and document.changes == [] == document.unmodeled_changes
    assert all(row.difference is not None and tuple(row.difference) == (0.0, 0.0, 0.0) for row in document.metrics)


def test_one_file_is_held_against_limits_and_never_called_safe(tmp_path):
    file = settings(tmp_path, DEFAULTS, "present.txt")
    named, unnamed = (tuner.judge(file, airframe=airframe, flights=FLIGHTS) for airframe in ("racer5", None))
    assert named.document.comparison is None
    assert named.verdict == "flyable within limits" and unnamed.verdict == "no objection"
    assert "class of a 5 inch racer: mass 0.51 to 1.1 kg" in unnamed.document.sentence
    # Nothing to compare with: no word on a difference, neither in the document nor in the table.
    assert {row.verdict for row in unnamed.document.metrics} == {None} and len(unnamed.table["verdict"].dropna()) == 0
    assert "| metric | value |" in unnamed.page and "distinguishable" not in unnamed.page
    assert "paired" not in unnamed.page
    page = unnamed.page.lower()
    assert "safe" not in page and page.index("no airframe was named") < page.index("**no objection")


def test_a_changed_setting_outside_of_the_model_comes_first(tmp_path):
    opinion = judged(tmp_path, {"p_roll": 46, "f_roll": 200, "dyn_notch_count": 1})
    assert [row.name for row in opinion.document.unmodeled_changes] == ["f_roll", "dyn_notch_count"]
    assert "without 2 changed parameters outside the model" in opinion.document.sentence
    assert opinion.page.index("f_roll - to 200") < opinion.page.index(opinion.document.sentence)
    (change,) = opinion.document.changes
    assert (change.name, change.before, change.after) == ("roll.p", 45.0, 46.0)


def test_a_parameter_that_scales_the_loops_is_in_the_model(tmp_path):
    before = write(tmp_path, PX4.format(0.15), "before")
    after = write(tmp_path, PX4.format(0.15) + "1\t1\tTHR_MDL_FAC\t1.0\t9\n1\t1\tMPC_XY_VEL_MAX\t9.0\t9\n", "after")
    subjects = read_subjects(name_files(after, before, None, "f450"))
    assert [row.name for row in subjects.unmodeled_changes] == ["MPC_XY_VEL_MAX"] and subjects.before is not None
    assert subjects.after.gains["roll.authority"] != subjects.before.gains["roll.authority"]


def test_texts_of_a_file_are_no_markup(tmp_path):
    hostile = "<script>alert(1)</script>[x](http://localhost)"
    opinion = judged(tmp_path, {"name": hostile, "long": "y" * 5000})
    assert "<script>" not in opinion.page and "](" not in opinion.page
    assert max(len(row.after or "") for row in opinion.document.unmodeled_changes) < 200


def test_a_folder_holds_page_document_and_the_way_back(tmp_path):
    opinion = judged(tmp_path, {**BY_MARGIN, "d_yaw": 5}, out=tmp_path / "opinion")
    folder = opinion.folder
    assert folder is not None
    assert (folder / "rollback/before.txt").read_bytes() == (tmp_path / "before.txt").read_bytes()
    assert AssessmentDocument.read(folder / "assessment.json") == opinion.document
    assert opinion.document.not_restored == ["d_yaw"] and opinion.document.rollback == "rollback/before.txt"
    page = (folder / "judge.md").read_text()
    assert page == opinion.page and "set by hand: d_yaw" in page and "| roll | after | 3.28 |" in page
    with pytest.raises(tuner.StoreError, match="exists already"):
        judged(tmp_path, BY_MARGIN, out=folder)


def test_gains_of_a_study_are_judged_on_their_airframe(tmp_path):
    files = []
    for name, values in (("after", {**DEFAULTS, **BY_MARGIN}), ("before", HEALTHY)):
        parameters = settings(tmp_path, values, f"{name}.txt")
        options = {"loops": "own", "control_period": "0.00025", "position_every": "16"}
        tuner.import_gains(parameters, "betaflight", "racer5", tmp_path / f"{name}.json", options=options)
        files.append(tmp_path / f"{name}.json")
    opinion = tuner.judge(*files, flights=FLIGHTS)
    assert opinion.document.after.source == "gains" and opinion.document.airframe.is_known
    assert opinion.verdict == "do not fly" and ms(opinion, "roll") == pytest.approx((1.74, 3.28), abs=0.01)


CRAZYFLIE = (
    "type: persistent_param_state\nversion: '1'\nparams:\n"
    "  pid_rate.roll_kp: {is_stored: true, default_value: 250.0, stored_value: 200.0}\n"
)
PX4 = "1\t1\tMC_ROLLRATE_P\t{}\t9\n"
BAD = {
    "two firmwares": ({"after": "ATC_RAT_RLL_P,0.1\n", "before": PX4.format(0.1)}, "is a file of px4, and .* of ardupilot"),
    "two versions": ({"after": HEAD + "set p_roll = 4\n", "before": HEAD.replace("2026.6", "4.5") + "set p_roll = 4\n"}, "version"),
    "PX4 hexacopter": ({"after": PX4.format(0.1) + "1\t1\tCA_ROTOR_COUNT\t6\t6\n"}, "hexacopter"),
    "ArduPilot hexacopter": ({"after": "ATC_RAT_RLL_P,0.1\nFRAME_CLASS,2\n"}, "hexacopter"),
    "Betaflight hexacopter": ({"after": HEAD + "mixer HEX6X\nset p_roll = 4\n"}, "HEX6X"),
    "hexacopter before": ({"after": PX4.format(0.1), "before": PX4.format(0.1) + "1\t1\tCA_ROTOR_COUNT\t6\t6\n"}, "hexacopter"),
    "rates apart": (
        {"after": PX4.format(0.1) + "1\t1\tIMU_GYRO_RATEMAX\t800\t6\n", "before": PX4.format(0.1)}, "another rate",
    ),
    "nothing known": ({"after": "hello\n"}, "nothing of a known firmware"),
    "no such airframe": ({"after": PX4.format(0.1), "airframe": "zeppelin"}, "zeppelin"),
    "no such source": ({"after": PX4.format(0.1), "source": "inav"}, "inav"),
}  # fmt: skip


@pytest.mark.parametrize(("given", "words"), BAD.values(), ids=BAD)
def test_bad_input_is_a_sentence(given, words, tmp_path):
    files = [write(tmp_path, given[name], name) for name in ("after", "before") if name in given]
    options = {name: value for name, value in given.items() if name in ("airframe", "source")}
    with pytest.raises(tuner.InputError, match=words):
        tuner.judge(*files, flights=2, **options)


def test_an_airframe_that_cannot_be_is_refused(tmp_path):
    file = settings(tmp_path, DEFAULTS, "present.txt")
    heavy = load("racer5").path.read_text().replace("value = 0.752", "value = 40.0")
    airframe = write(tmp_path, heavy, "heavy.toml")
    with pytest.raises(tuner.InputError, match="no real airframe"):
        tuner.judge(file, airframe=str(airframe), flights=2)


@pytest.mark.parametrize(
    ("source", "text"),
    [
        ("px4", PX4.format(0.2)),
        ("ardupilot", "ATC_RAT_RLL_P,0.2\n"),
        ("ardupilot", "PSC_NE_POS_P,1.0\nATC_RAT_RLL_P,0.2\n"),
        ("crazyflie", CRAZYFLIE),
    ],
)
def test_a_file_of_each_firmware_is_read_in_its_native_loops(source, text, tmp_path):
    subjects = read_subjects(name_files(write(tmp_path, text), None, None, None))
    assert (subjects.source, subjects.after.gains.laws["attitude"]) == (source, source)
    assert subjects.airframe.title.startswith("class of a") and f"Read as a file of {source}" in str(subjects.guessed)


def test_a_study_as_second_argument_warns(tmp_path):
    gains = tuner.default_gains("pid")
    with pytest.warns(DeprecationWarning, match="check_requirements"), pytest.raises(tuner.InputError):
        tuner.judge(gains.write(tmp_path / "gains.json"), "quickstart")


def test_exit_codes_and_output_of_the_command(tmp_path, tuner):
    present, proposed = settings(tmp_path, HEALTHY, "present.txt"), settings(tmp_path, BY_MARGIN, "proposed.txt")
    few = ("--airframe", "racer5", "--flights", FLIGHTS)
    refused = tuner("judge", proposed, "--before", present, *few)
    assert refused.returncode == 1 and "Do not fly: peak sensitivity Ms, roll: 3.28" in refused.stdout
    same = tuner("judge", present, "--before", present, *few, "--json")
    assert same.returncode == 0
    assert AssessmentDocument.parse(same.stdout).verdict == "no practical difference"
    missing = tuner("judge", proposed, "--before", tmp_path / "none.txt", *few)
    assert missing.returncode == 2 and "none.txt" in missing.stderr
    both = tuner("judge", proposed, "--read-back", present, "--airframe", "racer5")
    assert both.returncode == 2 and "--read-back" in both.stderr


def test_read_back_by_the_command(tmp_path, tuner):
    written = settings(tmp_path, {"p_roll": 60, "d_roll": 40, "d_yaw": 3}, "written.txt")
    held = settings(tmp_path, {"p_roll": 60, "d_roll": 40, "d_yaw": 3, "f_roll": 120}, "held.txt")
    same = tuner("judge", written, "--read-back", held)
    assert same.returncode == 0 and "all 3 are as written" in same.stdout
    lacking = settings(tmp_path, {"p_roll": 45, "d_roll": 40}, "lacking.txt")
    other = tuner("judge", written, "--read-back", lacking)
    assert other.returncode == 1 and "p_roll: 60 written, 45 on the vehicle" in other.stdout
    assert "d_yaw: 3 written, missing" in other.stdout
    data = tuner("judge", written, "--read-back", lacking, "--json")
    assert data.returncode == 1 and ReadBackDocument.parse(data.stdout).compared == 3
