"""Bytes that reports cache next to the kernels: made once, healed where damaged, and not missed where nothing can be kept."""

import gzip
from base64 import b64decode

import pytest
from plotly.offline import get_plotlyjs

from tuner.report import page
from tuner.report.byte_cache import cached


@pytest.fixture
def made(tmp_path, monkeypatch):
    """The names that something was made for, in a cache folder of their own."""
    monkeypatch.setenv("TUNER_CACHE_DIR", str(tmp_path / "cache"))
    return []


def ask(made, name="a", content=b"some bytes"):
    def make():
        made.append(name)
        return content

    return cached(name, make)


def test_bytes_are_made_once_for_each_name(made):
    assert [ask(made), ask(made), ask(made, "b", b""), ask(made, "b", b"")] == [b"some bytes", b"some bytes", b"", b""]
    assert made == ["a", "b"]


@pytest.mark.parametrize(
    "damage", [lambda whole: whole[:-1], lambda whole: whole[:-1] + b"?", lambda whole: b"", lambda whole: whole * 2]
)
def test_damaged_bytes_are_made_again(made, tmp_path, damage):
    ask(made)
    (file,) = tmp_path.rglob("a")
    file.write_bytes(damage(file.read_bytes()))
    assert [ask(made), ask(made)] == [b"some bytes"] * 2
    assert made == ["a", "a"]


def test_bytes_under_the_name_of_others_are_not_taken_for_them(made, tmp_path):
    ask(made)
    (file,) = tmp_path.rglob("a")
    file.rename(file.with_name("b"))
    assert ask(made, "b", b"others") == b"others"


def test_where_nothing_can_be_kept_it_is_made_each_time(made, tmp_path, capsys):
    (tmp_path / "cache").write_text("no folder")
    assert [ask(made), ask(made)] == [b"some bytes"] * 2
    assert made == ["a", "a"]


def test_the_library_on_a_page_is_the_same_kept_or_made(made):
    scripts = []
    for _ in range(2):
        page.library.cache_clear()
        scripts.append(page.library())
    assert scripts[0] == scripts[1]
    assert gzip.decompress(b64decode(scripts[0])).decode() == get_plotlyjs()
