"""The door: strangers, long messages and settings outside the range are refused in a sentence; stale answers are not sent."""

import json
import socket
from concurrent.futures import ThreadPoolExecutor
from time import sleep

import pytest

from tuner.extensions.studio.guard import HOST, MAX_BYTES

TOKENLESS = {"x-studio-token": None}


def test_the_first_address_sets_a_cookie_and_hides_the_token(client):
    status, headers, _ = client.ask(f"/?token={client.door.token}", headers=TOKENLESS)
    assert status == 303 and headers["location"] == "/"
    cookie = headers["set-cookie"]
    assert "HttpOnly" in cookie and "SameSite=strict" in cookie
    status, headers, text = client.ask("/", headers={**TOKENLESS, "Cookie": cookie.partition(";")[0]})
    assert status == 200 and client.door.token not in text.decode()
    assert (
        "script-src 'self';" in headers["content-security-policy"]
        and "unsafe-inline'; img" in headers["content-security-policy"]
    )


@pytest.mark.parametrize(
    ("headers", "words"),
    [
        ({"x-studio-token": "wrong"}, "holds the token"),
        ({"x-studio-token": None}, "holds the token"),
        ({"x-studio-token": None, "Cookie": "studio-1=x"}, "holds the token"),
        ({"Host": "evil.example:80"}, "this machine alone"),
        ({"Host": "127.0.0.1"}, "this machine alone"),
        ({"Origin": "http://evil.example"}, "other pages"),
        ({"Origin": "null"}, "other pages"),
        ({"Sec-Fetch-Site": "cross-site"}, "other pages"),
    ],
)
@pytest.mark.parametrize("path", ["/", "/answer", "/save", "/studio.js"])
def test_strangers_are_refused(client, path, headers, words):
    status, _, text = client.ask(path, {"number": 1}, headers=headers)
    assert status == 403 and words in text.decode()


def test_other_methods_are_refused(client):
    assert client.ask("/", method="PUT")[0] == 405


def test_long_messages_are_refused_announced_or_not(client):
    assert client.ask("/answer", body=b"x" * (MAX_BYTES + 1))[0] == 413
    with socket.create_connection((HOST, client.door.port), timeout=20) as raw:
        head = (
            f"POST /answer HTTP/1.1\r\nHost: {HOST}:{client.door.port}\r\nx-studio-token: {client.door.token}\r\n"
            "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n"
        )
        raw.sendall(head.encode())
        part = b"10000\r\n" + b"x" * 0x10000 + b"\r\n"
        try:
            for _ in range(4):
                raw.sendall(part)
            answered = raw.recv(64)
        except ConnectionError:
            answered = b"HTTP/1.1 413"
    assert b" 413" in answered


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"values": {"angle.kp": 61.0}}, "angle.kp: given 61; allowed: 1 to 60. Widen the range in the study's"),
        ({"values": {"angle.kp": "7"}}, "angle.kp: allowed: a finite number"),
        (
            {"values": {"angle.zeta": 1.0}},
            "angle.zeta: no gain of this study; its gains are angle.kp, angle.ki, angle.kd",
        ),
        ({"values": [1]}, "values: given a list"),
        ({"scenario": 1}, "scenario: allowed: a whole number from 0 to 0"),
        ({"number": -1}, "number: allowed"),
        ({"channel": "speed"}, "unknown loop 'speed'"),
        ({"pins": [{}] * 5}, "pins: allowed: a list of at most 4"),
        ({"pins": [{"name": "x" * 41}]}, "pins.0.name: allowed: a text of at most 40 letters"),
        ([], "message: given a list"),
    ],
)
def test_a_wrong_message_is_refused_in_a_sentence(client, content, words):
    status, _, text = client.ask("/answer", content)
    assert status == 400 and words in json.loads(text)["error"]


@pytest.mark.parametrize("body", [b"{", b"\xff", b"[" * 30_000, b'{"number": NaN}'])
def test_what_is_no_json_is_refused(client, body):
    status, _, text = client.ask("/answer", body=body)
    assert status == 400 and "error" in json.loads(text)


def test_a_form_of_another_site_is_no_message(client):
    assert client.ask("/answer", body=b"{}", headers={"Content-Type": "text/plain"})[0] == 400


def test_an_answer_comes_in_three_stages(client):
    answers = client.lines("/answer", {"number": 1, "page": "three", "values": {"angle.kp": 20.0}})
    assert [each["flights"] for each in answers] == [16, 64, 256]
    assert all(each["number"] == 1 for each in answers) and answers[-1]["last"]


