"""`tuner check` of every kind of file, and what it says of a study before anything flies, against independent figures."""

import json
import re
import shutil
from math import atan, cos, degrees, exp, hypot, log, pi, radians, sin, sqrt, tan

import numpy as np
import pytest

import tuner as api
from objectives.margins.margins import MarginModel
from objectives.margins.trim import Trim
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import AXES
from plant.vectors import Vec3
from tests.tuner.conftest import QUICKSTART
from tests.tuner.extensions.contests.experiments.contest_text import write as write_contest
from tests.tuner.in_process import tuner
from tests.tuner.study.study_text import STUDY, changed, write
from tuner.experiments.planning import study_preview
from tuner.gains import to_document
from tuner.study.build import load_study
from tuner.study.files import SHIPPED
from tuner.study.margins import MarginAnalysis
from tuner.text.errors import USER_ERROR

MARGINS = '\n[[margin]]\nquantity = "phase_margin"\naxis = "attitude"\nmin = {}\n\n[[margin]]\nquantity = "gain_margin"\nmin = 1\n'
HUMMINGBIRD = load("hummingbird")


@pytest.fixture
def checked_once(monkeypatch):
    """Work out the answer about a file once for its document and its text on the terminal; it takes a second."""
    check, answers = api.check, {}

    def remembered(file, changes=None, watcher=None):
        key = str(file), file.read_bytes() if file.is_file() else b"", str(changes)
        if key not in answers:
            answers[key] = check(file, changes=changes, watcher=watcher)
        return answers[key]

    monkeypatch.setattr(api, "check", remembered)


@pytest.fixture
def checked(checked_once, monkeypatch, capsys):
    """Check a file; return exit code, the document and standard error."""

    def check(file):
        code, out, err = tuner(monkeypatch, capsys, "check", file, "--json")
        return code, json.loads(out) if out else None, err

    return check


@pytest.fixture
def answer(checked_once, monkeypatch, capsys):
    """Check a file and return exit code and what the terminal shows, blanks made one."""

    def check(file):
        monkeypatch.setenv("COLUMNS", "160")
        code, out, _ = tuner(monkeypatch, capsys, "check", file)
        return code, re.sub(r" +", " ", out)

    return check


@pytest.fixture
def undesigned(monkeypatch):
    """Design no gains where no assertion reads the design, which takes a second."""
    monkeypatch.setattr("tuner.experiments.tuning.diagnosis.study_designs", lambda study: {})


def bisect(function, low, high):
    """Return the root of a function that changes its sign between two places."""
    below = function(low) < 0.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (function(middle) < 0.0) == below else (low, middle)
    return 0.5 * (low + high)


def tilt_by_hand(vehicle, wind):
    """Tilt [rad] and thrust over weight of a vehicle pitched into a wind along its x axis: the balance of forces, solved alone."""

    def forces(pitch):
        along, up = wind * cos(pitch), wind * sin(pitch)
        drag_x = (vehicle.drag_linear.x + vehicle.drag_quadratic.x * wind) * along
        drag_z = (vehicle.drag_linear.z + vehicle.drag_quadratic.z * wind) * up
        # World components; what is left over the thrust, along the body's z axis (sin, cos), has to carry weight and drag.
        push = drag_x * cos(pitch) + drag_z * sin(pitch)
        lift = vehicle.mass * vehicle.gravity + drag_x * sin(pitch) - drag_z * cos(pitch)
        return push, lift

    pitch = bisect(lambda angle: forces(angle)[0] + forces(angle)[1] * tan(angle), -1.5, 0.0)
    return abs(pitch), hypot(*forces(pitch)) / (vehicle.mass * vehicle.gravity)


