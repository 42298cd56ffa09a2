"""Parser of trial results: lines of JSON from the program that runs the trials, checked against the pending trials.

A rejected line changes nothing on record. Its error names the id, the given and the allowed values, and the remedy.
"""

import json
from collections.abc import Iterable
from math import isfinite

from plant.errors import InputError, UnknownNameError, one_line, shortened
from plant.input_files import parse_json
from plant.texts import PlainTable, PlainValue
from tuner.extensions.trials.record import Answer, Trial, TrialRecord

MAX_LINE_BYTES = 1_000_000
"""Largest number of bytes in a line."""
MAX_REASON_LENGTH = 200
TRIAL_KEYS = tuple(Trial.model_fields)
KEYS = (*TRIAL_KEYS, "metrics", "failed", "reason")
"""Keys of a line: a program may send back its trial along with the result."""
FORM = '{"id": ..., "metrics": {...}} or {"id": ..., "failed": true, "reason": "..."}'


class ResultParser:
    """Parser of result lines for a record. metrics: names of the required ones; n_accepted, n_duplicates: lines so far."""

    def __init__(self, record: TrialRecord, metrics: Iterable[str]) -> None:
        self.record, self.metrics = record, tuple(metrics)
        self.n_accepted = self.n_duplicates = 0

    def add(self, line: bytes | str, source: str) -> Answer:
        """Record the result in a line and return it; InputError where it is invalid. source: its name in errors."""
        table = parse_line(line, source)
        trial = self._trial(table, source)
        try:
            answer = self._answer(table, trial)
        except InputError as error:
            raise InputError(error.message, file=source, key=trial.id) from None
        if trial.id in self.record.answers:
            self._refuse_other(answer, source)
            self.n_duplicates += 1
            return answer
        self.record.tell(answer)
        self.n_accepted += 1
        return answer

    def _trial(self, table: PlainTable, source: str) -> Trial:
        name = table.get("id")
        if not isinstance(name, str):
            given = "has no id" if "id" not in table else f"has the id {_shown(name)}"
            raise InputError(
                f"{given}; each line is {FORM}, with the id of a line that `tuner ask` printed", file=source
            )
        if name not in self.record.trials:
            what = f"unknown id '{shortened(one_line(name))}'"
            raise InputError(f"{what}; tell the id of a line that `tuner ask` printed for this folder", file=source)
        return self.record.trials[name]

    def _answer(self, table: PlainTable, trial: Trial) -> Answer:
        for key in table:
            if key not in KEYS:
                raise UnknownNameError("key", one_line(key), KEYS)
        pending = trial.content()
        for key in TRIAL_KEYS[1:]:
            if key in table and table[key] != pending[key]:
                raise InputError(
                    f"'{key}' is {_shown(table[key])}, and asked was {_shown(pending[key])}; tell what that trial gave"
                )
        failed = table.get("failed", False)
        if not isinstance(failed, bool):
            raise InputError(f"'failed' is {_shown(failed)}; allowed: true or false")
        if failed and "metrics" in table:
            raise InputError("tells metrics and that it failed; leave one of the two out")
        if failed:
            return Answer(id=trial.id, failed=True, reason=_reason(table.get("reason", "")))
        return Answer(id=trial.id, metrics=self._metrics(table.get("metrics")))

    def _metrics(self, given: PlainValue) -> dict[str, float]:
        if not isinstance(given, dict):
            what = "has no metrics" if given is None else f"'metrics' is {_shown(given)}"
            raise InputError(f"{what}; tell {FORM}")
        for name in given:
            if name not in self.metrics:
                raise UnknownNameError("metric", one_line(name), self.metrics)
        missing = [name for name in self.metrics if name not in given]
        if missing:
            names = ", ".join(self.metrics)
            raise InputError(f"the metric '{missing[0]}' is missing; tell {names}, or that it failed")
        return {name: _number(name, given[name]) for name in self.metrics}

    def _refuse_other(self, answer: Answer, source: str) -> None:
        before = self.record.answers[answer.id]
        if before == answer or (before.failed and answer.failed):
            return
        message = (
            f"was submitted before as {_result_text(before)}, and now as {_result_text(answer)}; the first result stays: do "
            "nothing, or start over with another --out"
        )
        raise InputError(message, file=source, key=answer.id)


def parse_line(line: bytes | str, source: str) -> PlainTable:
    """Return the object in a line of JSON; InputError where it holds none."""
    if len(line) > MAX_LINE_BYTES:
        raise InputError(f"is longer than {MAX_LINE_BYTES:,} bytes; each line is {FORM}", file=source)
    try:
        text = line.decode("utf-8-sig") if isinstance(line, bytes) else line
        table = parse_json(text, object_pairs_hook=_once)
    except UnicodeDecodeError:
        raise InputError(f"is not UTF-8 text; each line is {FORM}", file=source) from None
    except ValueError:
        raise InputError(f"{_shown_line(line)} is not JSON; each line is {FORM}", file=source) from None
    except InputError as error:
        raise error.located(file=source) from None
    if not isinstance(table, dict):
        raise InputError(f"given {_shown(table)}; each line is {FORM}", file=source)
    return table


def _once(pairs: list[tuple[str, PlainValue]]) -> PlainTable:
    table = dict(pairs)
    if len(table) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(f"the key '{shortened(one_line(twice))}' occurs twice; remove one")
    return table


def _number(name: str, value: PlainValue) -> float:
    allowed = "allowed: a finite number, 0 or more; tell that, or that the trial failed"
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"'{name}' is {_shown(value)}; {allowed}")
    try:
        number = float(value)
    except OverflowError:
        raise InputError(f"'{name}' is too large for a floating-point number; {allowed}") from None
    if not isfinite(number) or number < 0.0:
        raise InputError(f"'{name}' is {number:g}; {allowed}")
    return number


def _reason(given: PlainValue) -> str:
    if not isinstance(given, str):
        raise InputError(f"'reason' is {_shown(given)}; allowed: a text")
    return shortened(one_line(given), MAX_REASON_LENGTH)


def _result_text(answer: Answer) -> str:
    if answer.metrics is None:
        return f"failed ({answer.reason})" if answer.reason else "failed"
    return _shown(answer.metrics)


def _shown(value: PlainValue) -> str:
    return shortened(one_line(json.dumps(value, ensure_ascii=False)))


def _shown_line(line: bytes | str) -> str:
    text = line.decode(errors="replace") if isinstance(line, bytes) else line
    return f"'{shortened(one_line(text.strip()))}'"
