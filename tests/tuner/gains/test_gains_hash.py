"""The content hash against an independent canonical form: ECMAScript's own JSON with sorted keys, which RFC 8785 is made of."""

import hashlib
import json
import subprocess

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plant.errors import InputError
from tests.clients import program
from tests.tuner.gains.making import whole_document, written
from tuner.gains import content_hash, content_sha256
from tuner.gains.hashing import canonical, canonical_hash

# Keys in the order of UTF-16 code units is the order of Array.sort of strings.
SCRIPT = """
const sorted = (v) => Array.isArray(v) ? v.map(sorted) : v && typeof v === "object"
  ? Object.fromEntries(Object.keys(v).sort().map((k) => [k, sorted(v[k])])) : v;
// Integer-like keys come first in an object of ECMAScript whatever the order, so that the text is put together by hand.
const text = (v) => Array.isArray(v) ? `[${v.map(text).join(",")}]` : v && typeof v === "object"
  ? `{${Object.keys(v).sort().map((k) => `${JSON.stringify(k)}:${text(v[k])}`).join(",")}}` : JSON.stringify(v);
const all = JSON.parse(require("fs").readFileSync(0, "utf8"));
console.log(JSON.stringify(all.map((v) => require("crypto").createHash("sha256").update(text(sorted(v)), "utf8").digest("hex"))));
"""
NUMBERS = [
    0.0,
    -0.0,
    1.0,
    0.1,
    1e-7,
    1e21,
    1e22,
    5e-324,
    1.7976931348623157e308,
    333333333.33333329,
    4.5,
    2e-3,
    2**53,
    2**60,
    -7,
]


def by_node(values):
    done = subprocess.run(
        [program("node"), "-e", SCRIPT], input=json.dumps(values), capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_document_has_the_hash_of_ecmascript():
    made = whole_document()
    bare = {key: value for key, value in made.items() if key not in ("sha256", "exports", "cost")}
    assert by_node([bare]) == [made["sha256"]]


def test_numbers_and_keys_are_canonical():
    values = [
        *NUMBERS,
        {"10": 1, "9": 2, "é": 3, "\U0001f600": 4, "\ufb33": 5, "€": 6, "\r": 7, "1": 8},
        ["\u2028", '"\\\b'],
    ]
    assert by_node(values) == [canonical_hash(value) for value in values]


def test_any_document_is_hashed_as_by_ecmascript():
    finite = st.floats(allow_nan=False, allow_infinity=False)
    text = st.text(st.characters(codec="utf-8"), max_size=8)
    leaf = st.none() | st.booleans() | finite | st.integers(-(2**70), 2**70) | text
    value = st.recursive(leaf, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(text, inner, max_size=3))
    drawn = []

    @settings(max_examples=150, database=None, deadline=None)
    @given(value)
    def draw(one):
        drawn.append(one)

    draw()
    assert by_node(drawn) == [canonical_hash(one) for one in drawn]


def test_the_example_of_the_standard():
    """RFC 8785, section 3.2.4, its input and output."""
    value = json.loads(
        r'{"numbers": [333333333.33333329, 1E30, 4.50, 2e-3, 0.000000000000000000000000001],'
        r' "string": "\u20ac$\u000F\u000aA' + "'" + r'\u0042\u0022\u005c\\\"\/", "literals": [null, true, false]}'
    )
    expected = (
        '{"literals":[null,true,false],"numbers":[333333333.3333333,1e+30,4.5,0.002,1e-27],'
        r'"string":"€$\u000f\nA' + "'" + r'B\"\\\\\"/"}'
    )
    assert canonical(value) == expected.encode()
    assert canonical_hash(value) == hashlib.sha256(expected.encode()).hexdigest()


def test_the_hash_covers_everything_but_what_comes_later(tmp_path):
    made = whole_document()
    for key in made.keys() - {"sha256", "exports", "cost"}:
        assert content_hash({**made, key: "another"}) != made["sha256"], key
    for key in ("sha256", "exports", "cost"):
        assert content_hash({name: value for name, value in made.items() if name != key}) == made["sha256"], key
    assert content_sha256(written(tmp_path, dict(reversed(made.items())))) == made["sha256"]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), "\ud800", {"\udfff": 1}])
def test_what_has_no_canonical_form_is_refused(value):
    with pytest.raises(InputError, match="no canonical form"):
        canonical(value)
