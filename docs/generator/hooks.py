"""MkDocs hooks: pages made from files outside docs/, reference pages generated from the program, links into the sources.

Nothing that is generated is kept in the repository.
"""

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from posixpath import dirname, join, normpath, relpath
from typing import Any

import reference
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[2]
OUTSIDE = {
    "README.md": "index.md",
    "ARCHITECTURE.md": "architecture.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "security.md",
    "results/README.md": "results.md",
    "plant/airframes/README.md": "airframes.md",
    "benchmarks/NOTES.md": "speed.md",
}
"""Pages of the site that lie elsewhere in the repository."""
LINK = re.compile(r"(\]\()([^)\s]+)(\))")
ELSEWHERE = ("#", "http://", "https://", "mailto:")
LANGUAGES = {".py": "python", ".toml": "toml", ".json": "json", ".c": "c", ".js": "js", ".sh": "sh", ".css": "css"}
# A page of code; its own fences must not end the block.
SOURCE_PAGE = """---
title: {path}
search:
  exclude: true
---

# {path}

~~~~~~{language}
{code}
~~~~~~
"""


def on_files(files: Files, config: Any) -> Files:
    """Add the pages that do not lie in docs/."""
    for path, uri in OUTSIDE.items():
        text = (ROOT / path).read_text(encoding="utf-8")
        files.append(File.generated(config, uri, content=relinked(text, path, uri)))
    for uri, text in reference.pages().items():
        files.append(File.generated(config, uri, content=text))
    for path in sorted(linked_sources(files)):
        files.append(File.generated(config, uri_of(path), content=source_page(path)))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Files) -> str:
    """Turn the links of a page of docs/ that leave the folder into links to pages of the site."""
    if page.file.generated_by:
        return markdown
    return relinked(markdown, f"docs/{page.file.src_uri}", page.file.src_uri)


def relinked(text: str, path: str, uri: str) -> str:
    """Return the Markdown of the repository's file `path` with its links as they are seen from the page `uri`."""

    def link(found: re.Match[str]) -> str:
        before, target, after = found.groups()
        if target.startswith(ELSEWHERE):
            return found.group()
        file, mark, anchor = target.partition("#")
        seen = relpath(uri_of(normpath(join(dirname(path), file))), dirname(uri) or ".")
        return f"{before}{seen}{mark}{anchor}{after}"

    return LINK.sub(link, text)


def uri_of(path: str) -> str:
    """Return the page, or the picture, of the site that shows a file of the repository."""
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    return OUTSIDE.get(path) or f"source/{path}.md"


def linked_sources(files: Files) -> set[str]:
    """Return the files of the repository, with neither page nor picture of their own, that a page links to."""
    texts = {path: (ROOT / path).read_text(encoding="utf-8") for path in OUTSIDE}
    texts |= {
        f"docs/{file.src_uri}": file.content_string for file in files.documentation_pages() if not file.generated_by
    }
    targets = {target for path, text in texts.items() for target in link_targets(path, text)}
    return {path for path in targets if not path.startswith("docs/") and path not in OUTSIDE}


def link_targets(path: str, text: str) -> Iterator[str]:
    """Yield the files of the repository that a page links to."""
    for _, target, _ in LINK.findall(text):
        if not target.startswith(ELSEWHERE):
            yield normpath(join(dirname(path), target.partition("#")[0]))


def source_page(path: str) -> str:
    """Return the page of a source file, or of a folder the list of its files."""
    file = ROOT / path
    if file.is_dir():
        return SOURCE_PAGE.format(path=path, language="text", code="\n".join(tracked(path)))
    language = LANGUAGES.get(file.suffix, "text")
    return SOURCE_PAGE.format(path=path, language=language, code=file.read_text(encoding="utf-8"))


def tracked(folder: str) -> list[str]:
    """Return the files of a folder that are part of the project."""
    listed = subprocess.run(["git", "ls-files", folder], cwd=ROOT, capture_output=True, text=True, check=True)
    return listed.stdout.splitlines()
