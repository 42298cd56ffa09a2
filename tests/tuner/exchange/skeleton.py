"""What remains of an exported file when comments, and what strings hold, are taken out: each kind read as its language has it."""

import ast
import io
import re
import xml.etree.ElementTree as ET
import zipfile
from html.parser import HTMLParser
from pathlib import PurePosixPath

import yaml
from markdown_it import MarkdownIt

TRIGRAPHS = dict(zip("=/'()!<>-", "#\\^[]|{}~", strict=True))
C_TOKENS = re.compile(r"""/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'|\s+|\w+|.""", re.DOTALL)
# Attributes in which a text may stand, and those that differ with every byte of code.
FREE = ("description", "guid")


def c_skeleton(content):
    """Tokens of C, in the phases of translation: trigraphs, splices, comments; strings are all alike."""
    text = re.sub(r"\?\?([=/'()!<>-])", lambda found: TRIGRAPHS[found[1]], content.decode())
    tokens = C_TOKENS.findall(text.replace("\\\n", ""))
    kept = [token for token in tokens if not token.startswith(("/*", "//")) and not token.isspace()]
    return ['"' if token.startswith('"') and len(token) > 1 else token for token in kept]


def python_skeleton(content):
    """The syntax tree without docstrings."""
    tree = ast.parse(content)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module) and ast.get_docstring(node) is not None:
            node.body.pop(0)
    return ast.dump(tree)


def matlab_skeleton(content):
    """Lines without comments; a character vector ends at a single quote that stands alone."""
    lines = re.split(r"\r\n|[\n\r\x0b\x0c\x85\u2028\u2029]", content.decode())
    code = [re.sub(r"'(?:[^']|'')*'", "''", line) for line in lines if not line.lstrip().startswith("%")]
    return [line.split("%")[0] for line in code]


def xml_skeleton(content):
    return [
        (node.tag, (node.text or "").strip(), {key: value for key, value in node.attrib.items() if key not in FREE})
        for node in ET.fromstring(content).iter()
    ]


def html_skeleton(content):
    """Tags with their attributes."""
    found = []

    class Tags(HTMLParser):
        def handle_starttag(self, tag, attrs):
            found.append((tag, attrs))

        def handle_comment(self, data):
            found.append(("comment", data))

    Tags().feed(content.decode())
    return found


def markdown_skeleton(content):
    """Blocks, and what in them is no text."""
    tokens = MarkdownIt("commonmark", {"html": True}).enable(["table", "strikethrough"]).parse(content.decode())
    plain = ("text", "softbreak")
    return [(token.type, [c.type for c in token.children or [] if c.type not in plain]) for token in tokens]


def line_skeleton(content):
    """Lines that are no comments, with whatever anybody takes for the end of a line."""
    lines = re.split(r"[\n\r\x0b\x0c\x1c-\x1e\x85\u2028\u2029]", content.decode())
    # Betaflight completes the line at a question mark or a tab, and leaves its command line at the control characters.
    assert not [line for line in lines if line.startswith("#") and re.search(r"[\x00-\x1f\x7f?]", line)]
    return [line for line in lines if not line.startswith("#")]


def yaml_skeleton(content):
    """The content that a reader gets; ROS 2 reads by libyaml too, where it is there."""
    return yaml.load(content, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def zip_skeleton(content):
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: skeleton(name, archive.read(name)) for name in archive.namelist() if not name.endswith(".so")}


READERS = {
    ".c": c_skeleton, ".h": c_skeleton, ".py": python_skeleton, ".m": matlab_skeleton, ".xml": xml_skeleton,
    ".ssv": xml_skeleton, ".html": html_skeleton, ".md": markdown_skeleton, ".yaml": yaml_skeleton, ".params": line_skeleton,
    ".param": line_skeleton, ".txt": line_skeleton, ".fmu": zip_skeleton,
}  # fmt: skip


def skeleton(name, content):
    """Return what remains of a file; a kind that holds no text from outside is itself."""
    reader = READERS.get(PurePosixPath(name).suffix)
    return content if reader is None else reader(content)
