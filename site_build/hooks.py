"""MkDocs hooks: pages and pictures that are generated, and equations as MathML, which browsers draw themselves."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from site_build.cli_reference import cli_page
from site_build.pictures import pictures
from site_build.programme_reference import programme_page
from site_build.rig_reference import rig_page
from site_build.topics_reference import topics_page

_BLOCK = re.compile(r"^\$\$\s*\n(.*?)\n\$\$[ ]*$", re.DOTALL | re.MULTILINE)
_INLINE = re.compile(r"(?<![\\$`])\$([^$\n`]+?)\$(?!\$)")
_CODE = re.compile(r"(```.*?```|`[^`\n]*`)", re.DOTALL)


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add what is made of the code."""
    files.append(File.generated(config, "reference/rig.md", content=rig_page()))
    files.append(File.generated(config, "reference/programme.md", content=programme_page()))
    files.append(File.generated(config, "reference/cli.md", content=cli_page()))
    files.append(File.generated(config, "reference/topics.md", content=topics_page()))
    for name, content in pictures().items():
        files.append(File.generated(config, f"pictures/{name}", content=content))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """TeX between dollars becomes MathML; code is left alone."""
    parts = _CODE.split(markdown)
    return "".join(part if place % 2 else _INLINE.sub(_inline, _BLOCK.sub(_block, part))
                   for place, part in enumerate(parts))  # fmt: skip


def _block(match: re.Match[str]) -> str:
    from latex2mathml.converter import convert

    return f'<div class="equation">{convert(match[1], display="block")}</div>'


def _inline(match: re.Match[str]) -> str:
    from latex2mathml.converter import convert

    # A line that begins with <math> would be taken for a block of its own.
    return f"<span>{convert(match[1])}</span>"
