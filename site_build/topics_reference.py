"""The topics of a rig, as the README lists them."""

from __future__ import annotations

from pathlib import Path

README = Path(__file__).resolve().parent.parent / "README.md"


def topics_page() -> str:
    """The page as Markdown."""
    text = README.read_text(encoding="utf-8")
    start = text.index("## Topics\n")
    section = text[start : text.index("\n## ", start + 1)].replace("(docs/", "(../")
    return f"{section[1:]}\n[Nodes](../how_to/nodes.md) says how time passes and what else the nodes publish.\n"