@pytest.mark.parametrize("moves", [300, pytest.param(1000, marks=pytest.mark.slow)])
def test_moves_leave_no_stale_answer(client, moves):
    """Requests of one page at once: those overtaken end early, and the newest alone comes to its end."""
    contents = [
        {"number": i, "page": "moves", "values": {"angle.kp": 1.0 + 45.0 * i / moves}} for i in range(1, moves + 1)
    ]
    with ThreadPoolExecutor(24) as pool:
        answers = list(pool.map(lambda content: client.lines("/answer", content), contents))
    ended = [i for i, each in enumerate(answers, start=1) if each and each[-1]["last"]]
    assert ended == [moves]
    assert all(message["number"] == i for i, each in enumerate(answers, start=1) for message in each)


def test_pages_do_not_overtake_each_other(client):
    first = client.lines("/answer", {"number": 50, "page": "one", "values": {}})
    second = client.lines("/answer", {"number": 1, "page": "two", "values": {}})
    assert len(first) == len(second) == 3


def test_gains_are_saved_into_the_folder_alone(client, out):
    content = {"number": 1, "values": {"angle.kp": 33.0}, "file": "saved.json"}
    (answer,) = client.lines("/save", content)
    assert str(out / "saved.json") in answer["text"]
    assert json.loads((out / "saved.json").read_text())["gains"]["angle.kp"]["value"] == 33.0
    (again,) = client.lines("/save", content)
    assert "exists already and was not touched" in again["error"]


@pytest.mark.parametrize("name", ["../x.json", "/tmp/x.json", ".x.json", "a/b.json", "x.txt", "", "x\n.json", 3])
def test_a_name_with_folders_is_refused(client, out, name):
    before = sorted(out.rglob("*"))
    (answer,) = client.lines("/save", {"number": 1, "values": {}, "file": name})
    assert "error" in answer and sorted(out.rglob("*")) == before


def test_a_texts_of_the_study_are_escaped(client):
    page = client.ask("/")[2].decode()
    assert "<script>" not in page and page.count("<script") == 2


def test_each_page_has_its_own_setting(client):
    """Two browsers on one studio: the answers to one are those that it would have alone."""
    alone = client.lines("/answer", {"number": 1, "page": "alone", "values": {"angle.kp": 31.0}})[-1]
    contents = [{"number": 7, "page": f"tab {i}", "values": {"angle.kp": 31.0 + i}} for i in range(4)]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda content: client.lines("/answer", content), contents))
    assert [[each["flights"] for each in answers] for answers in together] == [[16, 64, 256]] * 4
    assert together[0][-1]["rows"] == alone["rows"]
    assert len({answers[-1]["rows"][0]["here"][0] for answers in together}) > 1


def test_a_closed_page_frees_its_work(motor):
    bench, client = motor
    problem = bench.flights.problem
    before = problem.flights_made
    body = json.dumps({"number": 1, "page": "closed", "values": {"angle.kp": 47.0}}).encode()
    head = (
        f"POST /answer HTTP/1.1\r\nHost: {HOST}:{client.door.port}\r\nx-studio-token: {client.door.token}\r\n"
        f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
    )
    with socket.create_connection((HOST, client.door.port), timeout=20) as raw:
        raw.sendall(head.encode() + body)
        assert b" 200 " in raw.recv(64)
    sleep(1.5)
    # A whole answer makes 256 flights of the new setting.
    assert problem.flights_made - before <= 64
    assert len(client.lines("/answer", {"number": 1, "page": "other", "values": {}})) == 3


def test_ten_megabytes_are_refused_before_they_are_read(client):
    head = (
        f"POST /answer HTTP/1.1\r\nHost: {HOST}:{client.door.port}\r\nx-studio-token: {client.door.token}\r\n"
        "Content-Type: application/json\r\nContent-Length: 10000000\r\n\r\n"
    )
    with socket.create_connection((HOST, client.door.port), timeout=20) as raw:
        raw.sendall(head.encode())
        assert b" 413 " in raw.recv(64)


def test_ten_megabytes_of_wrong_messages_leave_the_page_at_work(client):
    """Deep tables, long names and long numbers within the limit of one message."""
    size = MAX_BYTES - 100
    bodies = [
        b'{"values": {"' + b"x" * size + b'": 1}}',
        b'{"number": ' + b"9" * size + b"}",
        b'{"pins": ' + b"[" * (size // 2) + b"]" * (size // 2) + b"}",
        b'{"channel": "' + b"\\u0000" * (size // 6) + b'"}',
    ]
    for _ in range(40):
        for body in bodies:
            status, _, text = client.ask("/answer", body=body)
            assert status == 400 and len(json.loads(text)["error"]) < 400
    assert len(client.lines("/answer", {"number": 1, "page": "after", "values": {}})) == 3