@pytest.mark.parametrize(("wind_20", "narrow"), [(7.0, False), (11.0, True)])
def test_the_trim_in_the_mean_wind_is_the_balance_of_forces(wind_20, narrow, checked, answer, tmp_path):
    air = f"intensity = {wind_20}\nwind_direction_deg = 0"
    path = write(tmp_path, changed('intensity = "light"', air))
    code, figures, _ = checked(path)
    (row,) = figures["trim"]
    wind = load_study(path).scenarios[0].spec.air.wind_speed
    tilt, thrust = tilt_by_hand(HUMMINGBIRD.vehicle, wind)
    assert (code, row["wind"], row["held"]) == (0, wind, True)
    assert row["tilt"] == pytest.approx(tilt, abs=1e-8) and row["thrust"] == pytest.approx(thrust, rel=1e-9)
    assert row["margin"] == pytest.approx(radians(30.0) - tilt, abs=1e-8)
    left = f"leaves {30.0 - degrees(tilt):.1f} deg to the tilt limit"
    assert narrow == (30.0 - degrees(tilt) < 5.0) == any(left in text for text in figures["problems"])
    _, out = answer(path)
    assert (
        f"tilt {degrees(tilt):.1f} deg" in out
        and f"thrust {thrust:.2f} times the weight" in out
        and (left in out) == narrow
    )


def test_a_mean_wind_beyond_the_tilt_limit_is_refused_or_hopeless(monkeypatch, capsys, tmp_path):
    code, out, err = tuner(
        monkeypatch, capsys, "check", write(tmp_path, changed('intensity = "light"', 'intensity = "moderate"'))
    )
    assert code in (1, 2) and "mean wind" in out + err and "mean_wind = false" in out + err


def test_no_trim_is_told_where_no_mean_wind_blows(checked, tmp_path):
    path = write(tmp_path, changed('intensity = "light"', 'intensity = "moderate"\nmean_wind = false'))
    code, figures, _ = checked(path)
    assert (code, figures["trim"], figures["problems"]) == (0, [], [])


def test_the_vehicle_is_told(checked, answer, tmp_path):
    code, figures, _ = checked(write(tmp_path, STUDY))
    vehicle = HUMMINGBIRD.vehicle
    weight, most = vehicle.mass * vehicle.gravity, 4.0 * vehicle.thrust_coefficient * vehicle.speed_max**2
    hover = sqrt(weight / (4.0 * vehicle.thrust_coefficient))
    assert code == 0 and figures["kind"] == "study"
    assert figures["vehicle"]["thrust_to_weight"] == {"value": pytest.approx(most / weight), "unit": "1"}
    assert figures["vehicle"]["hover_speed"] == {"value": pytest.approx(hover), "unit": "rad/s"}
    _, out = answer(write(tmp_path, STUDY))
    assert f"thrust-to-weight {most / weight:.2f}, hovers at {hover:.0f} rad/s" in out


def test_the_defaults_margins_are_told_loop_by_loop_against_the_limits(checked, answer, tmp_path):
    path = write(tmp_path, STUDY + MARGINS.format(20))
    _, figures, _ = checked(path)
    study = load_study(path)
    system = study.system
    speed = study.scenarios[0].spec.air.wind_speed
    trims = [Trim(), *[Trim(wind=Vec3(speed * cos(way), speed * sin(way), 0.0)) for way in (0.0, pi / 4, pi / 2)]]
    models = [MarginModel(system.cascade, system.nominal, system.timing, system.vehicle, trim) for trim in trims]
    each = [model.evaluate(study.default_row[None]) for model in models]
    phase = np.min([margins.phase.value[0] for margins in each], axis=0)
    gain = np.min([[margins.gain_up.value[0], margins.gain_down.value[0]] for margins in each], axis=(0, 1))
    assert np.any(phase < 0.99 * each[0].phase.value[0]), "a trim decides somewhere"
    expected = {("phase_margin(attitude)", axis): phase[AXES.index(axis)] for axis in ("roll", "pitch", "yaw")}
    expected |= {("gain_margin", axis): gain[AXES.index(axis)] for axis in AXES}
    found = {(row["label"], row["loop"]): row["value"] for row in figures["default"]}
    assert found == {key: pytest.approx(value) for key, value in expected.items()}
    assert {row["state"] for row in figures["default"]} > {"hover"}
    assert all(row["kept"] == (row["value"] >= row["limit"]) for row in figures["default"])
    _, out = answer(path)
    assert f"{degrees(phase[5]):.3g}" in next(
        line for line in out.splitlines() if line.strip().startswith("phase_margin(attitude)")
    )


