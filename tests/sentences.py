"""Sentences that break the rules of `CONTRIBUTING.md`, in docstrings, messages and Markdown.

The finders look for patterns that are wrong wherever they stand: a rule that a reader alone can judge is not among them.
"""

import ast
import inspect
import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

# A description has a head noun: none of these begins one.
HEADLESS = re.compile(r"(?:of|that|whose|as|by|in|for|over|where|under|which)\b", re.IGNORECASE)
SPEECH = re.compile(r"\b(?:is|are|was|were|be|been|being|gets?)(?: not| never| then| also)? (?:told|said)\b")
RELATIVE = re.compile(r"What\b(?!-if)[^?]*$")
VERB = (
    "is|are|was|were|has|have|does|do|did|would|can|cannot|could|may|might|will|must|needs?|takes?|costs?|makes?|gives?"
)
OLD = [
    re.compile(r"\b(?:nobody|whoever|anew|beside|stands? for|standing for)\b", re.IGNORECASE),
    # "for" that means "because" has a subject and a verb behind it.
    re.compile(
        rf", for (?!example|instance|short)(?:(?!(?:that|which|who|whom|whose|what) )[\w'-]+ ){{1,5}}(?:{VERB})\b"
    ),
    re.compile(r"Where [^,]*, "),
]
# Things do not speak, hear or want; a report "says" no more than a law "knows".
THINGS = (
    "air|autopilot|backend|chart|class|code|column|command|controller|copy|curve|data|document|engine|entry|exporter|"
    "extension|field|figure|file|firmware|flight|fit|folder|front|function|gains?|gyro|kernel|key|kind|law|limit|line|"
    "log|loop|margin|message|meter|method|metric|model|module|motor|notch|number|observer|option|page|parameter|part|"
    "plant|point|printer|process|program|rate|record|report|row|rule|run|search|section|sensor|signal|solver|study|"
    "system|table|target|task|test|text|tool|unit|value|vehicle|worker"
)
SPEAKS = r"tells?|told|says?|said|hears?|heard|knows?|knew|asks?|asked|wants?|wanted|hopes?|wishes|believes?|forgets?"
FIGURE = re.compile(
    rf"\b(?:{THINGS})(?:s|es)? (?:itself |already |alone |never |also )?(?:{SPEAKS})\b(?! (?:for|by|apart)\b)"
)
FENCE = re.compile(r"^(```|~~~).*?^\1", re.MULTILINE | re.DOTALL)
ENTRY = re.compile(r"(?:\*{0,2}\w+(?:, \*{0,2}\w+)*)(?: \([^()]*\))?: +(.*)")
SECTION = re.compile(r"(?:Args|Attributes|Returns|Yields):$")
MIN_WORDS = 3


class Fault(NamedTuple):
    """A sentence that breaks a rule."""

    rule: str
    text: str


def faults(text: str) -> Iterator[Fault]:
    """Yield the faults of a text: one of a rule for a sentence."""
    for sentence in sentences(text):
        if RELATIVE.match(sentence):
            yield Fault("free relative", sentence)
        if SPEECH.search(sentence):
            yield Fault("passive of speech", sentence)
        if FIGURE.search(sentence):
            yield Fault("figure of speech", sentence)
        if any(pattern.search(sentence) for pattern in OLD[:2]) or OLD[2].match(sentence):
            yield Fault("old sense", sentence)


def sentences(text: str) -> Iterator[str]:
    """Yield the sentences of paragraphs, each on one line."""
    for paragraph in re.split(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.) )", text):
        joined = " ".join(paragraph.split()).lstrip("#-*> ")
        yield from filter(None, re.split(r"(?<=[.!?:;])[\"')*_]*\s+", joined))


def is_headless(description: str) -> bool:
    """Return True if a description begins without its noun."""
    return bool(HEADLESS.match(description))


def entries(docstring: str) -> Iterator[str]:
    """Yield the descriptions of the parameters of a docstring in Google form."""
    is_inside = False
    for line in inspect.cleandoc(docstring).splitlines():
        if SECTION.match(line):
            is_inside = True
        elif line and not line.startswith(" "):
            is_inside = False
        elif is_inside and (match := ENTRY.fullmatch(line[4:])):
            yield match[1]


def prose(docstring: str) -> str:
    """Return a docstring with each parameter's description as a paragraph, and code as one word."""
    text = re.sub(r"\n    (?=\*{0,2}\w+(?:, \w+)*: )", "\n\n", inspect.cleandoc(docstring))
    return _without_code(re.sub(r"\n\n\*{0,2}\w+(?:, \w+)*: ", "\n\n", text))


def markdown_prose(text: str) -> str:
    """Return a page of Markdown without headings and blocks of code; cells of tables are paragraphs of their own."""
    text = re.sub(r"(?m)^#+ .*$", "", FENCE.sub("", text))
    text = re.sub(
        r"(?m)^(?: {4}|\t).*$", lambda line: line[0] if re.match(r"\s+(?:[-*]|\d+\.) ", line[0]) else "", text
    )
    rows = re.sub(r"(?m)^\|.*$", lambda row: row[0].replace("|", "\n\n"), text)
    return _without_code(re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", rows))


def _without_code(text: str) -> str:
    return re.sub(r"``.+?``|`[^`]+`", "X", text)


def messages(nodes: Sequence[ast.AST]) -> Iterator[tuple[int, str]]:
    """Yield line and text of each string of words of a module's nodes that is no docstring; values of an f-string are one word."""
    joined = [node for node in nodes if isinstance(node, ast.JoinedStr)]
    passed = {id(part) for node in joined for part in ast.walk(node)} - {id(node) for node in joined}
    passed |= {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        if id(node) in passed:
            continue
        match node:
            case ast.Constant(value=str(text)):
                pass
            case ast.JoinedStr(values=values):
                text = "".join(str(part.value) if isinstance(part, ast.Constant) else "X" for part in values)
            case _:
                continue
        if len(text.split()) >= MIN_WORDS:
            yield node.lineno, _without_code(text)
