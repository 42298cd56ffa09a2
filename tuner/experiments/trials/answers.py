"""The border to the program that makes the trials: a line of JSON that it tells, checked against what it was asked.

A line that is refused changes nothing on record. Its error says the id, what was given, what is allowed and what to do.
"""

import json
from collections.abc import Iterable
from math import isfinite
from typing import Any

from plant.errors import InputError, UnknownNameError, one_line, shortened
from plant.input_files import parse_json
from tuner.store.trials import Answer, Trial, TrialRecord

LONGEST_LINE = 1_000_000
"""Bytes of a line that is read."""
LONGEST_REASON = 200
ASKED_KEYS = tuple(Trial.model_fields)
KEYS = (*ASKED_KEYS, "metrics", "failed", "reason")
"""Keys of a line: a program may send back what it was asked along with its answer."""
FORM = '{"id": ..., "metrics": {...}} or {"id": ..., "failed": true, "reason": "..."}'


class Answers:
    """Takes lines for a record. metrics: names of what has to be told; taken, repeated: numbers of lines so far."""

    def __init__(self, record: TrialRecord, metrics: Iterable[str]) -> None:
        self.record, self.metrics = record, tuple(metrics)
        self.taken = self.repeated = 0

    def take(self, line: bytes | str, source: str) -> Answer:
        """Keep what a line tells and return it; InputError where it cannot be used. source: what errors name."""
        table = parsed(line, source)
        trial = self._trial(table, source)
        try:
            answer = self._answer(table, trial)
        except InputError as error:
            raise InputError(error.message, file=source, key=trial.id) from None
        if trial.id in self.record.told:
            self._refuse_other(answer, source)
            self.repeated += 1
            return answer
        self.record.tell(answer)
        self.taken += 1
        return answer

    def _trial(self, table: dict[str, Any], source: str) -> Trial:
        name = table.get("id")
        if not isinstance(name, str):
            given = "has no id" if "id" not in table else f"has the id {_shown(name)}"
            raise InputError(
                f"{given}; each line is {FORM}, with the id of a line that `tuner ask` printed", file=source
            )
        if name not in self.record.asked:
            what = f"unknown id '{shortened(one_line(name))}'"
            raise InputError(f"{what}; tell the id of a line that `tuner ask` printed for this folder", file=source)
        return self.record.asked[name]

    def _answer(self, table: dict[str, Any], trial: Trial) -> Answer:
        for key in table:
            if key not in KEYS:
                raise UnknownNameError("key", one_line(key), KEYS)
        asked = trial.content()
        for key in ASKED_KEYS[1:]:
            if key in table and table[key] != asked[key]:
                message = (
                    f"'{key}' is {_shown(table[key])}, and asked was {_shown(asked[key])}; tell what that trial gave"
                )
                raise InputError(message)
        failed = table.get("failed", False)
        if not isinstance(failed, bool):
            raise InputError(f"'failed' is {_shown(failed)}; allowed: true or false")
        if failed and "metrics" in table:
            raise InputError("tells metrics and that it failed; leave one of the two out")
        if failed:
            return Answer(id=trial.id, failed=True, reason=_reason(table.get("reason", "")))
        return Answer(id=trial.id, metrics=self._metrics(table.get("metrics")))

    def _metrics(self, given: Any) -> dict[str, float]:
        if not isinstance(given, dict):
            what = "has no metrics" if given is None else f"'metrics' is {_shown(given)}"
            raise InputError(f"{what}; tell {FORM}")
        for name in given:
            if name not in self.metrics:
                raise UnknownNameError("metric", one_line(name), self.metrics)
        missing = [name for name in self.metrics if name not in given]
        if missing:
            told = ", ".join(self.metrics)
            raise InputError(f"the metric '{missing[0]}' is missing; tell {told}, or that it failed")
        return {name: _number(name, given[name]) for name in self.metrics}

    def _refuse_other(self, answer: Answer, source: str) -> None:
        before = self.record.told[answer.id]
        if before == answer or (before.failed and answer.failed):
            return
        message = (
            f"was told before as {_told(before)}, and now as {_told(answer)}; what was told first stays: nothing is to be "
            "done, or begin anew with another --out"
        )
        raise InputError(message, file=source, key=answer.id)


def parsed(line: bytes | str, source: str) -> dict[str, Any]:
    """Return the object in a line of JSON; InputError where it holds none."""
    if len(line) > LONGEST_LINE:
        raise InputError(f"is longer than {LONGEST_LINE:,} bytes; each line is {FORM}", file=source)
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


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(f"the key '{shortened(one_line(twice))}' stands in it twice; leave one out")
    return table


def _number(name: str, value: Any) -> float:
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


def _reason(given: Any) -> str:
    if not isinstance(given, str):
        raise InputError(f"'reason' is {_shown(given)}; allowed: a text")
    return shortened(one_line(given), LONGEST_REASON)


def _told(answer: Answer) -> str:
    if answer.metrics is None:
        return f"failed ({answer.reason})" if answer.reason else "failed"
    return _shown(answer.metrics)


def _shown(value: Any) -> str:
    return shortened(one_line(json.dumps(value, ensure_ascii=False)))


def _shown_line(line: bytes | str) -> str:
    text = line.decode(errors="replace") if isinstance(line, bytes) else line
    return f"'{shortened(one_line(text.strip()))}'"