def test_a_limit_that_nothing_searched_moves_is_hopeless_before_any_flight(checked, answer, tmp_path):
    fixed = changed('"roll.k1" = 20.0', '"roll.k1" = 20.0\n"yaw.lambda" = 100.0\n"yaw.omega_o" = 60.0')
    path = write(tmp_path, fixed + MARGINS.format(20))
    code, figures, _ = checked(path)
    assert code == 1
    found = next(entry for entry in figures["out_of_reach"] if entry["label"] == "phase_margin(attitude)")
    assert found["loop"] == "yaw" and found["certain"] and found["moved_by"] == []
    fixed_gains = {entry["gain"]: entry["value"] for entry in found["fixed"]}
    assert fixed_gains["yaw.lambda"] == 100.0 and all(name.startswith("yaw.") for name in fixed_gains)
    assert found["design"]["value"] > radians(20.0)
    _, out = answer(path)
    assert "Problem: phase_margin(attitude) at least 20 deg is not reached in the yaw loop in 129 draws: " in out
    assert "`tuner design` reaches" in out


def test_the_fixed_gains_that_decide_a_loop_are_named_and_no_searched_one_that_can_only_upset_it(
    checked, answer, undesigned, tmp_path
):
    """A position loop at the fast end of its range upsets every loop below it, and mends the margin of none."""
    gains = '"roll.k1" = 20.0\n"yaw.lambda" = 30.0\n"yaw.omega_o" = 12.0\n"yaw.k1" = 30.0\n"position.omega_c" = { low = 0.5, high = 60 }'
    path = write(tmp_path, changed('"roll.k1" = 20.0', gains) + MARGINS.format(35).replace("attitude", "yaw"))
    study = load_study(path)
    system, margin, wind = study.system, "phase_margin(yaw)", Vec3(study.scenarios[0].spec.air.wind_speed, 0.0, 0.0)
    model = MarginModel(system.cascade, system.nominal, system.timing, system.vehicle, Trim(wind=wind))
    fastest = study.space.point(study.default_row)
    fastest[[entry.name for entry in study.space.variables].index("position.omega_c")] = 1.0
    assert model.evaluate(study.space.gains(fastest[None])).phase.value[0, AXES.index("yaw")] == 0.0
    _, figures, _ = checked(path)
    found = next(entry for entry in figures["out_of_reach"] if entry["label"] == margin)
    assert found["reached"] > radians(20.0) and found["moved_by"] == []
    assert {"yaw.k1", "yaw.lambda"} <= {entry["gain"] for entry in found["fixed"]}
    _, out = answer(path)
    problem = out[out.index(f"Problem: {margin} at least 35 deg is not reached") :].replace("\n", " ")
    assert "fixed by the study and decide this loop: write " in problem and '"yaw.k1" = {}' in problem


def test_a_limit_that_no_draw_keeps_although_gains_move_it_is_a_warning_that_claims_no_more(checked, tmp_path):
    """129 draws are no proof: studies whose limit none of them kept had 81 % of a search's candidates within it."""
    text = QUICKSTART.read_text(encoding="utf-8")
    assert "min = 35 " in text
    path = tmp_path / "steep.toml"
    path.write_text(text.replace("min = 35 ", "min = 89 ", 1), encoding="utf-8")
    code, figures, _ = checked(path)
    assert figures["out_of_reach"] and not any(entry["certain"] for entry in figures["out_of_reach"])
    assert (code, figures["problems"]) == (0, [])
    begin = "phase_margin at least 89 deg is not reached in the yaw loop in 129 draws: "
    assert any(text.startswith(begin) for text in figures["warnings"])


def test_a_limit_that_searched_gains_hardly_move_is_hopeless(checked, undesigned, tmp_path):
    code, figures, _ = checked(write(tmp_path, STUDY + MARGINS.format(89).replace("attitude", "roll")))
    assert code == 1 and figures["problems"] and figures["out_of_reach"][0]["certain"]


