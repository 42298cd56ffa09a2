"""`tuner.studio`: a page that a notebook frames, and that ends on demand or with the process."""

import json
import re
import subprocess
import sys
from http.client import HTTPConnection
from urllib.parse import urlsplit

import pytest

import tuner as gainproof
from plant.errors import InputError

FRAMED = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "iframe"}


def ask(address, path="/", query=None, headers=None, content=None):
    """Status, headers and text of an answer; query: that of the address by default."""
    split = urlsplit(address)
    connection = HTTPConnection(split.hostname, split.port, timeout=60)
    body = None if content is None else json.dumps(content)
    query = split.query if query is None else query
    own = {"Content-Type": "application/json"}
    connection.request("GET" if body is None else "POST", f"{path}?{query}", body, {**own, **(headers or {})})
    response = connection.getresponse()
    answer = response.status, dict(response.getheaders()), response.read().decode()
    connection.close()
    return answer


@pytest.fixture
def page(tmp_path, capsys):
    running = gainproof.studio("dc_motor", out=tmp_path, threads=2)
    assert capsys.readouterr().out == f"Studio: {running.address}\n"
    yield running
    running.stop()


def test_a_frame_of_another_site_shows_the_page_by_its_token_alone(page):
    status, headers, text = ask(page.address, headers=FRAMED)
    assert status == 200 and "set-cookie" not in headers
    assert "frame-ancestors http://127.0.0.1:* http://localhost:*" in headers["content-security-policy"]
    script = re.search(r'src="(/studio.js\?[^"]*)"', text)
    assert script is not None
    path, _, query = script.group(1).partition("?")
    assert ask(page.address, path, query, {"Sec-Fetch-Site": "same-origin"})[0] == 200
    answered = ask(page.address, "/answer", headers={"Sec-Fetch-Site": "same-origin"}, content={"number": 1})
    assert answered[0] == 200 and json.loads(answered[2].splitlines()[-1])["last"]


@pytest.mark.parametrize("path", ["/", "/answer", "/studio.js", "/save"])
@pytest.mark.parametrize(("query", "headers"), [("token=wrong", {}), ("", FRAMED), (None, {"Host": "evil.example"})])
def test_strangers_are_refused(page, path, query, headers):
    content = {"number": 1} if path in ("/answer", "/save") else None
    assert ask(page.address, path, query, headers, content)[0] == 403


def test_a_page_of_another_site_posts_nothing_even_with_the_token(page):
    assert ask(page.address, "/answer", headers=FRAMED, content={"number": 1})[0] == 403
    assert ask(page.address, "/answer", headers={"Origin": "http://localhost:8888"}, content={"number": 1})[0] == 403


def test_a_cell_shows_frame_and_address_until_the_end(page):
    shown = page._repr_html_()
    assert f'<iframe src="{page.address}"' in shown and f'href="{page.address}"' in shown
    page.stop()
    assert not page.is_running and "<iframe" not in page._repr_html_()
    with pytest.raises(ConnectionError):
        ask(page.address)


def test_studies_and_gains_in_memory_open(tmp_path):
    study = gainproof.load_study("dc_motor")
    gains = gainproof.read_gains("dc_motor").replace({"angle.kp": 21.0})
    for given, at in ((study, 10.0), (gains, 21.0)):
        running = gainproof.studio(given, study=None if given is study else study, out=tmp_path)
        opened = json.loads(ask(running.address, "/open", content={})[2].splitlines()[-1])
        running.stop()
        assert next(gain["start"] for gain in opened["gains"] if gain["name"] == "angle.kp") == at


def test_a_missing_folder_is_refused(tmp_path):
    with pytest.raises(InputError, match="make it first"):
        gainproof.studio("dc_motor", out=tmp_path / "none")


def test_a_script_goes_on_and_its_end_ends_the_page(tmp_path):
    program = "import tuner; page = tuner.studio('dc_motor'); print('on'); print(page.is_running)"
    ended = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, encoding="utf-8", timeout=60, check=True
    )
    first, *others = ended.stdout.splitlines()
    assert first.startswith("Studio: http://127.0.0.1:") and others == ["on", "True"]
    with pytest.raises(ConnectionError):
        ask(first.removeprefix("Studio: "))
