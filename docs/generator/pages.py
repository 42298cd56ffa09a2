"""The pages of the site as Markdown by name: files of the repository, with links as they are seen there, and generated pages."""

import json
import re
import subprocess
from pathlib import Path
from posixpath import dirname, join, normpath, relpath

import reference

ROOT = Path(__file__).resolve().parents[2]
OUTSIDE = {
    "README.md": "index.md",
    "ARCHITECTURE.md": "architecture.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "PUBLISHING.md": "publishing.md",
    "SECURITY.md": "security.md",
    "results/README.md": "results.md",
    "plant/quadrotor/airframes/README.md": "airframes.md",
}
"""Pages of the site that lie outside docs/."""
NAVIGATION = {
    "Begin": (
        "installation", "tutorial", "tune_in_a_notebook", "how_to/coming_from", "reading_the_report", "gallery",
        "questions", "how_to/troubleshooting",
    ),
    "Your vehicle": (
        "how_to/plan_a_flight", "identify", "log_formats", "log_to_gains", "how_to/model_accuracy", "how_to/period_and_delay",
        "how_to/noise_and_battery", "how_to/battery", "airframes",
    ),
    "Limits and objectives": (
        "how_to/objectives", "units", "how_to/limits", "how_to/flight_limits", "how_to/automatic_limits", "how_to/study_size",
        "how_to/which_point", "how_to/infeasible", "how_to/conflicting_limits", "how_to/unstable_loop", "how_to/compare",
        "how_to/choices_beside_numbers", "tails", "how_to/start_from_a_run", "how_to/studio", "how_to/studio_sliders",
    ),
    "To the vehicle and back": (
        "from_file_and_back", "how_to/judge", "second_opinion", "how_to/read_back", "exports", "how_to/processor_cost",
        "how_to/betaflight_adrc", "how_to/adrc_plants", "how_to/search_betaflight_adrc", "how_to/confirm",
    ),
    "Plants": (
        "own_plant", "how_to/linear_plant", "how_to/plant_outputs", "how_to/plant_margins", "cookbook", "how_to/fit",
        "how_to/which_law", "how_to/textbook_pid", "how_to/design_rules", "how_to/observer", "examples/dc_motor",
        "examples/dead_time", "examples/two_masses", "examples/fixed_wing", "fmu_plant", "examples/iron", "ask_and_tell",
        "examples/gymnasium",
        "examples/rotorpy",
    ),
    "Theory": ("laws", "model", "statistics", "evidence", "paper"),
    "Extend": (
        "how_to/add_a_law", "how_to/add_a_metric", "model_functions", "how_to/share_own_code", "examples/own_law",
        "how_to/add_an_export_target", "how_to/add_a_number",
        "how_to/add_an_extension", "architecture", "contributing",
    ),
    "Machines": ("speed", "cluster", "agents"),
    "Reference": ("studies", "study_file", "choices", "commands", "api", "results", "gains_file", "gains_keys", "glossary"),
    "Project": ("stability", "changelog", "security", "publishing", "paper_joss"),
}  # fmt: skip
ANCHOR = re.compile(r'<a id="(\w+)"></a>')
FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(\]\()([^)\s]+)(\))")
PICTURES, NOTEBOOK = (".png", ".gif"), ".ipynb"
ELSEWHERE = ("#", "http://", "https://", "mailto:")
LANGUAGES = {".py": "python", ".json": "json", ".c": "c", ".js": "javascript", ".sh": "sh", ".css": "css"}


def pages() -> dict[str, str]:
    """Return all pages, Markdown by their path in the site."""
    written = own_pages()
    found = {place_of(path): relinked(text, path) for path, text in written.items()}
    sources = linked(written) - set(written)
    found |= {place_of(path): source_page(path) for path in sources if place_of(path).startswith("source/")}
    found |= reference.pages()
    found["index.md"] += navigation()
    return found


def pictures() -> dict[str, Path]:
    """Return the pictures that pages show, files by their path in the site."""
    return {place_of(path): ROOT / path for path in linked(own_pages()) if path.endswith(PICTURES)}


def own_pages() -> dict[str, str]:
    """Return the pages that somebody wrote, Markdown by their path in the repository."""
    files = [*(ROOT / "docs").rglob("*.md"), *(ROOT / path for path in OUTSIDE)]
    texts = {file: file.read_text(encoding="utf-8") for file in files}
    texts |= {file: notebook_text(file) for file in (ROOT / "docs").rglob(f"*{NOTEBOOK}")}
    return {file.relative_to(ROOT).as_posix(): text for file, text in texts.items()}