def test_a_limit_that_the_default_keeps_is_in_reach_without_a_draw(monkeypatch, tmp_path):
    study = load_study(write(tmp_path, STUDY + MARGINS.format(1)))

    def no_draw(*_):
        raise AssertionError("a limit that the default keeps needs no draw")

    monkeypatch.setattr(study_preview, "latin_hypercube", no_draw)
    assert study_preview.study_preview(study).out_of_reach == []


def test_a_draw_that_keeps_what_the_default_breaks_takes_no_margins_in_trims(monkeypatch, checked):
    """Draws are compared at hover: 129 candidates in four trims took 15 s of processor time for PX4's loops."""
    rows = []
    of_trim = MarginAnalysis.values
    monkeypatch.setattr(MarginAnalysis, "values", lambda self, gains: rows.append(len(gains)) or of_trim(self, gains))
    code, figures, _ = checked(QUICKSTART)
    broken = {row["label"] for row in figures["default"] if not row["kept"]}
    assert code == 0 and "phase_margin" in broken and figures["out_of_reach"] == []
    assert max(rows, default=0) <= 1


@pytest.mark.parametrize("name", ["px4", "payload_and_battery"])
def test_the_default_is_read_at_hover_where_its_margins_in_trims_take_long(name, checked, answer):
    code, figures, _ = checked(SHIPPED / f"{name}.toml")
    assert code == 0 and figures["default"] and all("state" not in row for row in figures["default"])
    assert "The default gains at hover, before any flight" in answer(SHIPPED / f"{name}.toml")[1]


PLANT = """
title = "A plant with a pole at 3 1/s"
seed = 1

[plant]
transfer_function = {{ numerator = [{gain}], denominator = [1.0, -3.0] }}
control_period = 0.01

[[channel]]
name = "y"
law = "pid"
output = "y"
to = "u"
b0 = {b0}
lost_beyond = 100.0

[[actuator]]
name = "u"
low = -1000.0
high = 1000.0

[gains]
"y.kp" = {{ low = 0.5, high = 20.0, default = {kp} }}
"y.ki" = 0.0
"y.kd" = 0.0
"y.t_f" = 0.01

[[scenario]]
name = "step"
duration = 1.0
reference.y = {{ kind = "step", size = 1.0 }}

[[objective]]
metric = "itae.y"
"""


@pytest.mark.parametrize(("gain", "b0", "kp", "stable"), [(1, 1, 9, -1), (1, -1, 9, 1), (1, 1, 2, 0), (-1, 1, 9, 1)])
def test_an_unstable_default_of_a_plant_has_its_pole_and_the_other_sign_of_b0(
    gain, b0, kp, stable, checked, answer, tmp_path
):
    """y' = 3 y + g u, sampled each h with u = -k y, k = kp/b0: the pole is z = e^(3h) - g k (e^(3h) - 1)/3."""
    path = tmp_path / "own.toml"
    path.write_text(PLANT.format(gain=float(gain), b0=float(b0), kp=float(kp)), encoding="utf-8")
    code, figures, _ = checked(path)
    grown = exp(3.0 * 0.01)
    pole = log(grown - gain * kp / b0 * (grown - 1.0) / 3.0) / 0.01
    if stable == -1:
        assert pole < 0.0 and (code, figures["unstable"]) == (0, [])
        return
    (loop,) = figures["unstable"]
    assert loop["channels"] == ["y"] and loop["growth"] == pytest.approx(pole, rel=1e-6) and loop["frequency"] == 0.0
    _, out = answer(path)
    out = re.sub(r"\s+", " ", out)
    assert f"The default is not stable in channel y: a pole at {pole:.3g} 1/s" in out
    if stable:
        assert code == 1 and loop["other_sign"] == {"channel": "y", "b0": -b0}
        assert f"With b0 = {-b0} in channel y it is stable." in out and "Problem: The default" in out
    else:
        assert code == 0 and "other_sign" not in loop and "is not stable either" in out


