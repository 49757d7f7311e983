"""The page of a rig's topics, from the registry of topics."""

from __future__ import annotations

from slider_drilling.messages.topics import DIAGNOSTICS, TOPICS, TWIN_TOPICS, Topic

INTRODUCTION = """\
# Topics

Relative to the node's namespace; a recorded log holds the same, plus the rig file as attachment `rig.yaml`.

"""
QUANTITIES = """\

## Numbers

A log in memory (`RigLog`) keeps these of each topic, in SI units.

"""


def topic_table() -> str:
    """One row a topic, as Markdown: name, type, content. The README holds the same table."""
    rows = ["| topic | type | content |", "|---|---|---|"]
    rows += [_row(topic) for topic in (*TOPICS.values(), *TWIN_TOPICS, DIAGNOSTICS)]
    return "\n".join(rows) + "\n"


def _row(topic: Topic) -> str:
    content = f"simulation only; {topic.content}" if topic.is_simulated_only else topic.content
    return f"| `{topic.name}` | {topic.type.replace('/msg/', '/')} | {content} |"


def _quantity_table() -> str:
    """One row a number that a log keeps, as Markdown."""
    rows = ["| topic | in `RigLog` | column in tables | unit | in a mapping file |", "|---|---|---|---|---|"]
    rows += [
        f"| `{topic.name}` | `{key}.{quantity.array}` | `{quantity.column}` | {quantity.unit} "
        f"| {f'`{quantity.import_name}`' if quantity.import_name else ''} |"
        for key, topic in TOPICS.items()
        for quantity in topic.quantities
    ]
    return "\n".join(rows) + "\n"


def topics_page() -> str:
    """The page as Markdown."""
    return (
        f"{INTRODUCTION}{topic_table()}{QUANTITIES}{_quantity_table()}\n"
        "[Nodes](../how_to/nodes.md) says how time passes and what else the nodes publish. [Logs](logs.md) says how\n"
        "logs of other programs are read.\n"
    )