def notebook_text(file: Path) -> str:
    """Return a notebook as Markdown: its texts, and its code as blocks."""
    cells = json.loads(file.read_text(encoding="utf-8"))["cells"]
    texts = [(cell["cell_type"], "".join(cell["source"])) for cell in cells]
    return "\n\n".join(f"```python\n{text}\n```" if kind == "code" else text for kind, text in texts) + "\n"


def place_of(path: str) -> str:
    """Return where the site shows a file of the repository."""
    if path.endswith(NOTEBOOK):
        return f"{Path(path).stem}.md"
    if path.startswith("docs/") and path.endswith((".md", *PICTURES)):
        return path.removeprefix("docs/")
    if path.endswith(PICTURES):
        return f"images/{path}"
    return OUTSIDE.get(path) or f"source/{path}.md"


def linked(written: dict[str, str]) -> set[str]:
    """Return the files of the repository that pages link to."""
    return {target for path, text in written.items() for target in targets(text, path)}


def relinked(text: str, path: str) -> str:
    """Return a page with its links as they are seen from its place in the site."""

    def link(found: re.Match[str]) -> str:
        before, target, after = found.groups()
        if target.startswith(ELSEWHERE):
            return found.group()
        file, mark, anchor = target.partition("#")
        seen = relpath(place_of(normpath(join(dirname(path), file))), dirname(place_of(path)) or ".")
        return f"{before}{seen}{mark}{anchor}{after}"

    return ANCHOR.sub(r"[]{#\1}", LINK.sub(link, text))


def targets(text: str, path: str) -> set[str]:
    """Return the files of the repository that a page links to; raises FileNotFoundError where one is missing."""
    links = [target for _, target, _ in LINK.findall(text) if not target.startswith(ELSEWHERE)]
    found = {normpath(join(dirname(path), target.partition("#")[0])) for target in links}
    # Generated pages are linked to as if they lay in docs/.
    missing = [target for target in found if not (ROOT / target).exists() and place_of(target) not in reference.NAMES]
    if missing:
        raise FileNotFoundError(f"{path} links to {', '.join(missing)}")
    return found


def source_page(path: str) -> str:
    """Return the page of a source file, or of a folder the list of its files."""
    file = ROOT / path
    text = "\n".join(tracked(path)) if file.is_dir() else file.read_text(encoding="utf-8")
    language = LANGUAGES.get(file.suffix, "text")
    return f"---\norphan: true\nnosearch: true\n---\n\n# {path}\n\n~~~~~~{language}\n{text}\n~~~~~~\n"


def tracked(folder: str) -> list[str]:
    """Return the files of a folder that are part of the project; of a checkout without git, all but compiled ones."""
    try:
        listed = subprocess.run(["git", "ls-files", folder], cwd=ROOT, capture_output=True, text=True, check=True)
        return listed.stdout.splitlines()
    except (FileNotFoundError, subprocess.CalledProcessError):
        files = (file.relative_to(ROOT) for file in (ROOT / folder).rglob("*") if file.is_file())
        return sorted(file.as_posix() for file in files if "__pycache__" not in file.parts)


def navigation() -> str:
    """Return the table of contents, in parts, for the end of the first page."""
    parts = []
    for title, names in NAVIGATION.items():
        caption = f":caption: {title}\n" if title else ""
        parts.append("```{toctree}\n:hidden:\n" + caption + "\n" + "\n".join(names) + "\n```\n")
    return "\n" + "\n".join(parts)


def page_list() -> str:
    """Return the pages with their first sentences, for language models (https://llmstxt.org)."""
    texts = pages()
    parts = [f"# {title_of(texts['index.md'])}", f"> {sentence_of(texts['index.md'])}"]
    for title, names in NAVIGATION.items():
        written = [(name, texts[f"{name}.md"]) for name in names]
        lines = [f"- [{title_of(text)}]({name}.html): {sentence_of(text)}" for name, text in written]
        parts.append("\n".join([f"## {title}", "", *lines]))
    return "\n\n".join(parts) + "\n"


def title_of(text: str) -> str:
    """Return the first heading of a page."""
    return next(line.removeprefix("# ") for line in text.splitlines() if line.startswith("# "))


def sentence_of(text: str) -> str:
    """Return the first sentence of a page as plain text, empty where there is none."""
    paragraphs = [part.replace("\n", " ").strip() for part in re.split(r"\n\s*\n", FENCED.sub("", text))]
    prose = next((part for part in paragraphs if part[:1].isalnum() or part.startswith("`")), "")
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", prose)
    return re.split(r"(?<=[a-z0-9)%`]\.)\s|(?<=\w\?)\s", plain)[0].rstrip(":")