def test_an_unstable_default_of_a_quadrotor_is_named_at_hover(checked, tmp_path):
    fixed = changed('"roll.k1" = 20.0', '"roll.k1" = 20.0\n"yaw.lambda" = 100.0\n"yaw.omega_o" = 60.0')
    _, figures, _ = checked(write(tmp_path, fixed + MARGINS.format(20)))
    assert all(loop["growth"] > 0.0 for loop in figures["unstable"])
    unstable = {row["loop"] for row in figures["default"] if row["label"].startswith("phase") and row["value"] == 0.0}
    assert {channel for loop in figures["unstable"] for channel in loop["channels"]} <= unstable


def test_a_limit_that_a_draw_keeps_is_no_problem(checked, tmp_path):
    code, figures, _ = checked(write(tmp_path, STUDY + MARGINS.format(1)))
    assert code == 0 and figures["out_of_reach"] == [] and figures["problems"] == []


def test_an_airframe_is_checked_as_one(checked, answer, tmp_path):
    path = tmp_path / "own.toml"
    shutil.copy(HUMMINGBIRD.path, path)
    code, figures, _ = checked(path)
    assert code == 0 and figures["kind"] == "airframe" and figures["name"] == "own"
    assert figures["thrust_to_weight"]["value"] > 1.0
    assert "thrust_to_weight" in answer(path)[1]
    path.write_text(path.read_text().replace("mass = { value = 0.698", "mass = { value = 698"))
    code, _, err = checked(path)
    assert code == 2 and "own.toml" in err and "thrust" in err
    path.write_text("allow_unphysical = true\n" + path.read_text())
    assert checked(path)[0] == 0


def test_gains_are_checked_as_gains(checked, answer, tmp_path):
    study = load_study(write(tmp_path, STUDY))
    path = tmp_path / "gains.json"
    document = to_document(study.controller(study.default_row), {})
    path.write_text(json.dumps(document))
    code, figures, _ = checked(path)
    assert code == 0 and figures["valid"]
    assert "--requirements STUDY" in answer(path)[1]
    path.write_text(json.dumps({**document, "gains": {}}))
    assert checked(path)[0] == 2


def test_a_contest_is_checked_as_one(checked, tmp_path):
    code, figures, _ = checked(write_contest(tmp_path))
    assert code == 0 and figures["kind"] == "contest" and figures["contenders"]


def test_a_folder_is_told_where_to_go(checked, tmp_path):
    code, _, err = checked(tmp_path)
    assert code == 2 and "tuner show" in err


def test_automatic_limits_are_told_with_their_key(checked, answer, tmp_path):
    path = write(tmp_path, STUDY)
    _, figures, _ = checked(path)
    # A step of 1 m at 0.5 s of 2 s.
    (row,) = figures["automatic_limits"]
    assert row == {
        "label": "quantile50(rms.position)@gusts",
        "unit": "m",
        "limit": pytest.approx(0.7 * sqrt(0.75), rel=1e-3),
        "key": "mission.followed",
    }
    assert "quantile50(rms.position)@gusts at most 0.6062 m (automatic: mission.followed)" in answer(path)[1]


def test_the_shipped_quickstart_is_fine(checked):
    code, figures, _ = checked(QUICKSTART)
    assert code == 0 and figures["out_of_reach"] == []
    limit = atan(load_study(QUICKSTART).system.nominal.tilt_tangent)
    assert all(row["tilt"] < limit for row in figures["trim"])


def test_check_and_plan_take_changes_of_a_study_and_of_nothing_else(undesigned, monkeypatch, capsys, tmp_path):
    code, out, _ = tuner(monkeypatch, capsys, "check", QUICKSTART, "--set", "margin.0.min=89", "--json")
    assert code == 0 and "at least 89 deg" in out
    (tmp_path / "law.py").write_text("LAW = 1\n")
    code, _, err = tuner(monkeypatch, capsys, "check", tmp_path / "law.py", "--set", "margin.0.min=89")
    assert code == USER_ERROR and "values are replaced in studies alone" in err
    code, _, err = tuner(monkeypatch, capsys, "plan", QUICKSTART, "--set", "nothing.at=1")
    assert code == USER_ERROR and "nothing" in err
