"""The contract of every JSON document: one model writes it, reads it, describes it, and refuses everything else by its key."""

import json
from functools import cache
from typing import Any, cast

import jsonschema_rs
import pytest
from jsonschema import Draft202012Validator

from plant.errors import StoreError
from tests.tuner.documents.examples import example_of
from tuner.documents import registry
from tuner.documents.registry import DOCUMENTS
from tuner.store.document import json_text

NAMES = list(DOCUMENTS)
schema_of = cache(registry.schema_of)


def places(content, path=()):
    """Every place inside a document, as a path of keys and indices."""
    parts = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    for key, value in parts:
        yield (*path, key)
        yield from places(value, (*path, key))


def at(content, path):
    for step in path:
        content = content[step]
    return content


def written(tmp_path, content, encoded=json.dumps):
    file = tmp_path / "document.json"
    file.write_text(encoded(content), encoding="utf-8")
    return file


def refused(name, file):
    with pytest.raises(StoreError) as caught:
        DOCUMENTS[name].read(file)
    said = str(caught.value)
    assert said.startswith(f"{file}: ") and "\n" not in said
    return said


@pytest.mark.parametrize("name", NAMES)
def test_an_example_comes_out_byte_for_byte(name, tmp_path):
    content = example_of(DOCUMENTS[name])
    file = written(tmp_path, content, json_text)
    assert DOCUMENTS[name].read(file).text() == file.read_text(encoding="utf-8")


def test_limits_in_the_words_of_earlier_versions_are_read_as_min_and_max(tmp_path):
    # Here, since every worker would make all schemas to name the cases.
    names = [name for name in NAMES if '"sense"' in schema_of(name)]
    assert names
    for name in names:
        now = json_text(example_of(DOCUMENTS[name]))
        for word, old in (("max", "most"), ("min", "least")):
            text = now.replace('"sense": "max"', f'"sense": "{word}"')
            (tmp_path / old).write_text(text.replace(f'"sense": "{word}"', f'"sense": "{old}"'), encoding="utf-8")
            assert DOCUMENTS[name].read(tmp_path / old).text() == text, name


@pytest.mark.parametrize("name", NAMES)
def test_the_schema_takes_what_the_model_writes(name):
    schema = json.loads(schema_of(name))
    Draft202012Validator.check_schema(schema)
    validator, content = Draft202012Validator(schema), example_of(DOCUMENTS[name])
    assert list(validator.iter_errors(content)) == []
    assert not validator.is_valid({**content, "surplus": 1})


@pytest.mark.parametrize("name", NAMES)
def test_a_surplus_key_is_named(name, tmp_path):
    content = example_of(DOCUMENTS[name])
    said = refused(name, written(tmp_path, {**content, "surplus": 1}))
    assert "the key 'surplus' is none that this version knows" in said


@pytest.mark.parametrize("name", NAMES)
def test_a_missing_key_is_named(name, tmp_path):
    content = example_of(DOCUMENTS[name])
    fields = DOCUMENTS[name].model_fields.items()
    for key in [field.alias or key for key, field in fields if field.is_required()]:
        said = refused(name, written(tmp_path, {other: value for other, value in content.items() if other != key}))
        assert f"the key '{key}' is missing" in said


@pytest.mark.parametrize("name", NAMES)
def test_a_value_of_another_kind_is_refused_wherever_it_stands(name, tmp_path):
    content = example_of(DOCUMENTS[name])
    # Twenty times as fast as the other, which judges the whole document for each value.
    validator = jsonschema_rs.Draft202012Validator(json.loads(schema_of(name)))
    for path in list(places(content)):
        part = cast(Any, at(content, path[:-1]))
        kept, part[path[-1]] = part[path[-1]], {"what": ["is", "this"]}
        if not validator.is_valid(content):
            refused(name, written(tmp_path, content))
        part[path[-1]] = kept


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("text", ["", "[]", "{", "null", '"text"', "[" * 100000, '{"title": NaN}', "\x00"])
def test_what_is_no_object_is_refused(name, text, tmp_path):
    file = tmp_path / "document.json"
    file.write_text(text, encoding="utf-8")
    refused(name, file)


def test_texts_for_numbers_and_numbers_without_end_are_told_by_their_key(tmp_path):
    content = example_of(DOCUMENTS["summary"])
    for value, what in (("3", "is '3' and not a number"), (True, "is True and not a finite number")):
        content["table"][0]["tuned"]["low"] = value
        assert f"'table[0].tuned.low' {what}" in refused("summary", written(tmp_path, content))
    text = json_text({**content, "table": []}).replace('"hypervolume": 0.25', '"hypervolume": 1e999')
    (tmp_path / "document.json").write_text(text)
    assert "'hypervolume' is inf and not a finite number" in refused("summary", tmp_path / "document.json")
