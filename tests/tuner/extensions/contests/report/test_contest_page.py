"""The page of a contest: complete, self-contained, and every number the one that the folder holds."""

import json
import re

import numpy as np
import plotly.graph_objects as go
import pytest

from tests.tables import read_frame, write_frame
from tests.tuner.extensions.contests.report.fabricate_contest import ALL, Made, fabricate, rewrite
from tests.tuner.extensions.contests.report.reading_contest import (
    content,
    data_once,
    factor_of,
    front_rows,
    near,
    read_once,
    rows_of,
    said,
    said_once,
    shown_rows_of,
    source_of,
    stored,
    strip_rows,
    table_rows,
)
from tests.tuner.report.reading import read, resolved, strings
from tuner.documents.opening import open_results
from tuner.extensions.contests.documents import ContestFolder
from tuner.extensions.contests.run import write_contest_report
from tuner.report.labels import compared_label, in_plain_words
from tuner.report.page import asset
from tuner.text.numbers import estimate, significant


def numbers(row, value="value", low="low", high="high", signed=False):
    return estimate(row[value], row[low], row[high], signed)


def test_nothing_is_fetched(folder):
    page = read_once(folder)
    for tag, attrs, _ in page.elements:
        assert tag not in ("link", "img", "iframe", "object", "embed", "base", "form")
        assert "src" not in attrs
        assert attrs.get("href", "#").startswith("#")
    style = source_of(folder).split("<style>")[1].split("</style>")[0]
    assert "url(" not in style and "@import" not in style
    policy = next(a["content"] for t, a, _ in page.elements if a.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none'") and "http" not in policy and "*" not in policy
    assert "plotly.js (cartesian - minified) v" in page.library[:100]


def test_ids_are_unique_and_links_and_figures_find_them(folder):
    page = read_once(folder)
    assert len(set(page.ids)) == len(page.ids)
    targets = [attrs["href"][1:] for tag, attrs, _ in page.elements if tag == "a"]
    assert targets and set(targets) <= set(page.ids)
    drawn = {attrs["id"] for _, attrs, _ in page.elements if attrs.get("class") == "chart"}
    assert drawn == set(page.data["charts"])


def test_embedded_numbers_are_finite_and_names_known(folder):
    def refuse(name):
        raise AssertionError(name)

    script = next(script for script in read_once(folder).scripts if script.startswith("{"))
    data = json.loads(script, parse_constant=refuse)
    style = asset("page.css")
    for text in strings(data["charts"]):
        if re.fullmatch(r"@[a-z]+\d?(/[\d.]+)?", text):
            # Once for light, once for dark.
            assert style.count(f"--{text[1:].split('/')[0]}: #") == 2
        if text.startswith("#"):
            assert text[1:] in data["arrays"]


def test_figures_are_valid_plotly(folder):
    data = data_once(folder)
    assert data["charts"]
    for chart in data["charts"].values():
        drawn = resolved({"data": chart["traces"], "layout": chart["layout"]}, data["arrays"])
        assert all(len(trace["x"]) == len(trace["y"]) > 0 for trace in drawn["data"])
        # Plotly looks at each number of an array, and they are alike.
        assert len(go.Figure(shortened(drawn)).to_dict()["data"]) == len(chart["traces"])


def shortened(value):
    """The same with the first numbers alone of long arrays."""
    if isinstance(value, dict):
        return {key: shortened(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [shortened(entry) for entry in (value[:10] if value and isinstance(value[0], float) else value)]
    return value


def plain_names(folder):
    """The quantities of a contest in plain words, by label."""
    contest = ContestFolder(folder)
    return {label: compared_label(contest, label) for label in contest.quantity}


def test_what_was_asked_and_found_is_said_first(folder):
    text, told = said_once(folder), content(folder)
    plain = plain_names(folder)
    spoken = [in_plain_words(sentence, plain) for sentence in (told["words"][0], told["warnings"][0])]
    for sentence in (told["title"], told["description"], *spoken):
        assert 0 <= text.find(sentence) < text.index("Values on the flights of the comparison")
    for claim in told["claims"]:
        assert f"{claim['verdict']} {claim['text']}" in text
        # What the sentence of the claim says stands beside the claim.
        assert told["words"][1] not in text
        for row in claim["rows"]:
            value, ends = numbers(row, "difference", signed=True)
            assert f"{claim['better']} − {row['than']} in {plain[row['quantity']]}: {value} m {ends}" in text


def test_every_value_stands_in_the_table_with_its_interval(folder):
    told = content(folder)
    rows = [row for row in table_rows(folder, "values") if "On one scale" in row]
    assert len(rows) == len(told["quantities"])
    found = {(row["contender"], row["quantity"]): row for row in told["estimates"]}
    ordered = sorted(
        told["quantities"], key=lambda q: ("objective", "constraint", "published", "claimed").index(q["kind"])
    )
    for quantity, row in zip(ordered, rows, strict=True):
        assert row[""].startswith(plain_names(folder)[quantity["label"]])
        assert quantity["label"] in row[""] and ("`" not in row[""])
        values = {name: found[name, quantity["label"]] for name in row if name not in ("", "On one scale")}
        assert list(values) == [entry["name"] for entry in told["contenders"]]
        for name, entry in values.items():
            value, ends = numbers(entry)
            assert f"{value} {ends}" in row[name]
            broken = quantity["limit"] is not None and entry["value"] > quantity["limit"]
            assert ("✗ limit violated" in row[name]) == broken


def test_the_best_is_marked_and_who_is_not_told_apart_from_it(folder):
    told = content(folder)
    found = {(row["contender"], row["quantity"]): row["value"] for row in told["estimates"]}
    names = [entry["name"] for entry in told["contenders"]]
    for row in table_rows(folder, "values"):
        label = next(
            (
                q["label"]
                for q in told["quantities"]
                if row[""].split(" ")[-1] == q["label"] or f" {q['label']}," in row[""]
            ),
            None,
        )
        if "On one scale" not in row or label is None:
            continue
        values = {name: found[name, label] for name in names}
        least = [name for name in names if values[name] == min(values.values())]
        best = set(least) if len(least) < len(names) or len(names) == 1 else set()
        even = {
            name
            for d in told["differences"]
            if d["quantity"] == label and d["lower"] is None and {d["first"], d["second"]} & best
            for name in (d["first"], d["second"])
        } - best
        assert {name for name in names if row[name].startswith("★")} == best
        assert {name for name in names if row[name].startswith("≈")} == even


def test_every_difference_stands_in_a_forest(folder):
    told, rows = content(folder), strip_rows(folder)
    plain = plain_names(folder)
    for entry in told["differences"]:
        if not any(d["difference"] for d in told["differences"] if d["quantity"] == entry["quantity"]):
            assert "differ at all in failed flights" in said_once(folder)
            continue
        value, ends = numbers(entry, "difference", signed=True)
        mine = [
            text
            for caption, text in rows
            if caption.startswith(plain[entry["quantity"]])
            and re.match(rf"{re.escape(entry['second'])} − {re.escape(entry['first'])}[−+\d]", text)
        ]
        assert len(mine) == 1
        assert value in mine[0] and ends in mine[0]
        verdict = "≈ not distinguishable" if entry["lower"] is None else f"✓ {entry['lower']} is lower"
        assert mine[0].endswith(verdict)


def test_best_under_a_limit(folder):
    told = content(folder)
    rows = [row for row in table_rows(folder, "values") if " at most " in row[""] and "with " in row[""]]
    assert len(rows) == len(told["best_under"])
    for question, row in zip(told["best_under"], rows, strict=True):
        assert f"at most {significant(question['limit'])} " in row[""]
        for answer in question["rows"]:
            if answer["point"] is None:
                assert row[answer["contender"]].strip() == "no point satisfies it"
            else:
                value, ends = numbers(answer)
                assert f"{value} {ends} {answer['point']}" in row[answer["contender"]]
                least = min(other["value"] for other in question["rows"])
                assert row[answer["contender"]].startswith("★") == (answer["value"] == least)


def test_sizes_of_fronts(folder):
    told, rows = content(folder), table_rows(folder, "volumes")
    if told["fronts"] is None:
        assert rows == [] and "Trade-offs" not in said_once(folder)
        return
    shares = {row["contender"]: row for row in told["fronts"]["hypervolume"]}
    assert {row[""].strip() for row in rows} == set(shares)
    for row in rows:
        value, ends = numbers(shares[row[""].strip()])
        cell = row["Share of the common box (hypervolume)"]
        assert cell.strip("★≈ ").startswith(value) and ends in cell
    # The first front is made the largest, and the second is told apart from it.
    marks = [row["Share of the common box (hypervolume)"][0] for row in rows]
    assert marks[0] == "★" and marks[1:2] in ([], ["0"]) and set(marks[2:]) <= {"≈"}


def test_printed_numbers_stand_beside_ours(folder):
    told = content(folder)
    tables, pictures = table_rows(folder, "printed"), strip_rows(folder)
    airframes = {entry["name"]: entry["airframe"] for entry in told["contenders"]}
    assert sum(f"Flown on {name}" in said_once(folder) for name in set(airframes.values())) == len(
        set(airframes.values())
    )
    for cell in told["published"]:
        printed = significant(cell["value"], 6)
        mean, ends = numbers(cell, "mean", "p2_5", "p97_5")
        near = min(cell["percentile"], 100.0 - cell["percentile"])
        percentile = f"{cell['percentile']:.{1 if 0.0 < near < 9.95 else 0}f}"
        verdict = f"{'✓ inside' if cell['inside'] else '✗ outside'}, percentile {percentile}{', fitted' if cell['fitted'] else ''}"
        mine = [row for row in tables if row[""].startswith(cell["metric"]) and cell["contender"] in row]
        assert len(mine) == 1
        assert mine[0][cell["contender"]].strip() == f"printed {printed} ours {mean} {ends} {verdict}"
        median, ends = numbers(cell, "median", "p2_5", "p97_5")
        start = f"{cell['contender']}printed {printed}"
        drawn = [text for caption, text in pictures if caption.startswith(cell["metric"]) and text.startswith(start)]
        assert drawn == [f"{start}ours {median} {ends}{verdict}"]


def test_those_fitted_are_counted_apart(folder):
    told = content(folder)
    free = [cell["inside"] for cell in told["published"] if not cell["fitted"]]
    assert f"Printed numbers inside {sum(free)} of {len(free)}" in said_once(folder)
    foot = [row for row in table_rows(folder, "printed") if row[""].strip() == "Inside"]
    for name in (entry["name"] for entry in told["contenders"]):
        mine = [cell for cell in told["published"] if cell["contender"] == name]
        text = next(row[name] for row in foot if name in row)
        assert text.startswith(
            f"{sum(c['inside'] for c in mine if not c['fitted'])} of {sum(not c['fitted'] for c in mine)}"
        )
        assert ("fitted" in text) == any(cell["fitted"] for cell in mine)


def test_every_gain_cost_and_bound_is_told(folder):
    told = content(folder)
    cards = source_of(folder).split('<article class="card">')[1:]
    rows = {row[""].strip(): row for row in table_rows(folder, "contenders")}
    for entry, card in zip(told["contenders"], cards, strict=True):
        assert rows[entry["name"]]["Operations a step"].strip() == str(entry["cost"]["operations"])
        assert rows[entry["name"]]["Gains"].strip() == (f"{entry['point']} tuned" if entry["tuned"] else "as given")
        shown = dict(re.findall(r"<code>([\w.]+)</code></th><td><\w+ class=\"number\">(.*?)</", card))
        groups = {"position": "xyz", "attitude": ("roll", "pitch", "yaw"), "tilt": ("roll", "pitch")}
        spelt = {
            f"{axis}.{key.partition('.')[2]}": value
            for key, value in shown.items()
            for axis in groups.get(key.partition(".")[0], (key.partition(".")[0],))
        }
        assert spelt == {address: significant(gain["value"]) for address, gain in entry["gains"].items()}
        for name in entry["searched"]:
            bold = re.search(rf"<code>{re.escape(name)}</code></th><td><strong", card)
            # Yaw of ADRC has an observer of its own, so that the attitude is not told as one.
            assert bold or (name == "attitude.omega_o" and "tilt.omega_o" in shown)
        for bound in entry["on_bounds"]:
            assert f"{bound['variable']}</code> of the recommended point stands at the upper end 60" in card
    assert "counted instructions" in said_once(folder)


def test_provenance_is_complete(folder):
    shown, told = said_once(folder), content(folder)
    for text in (
        "tuner run studies/made.toml",
        "AMD EPYC 9R14",
        "numpy 2.4.6",
        "873a14b",
        "2025-11-21T02:41:04",
        "made.toml",
    ):
        assert text in shown
    assert "38 400 in 1 min 12 s" in shown and "gusts: 40 of 10 s each; level: 24 of 10 s each" in shown
    assert "Seed 2025" in shown
    for quantity in told["quantities"]:
        assert f"what {quantity['metric']} is" in shown


def test_fronts_stand_at_their_values(folder):
    rows, told = front_rows(folder), content(folder)
    data = data_once(folder)
    charts = data["charts"]
    pairs = {name: [int(part) for part in name.split("-")[1:]] for name in charts if re.fullmatch(r"front-\d-\d", name)}
    labels = told["fronts"]["objectives"] if told["fronts"] else []
    units = {quantity["label"]: quantity["unit"] for quantity in told["quantities"]}
    scale = [factor_of(units[label]) for label in labels]
    assert len(pairs) == len(labels) * (len(labels) - 1) // 2
    assert ("front-ranking" in charts) == (len(labels) == 1)
    for name, (i, j) in pairs.items() or ({"front-ranking": (0, 0)} if len(labels) == 1 else {}).items():
        for k, entry in enumerate(told["contenders"]):
            mine = [row for row in rows if row["contender"] == entry["name"]]
            traces = [
                resolved(t, data["arrays"]) for t in charts[name]["traces"] if t["meta"]["layer"] == f"contender-{k}"
            ]
            points = next(t for t in traces if "hovertext" in t)
            values = [[scale[axis] * float(row[f"value:{labels[axis]}"]) for row in mine] for axis in (i, j)]
            assert points["x"] == pytest.approx(values[0], rel=1e-4)
            high = [scale[i] * float(row[f"high:{labels[i]}"]) for row in mine]
            bars = next(t for t in traces if "error_x" in t)
            assert np.add(bars["x"], bars["error_x"]["array"]) == pytest.approx(high, rel=1e-3)
            if len(labels) > 1:
                assert points["y"] == pytest.approx(values[1], rel=1e-4)
                ring = next(t for t in traces if t["mode"] == "markers+text")
                chosen = [n for n, row in enumerate(mine) if row["recommended"] == "True"]
                assert ring["x"] == pytest.approx([values[0][n] for n in chosen], rel=1e-4)


def hovers(traces, k):
    return next((t["hovertext"] for t in traces if t["meta"]["layer"] == f"contender-{k}"), [])


def test_gains_of_a_front_are_under_the_pointer(folder):
    data, told, rows = data_once(folder), content(folder), front_rows(folder)
    traces = [
        resolved(t, data["arrays"]) for chart in data["charts"].values() for t in chart["traces"] if "hovertext" in t
    ]
    for k, entry in enumerate(told["contenders"]):
        mine = [row for row in rows if row["contender"] == entry["name"]]
        for text, row in zip(hovers(traces, k), mine, strict=True):
            assert row["point"] in text and ("recommended" in text) == (row["recommended"] == "True")
            assert f"position.omega_c = {significant(float(row['gain:x.omega_c']))}" in text
            first = told["fronts"]["objectives"][0]
            middle, low, high = (float(row[f"{part}:{first}"]) for part in ("value", "low", "high"))
            value, ends = estimate(middle, low, high)
            assert f"{value} {ends} m" in text


def test_distributions_are_those_of_the_scores(folder):
    data, told = data_once(folder), content(folder)
    charts = data["charts"]
    names = [entry["name"] for entry in told["contenders"]]
    number = 3 if told["quantities"][3]["metric"] == "failure" else None
    assert f"distribution-{number}" not in charts  # a quantity that is the same in every flight
    shown = {name: chart for name, chart in charts.items() if name.startswith("distribution-")}
    assert len(shown) == len(told["quantities"]) - 1
    for name, chart in shown.items():
        quantity = told["quantities"][int(name.split("-")[1])]
        for k, trace in enumerate(resolved(chart["traces"], data["arrays"])):
            flown = rows_of(folder, "scores.npz", contender=names[k], quantity=quantity["label"])
            values = factor_of(quantity["unit"]) * np.sort(flown["value"])
            # The function jumps where a trace stands to the share of values up to there; places have five digits.
            for x, y in list(zip(trace["x"], trace["y"], strict=True))[1::7]:
                shares = [100.0 * np.mean(values <= x * (1.0 + bit), axis=0) for bit in (-1e-4, 1e-4)]
                assert shares[0] - 1e-2 <= y <= shares[1] + 1e-2
            assert (trace["x"][0], trace["y"][0]) == (pytest.approx(values[0], rel=1e-4), 0.0)
            assert (trace["x"][-1], trace["y"][-1]) == (pytest.approx(values[-1], rel=1e-4), 100.0)


@pytest.mark.parametrize("signal", ["x", "yaw", "rotor3"])
def test_responses_are_those_of_the_files(folder, signal):
    data, told = data_once(folder), content(folder)
    traces = resolved(data["charts"][f"response-{signal}"]["traces"], data["arrays"])
    for k, entry in enumerate(told["contenders"]):
        for scenario in ("gusts", "level"):
            mine = [
                t for t in traces if t["meta"].get("layer") == f"contender-{k}" and t["meta"]["scenario"] == scenario
            ]
            flight = [t for t in mine if t["meta"]["part"] == "flight"]
            flown = shown_rows_of(folder, "traces.npz", contender=entry["name"], scenario=scenario, signal=signal)
            assert len(flight) == 1
            assert near(flight[0]["y"], flown["value"], 1e-4, 1e-9)
            assert near(flight[0]["x"], flown["time"], 1e-6, 1e-12)
            low, high = [t for t in mine if t["meta"]["part"] == "band"]
            fan = shown_rows_of(folder, "responses.npz", point=entry["name"], scenario=scenario, signal=signal)
            assert near(low["y"], fan["low"], 1e-4, 1e-9)
            assert near(high["y"], fan["high"], 1e-4, 1e-9) and high["fill"] == "tonexty"
            assert all(
                t["meta"].get("point")
                == (entry["airframe"] if len(told["contenders"]) == 5 else t["meta"].get("point"))
                for t in mine
            )


def test_references_are_drawn_where_all_have_the_same_and_something_is_asked(folder):
    charts = data_once(folder)["charts"]

    def scenarios(signal):
        return {t["meta"]["scenario"] for t in charts[f"response-{signal}"]["traces"] if "layer" not in t["meta"]}

    # In "level" x and y run free; roll in "gusts" is what each position loop asks for.
    alone = len(content(folder)["contenders"]) == 1
    assert scenarios("x") == {"gusts"} and scenarios("z") == scenarios("yaw") == {"gusts", "level"}
    assert scenarios("roll") == ({"gusts", "level"} if alone else {"level"})
    assert scenarios("rotor1") == set()


def test_air_that_does_not_blow_is_not_shown(folder):
    charts = data_once(folder)["charts"]
    assert "response-wind_z" not in charts
    assert [t["meta"]["scenario"] for t in charts["response-wind_x"]["traces"]] == ["gusts"]
    assert charts["response-wind_x"]["layout"]["meta"] == {"hides": True}
    air = np.degrees(rows_of(folder, "wind.npz", scenario="level", signal="angular_acceleration_z")["value"])
    drawn = resolved(charts["response-angular_acceleration_z"]["traces"][0], data_once(folder)["arrays"])
    assert drawn["y"] == pytest.approx(air, rel=1e-4)


def test_choices_are_offered_where_there_is_a_choice(folder):
    ids, told = read_once(folder).ids, content(folder)
    assert "choose-scenario" in ids
    assert ("choose-airframe" in ids) == (len({entry["airframe"] for entry in told["contenders"]}) > 1)
    layers = {attrs["data-layer"] for _, attrs, _ in read_once(folder).elements if "data-layer" in attrs}
    assert layers >= {f"contender-{k}" for k in range(len(told["contenders"]))} | {"flight", "band", "median"}


def test_same_folder_same_bytes(folder):
    before = (folder / "report.html").read_bytes()
    assert write_contest_report(folder).read_bytes() == before
    assert list(folder.glob(".*")) == []


def test_contenders_own_reports_are_linked_where_they_are(made):
    own = made / "contenders" / "pid" / "report.html"
    own.parent.mkdir(parents=True)
    own.write_text("here")
    write_contest_report(made)
    links = [attrs["href"] for tag, attrs, _ in read(made).elements if tag == "a" and not attrs["href"].startswith("#")]
    assert links == ["contenders/pid/report.html"]


def test_what_has_no_data_is_left_out(tmp_path):
    files = ("scores.npz", "fronts.csv", "responses.npz", "traces.npz", "wind.npz")
    empty = {
        "published": [],
        "claims": [],
        "best_under": [],
        "differences": [],
        "estimates": [],
        "words": [],
        "warnings": [],
    }
    folder = fabricate(tmp_path / "bare", without=files, **empty)
    write_contest_report(folder)
    page = read(folder)
    assert [i for i in page.ids if i.endswith("-title")] == ["values-title", "gains-title", "provenance-title"]
    assert page.data["charts"] == {} and "Warnings" not in said(folder)
    assert open_results(folder).fronts is None


@pytest.mark.parametrize(
    ("without", "gone"),
    [("scores.npz", "distributions"), ("fronts.csv", "fronts")],
)
def test_one_missing_file_takes_one_section_with_it(tmp_path, without, gone):
    folder = fabricate(tmp_path / "made-up", without=(without,))
    write_contest_report(folder)
    whole = {
        "values",
        "differences",
        "fronts",
        "best",
        "distributions",
        "published",
        "responses",
        "gains",
        "provenance",
    }
    assert {i.removesuffix("-title") for i in read(folder).ids if i.endswith("-title")} == whole - {gone}


def test_flights_without_fans_and_fans_without_flights(tmp_path):
    for missing, gone in (("responses.npz", {"band", "median"}), ("traces.npz", {"flight"})):
        folder = fabricate(tmp_path / missing, without=(missing,))
        write_contest_report(folder)
        offered = {attrs.get("data-layer") for _, attrs, _ in read(folder).elements}
        assert {"band", "median", "flight"} & offered == {"band", "median", "flight"} - gone
        also = {t["meta"].get("part") for t in read(folder).data["charts"]["response-x"]["traces"]}
        assert not also & gone


def test_values_that_are_all_the_same_have_no_best(tmp_path):
    folder = fabricate(tmp_path / "made-up")
    rewrite(folder, lambda c: [row.update(value=1.0, low=0.9, high=1.1) for row in c["estimates"]])
    write_contest_report(folder)
    assert not any(
        cell.startswith("★") for row in table_rows(folder, "values") if "On one scale" in row for cell in row.values()
    )


HOSTILE = "</script><script>alert(1)</script> & \"quotes\" <img src=x onerror='alert(1)'>"


def test_user_text_is_escaped(tmp_path):
    folder = fabricate(tmp_path / "made-up", Made(names=ALL))
    whole = {"PID": HOSTILE, "gusts": f"{HOSTILE}@", "hummingbird": f"<b>{HOSTILE}", "Made up for tests.": HOSTILE}

    def spoil(value):
        if isinstance(value, dict):
            return {spoil(key): spoil(entry) for key, entry in value.items()}
        if isinstance(value, list):
            return [spoil(entry) for entry in value]
        return whole.get(value, value) if isinstance(value, str) else value

    (folder / "contest.json").write_text(json.dumps(spoil(stored(folder))))

    for file in (folder / f"{name}.npz" for name in ("scores", "responses", "traces", "wind")):
        table = read_frame(file)
        for name in table.select_dtypes("string"):
            table[name] = table[name].map(lambda word: whole.get(word, word))
        write_frame(file, table)
    fronts = (folder / "fronts.csv").read_text().replace("\nPID,", '\n"' + HOSTILE.replace('"', '""') + '",')
    (folder / "fronts.csv").write_text(fronts)
    write_contest_report(folder)
    page = read(folder)
    assert sum(tag == "script" for tag, _, _ in page.elements) == 3
    assert not any(tag == "img" or any(name.startswith("on") for name in attrs) for tag, attrs, _ in page.elements)
    assert HOSTILE in page.text
    assert {f"{HOSTILE}@", f"<b>{HOSTILE}"} <= {
        attrs.get("value") for tag, attrs, _ in page.elements if tag == "option"
    }
    charts, shared = page.data["charts"], page.data["arrays"]
    # plotly.js takes a few tags in what it draws; names in `meta` and of shared arrays are only compared.
    drawn = [text for chart in charts.values() for text in strings(chart["layout"])]
    for trace in (trace for chart in charts.values() for trace in chart["traces"]):
        drawn += [text for key, value in trace.items() if key != "meta" for text in strings(value) if text[:1] != "#"]
    drawn += [text for texts in shared.values() if isinstance(texts, list) for text in texts]
    assert any("&lt;img" in text for text in drawn) and not any("<img" in text for text in drawn)


def test_tall_figures_are_no_heavier_than_needed(folder):
    assert (folder / "report.html").stat().st_size < 8e6
