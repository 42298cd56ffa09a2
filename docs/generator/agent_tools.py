"""The table of tools in docs/agents.md, from the table that the server has: python docs/generator/agent_tools.py."""

import re
from inspect import getdoc
from pathlib import Path

from reference import markdown_table

from tuner.extensions.agents.tools import TOOLS, commands

PAGE = Path(__file__).resolve().parents[1] / "agents.md"
PART = re.compile(r"(<!-- tools: .*? -->\n).*?(<!-- end of tools -->)", re.DOTALL)


def tools_table() -> str:
    """Return the table of tools as Markdown."""
    rows = [
        (f"`{name}`", (getdoc(function) or "").partition("\n")[0], TOOLS[name].effect.value)
        for name, function in commands().items()
    ]
    return markdown_table(("tool", "task", "files below the root"), rows)


def with_table(page: str) -> str:
    """Return the page with the table of this version."""
    return PART.sub(lambda match: f"{match[1]}{tools_table().strip()}\n{match[2]}", page)


if __name__ == "__main__":
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
