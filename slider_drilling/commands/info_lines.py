"""What `slider-drilling info` prints: at most LINES lines of a terminal, unless all are asked for."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from rich.console import Console
from rich.table import Table

from slider_drilling.commands.options import checks_table
from slider_drilling.console.streams import stdout
from slider_drilling.log.info import LogInfo, TopicInfo
from slider_drilling.log_checks import CheckRow
from slider_drilling.messages.topics import is_of_twin
from slider_drilling.units import Text, Units, format_number

LINES = 25
_TOPICS = 13  # topics that are listed where not all are asked for
# Columns of the table that narrow terminals go without, and the width that they need.
_WIDE = 110
_OTHER_CLOCK_S = 1e5  # s of lag from which stamps are those of another clock
_PADDING = 2  # behind a column


@dataclass
class PrintedLines:
    """Lines that fit into a number of lines of the terminal, long ones counted as often as they wrap.

    Attributes:
        console: Where they are printed.
        room: Lines of the terminal that are left; None for no limit.
        lines: What is printed.
        hidden: Number of lines that did not fit.
    """

    console: Console
    room: int | None
    lines: list[str] = field(default_factory=list)
    hidden: int = 0

    def add(self, lines: Iterable[str], is_needed: bool = False) -> None:
        """Add lines; those that are not needed only where they fit."""
        for line in lines:
            height = max(1, math.ceil(len(line) / self.console.width))
            if self.room is not None:
                # One line is kept for the number of hidden ones.
                if self.hidden or (not is_needed and height > self.room - 1):
                    self.hidden += 1
                    continue
                self.room -= height
            self.lines.append(line)


def print_info(
    info: LogInfo, notes: Sequence[str], missing: Mapping[str, Sequence[Text]], assumed: Sequence[Text],
    checks: Sequence[CheckRow], units: Units, show_all: bool,
) -> None:  # fmt: skip
    """Print what a log holds and lacks.

    Args:
        info: Its statistics.
        notes: What is damaged, lost or left out.
        missing: Use -> reasons why the log cannot be used for this.
        assumed: What a replay assumes.
        checks: The table of log checks; empty where none could be made.
        units: Display units.
        show_all: Whether to print more than LINES lines.
    """
    console = stdout()
    printed = PrintedLines(console, None if show_all else LINES)
    printed.add(_head(info), is_needed=True)
    printed.add(_topic_lines(info.topics, console, None if show_all else _TOPICS), is_needed=True)
    printed.add(_uses(missing, units), is_needed=True)
    printed.add(f"note: {units.convert_message(note)}" for note in notes)
    if checks:
        table = checks_table(checks, units)
        table.box, table.show_header = None, False
        printed.add(_rendered(table, console))
    printed.add(f"in a replay {units.convert_text(sentence)}" for sentence in assumed)
    for line in printed.lines:
        console.print(line)
    if printed.hidden:
        console.print(f"{printed.hidden} more lines: --all shows them, --json holds everything")


def _head(info: LogInfo) -> list[str]:
    total = sum(topic.messages for topic in info.topics)
    many = f"{len(info.files)} files, " if len(info.files) > 1 else ""
    return [
        f"{many}{info.bytes / 1e6:.2f} MB, {total} messages over {info.seconds:.1f} s",
        f"attachments: {', '.join(info.attachments) or 'none'}; metadata: {', '.join(info.metadata) or 'none'}",
    ]


def _topic_lines(topics: Sequence[TopicInfo], console: Console, most: int | None) -> list[str]:
    """The table of topics with names that fit; where there are more than `most`, stamped measurements come first."""
    listed = list(topics)
    if most is not None and len(listed) > most:
        listed = sorted(topics, key=lambda one: (math.isnan(one.lag), is_of_twin(one.topic)))[: most - 1]
    rows = [_cells(topic, console.width >= _WIDE) for topic in listed]
    heads = ["type"] if console.width >= _WIDE else []
    heads += ["messages", "rate, Hz", "gap, s", "gaps", "lost", "back", "lag, s"]
    columns = zip(heads, *rows, strict=True)
    room = console.width - sum(max(map(len, column)) + _PADDING for column in columns) - _PADDING
    table = Table("topic", box=None, padding=(0, _PADDING, 0, 0))
    for heading in heads:
        table.add_column(heading, justify="left" if heading == "type" else "right", no_wrap=True)
    names = [topic.topic for topic in listed]
    for name, row in zip(names if most is None else _shortened(names, room), rows, strict=True):
        table.add_row(name, *row)
    others = [topic.topic for topic in topics if topic not in listed]
    rest = f"and {len(others)} other topics: {', '.join(others)}"
    if len(rest) > console.width:
        rest = f"{rest[: console.width - 3]}..."
    return [*_rendered(table, console), *([rest] if others else [])]


def _cells(topic: TopicInfo, with_type: bool) -> list[str]:
    """A topic's row but for its name."""
    back = f"{topic.stamp_steps_back} ({topic.largest_step_back:.1f} s)" if topic.stamp_steps_back else "0"
    return [
        *([topic.message_type.rpartition("/")[2]] if with_type else []), str(topic.messages),
        _number(topic.rate, ".3g"), _number(topic.longest_gap, ".2f"), str(topic.gaps), str(topic.lost), back,
        # Of a simulator whose stamps count from zero the lag is the epoch: its digits would only take room.
        _number(topic.lag, ".2f") if not abs(topic.lag) >= _OTHER_CLOCK_S else format_number(topic.lag, 2),
    ]  # fmt: skip


def _shortened(names: Sequence[str], room: int) -> list[str]:
    """The ends of names that are too long, with as much of their beginnings as tells them apart."""
    kept = max(room - 3, 8)
    for begin in range(kept - 2):
        shown = [name if len(name) <= room else f"{name[:begin]}...{name[begin - kept :]}" for name in names]
        if len(set(shown)) == len(set(names)):
            return shown
    return list(names)


def _uses(missing: Mapping[str, Sequence[Text]], units: Units) -> list[str]:
    """What the log can be used for, and why not for the rest: each reason once."""
    ready = "; ".join(f"{use}: {'not possible' if reasons else 'ready'}" for use, reasons in missing.items())
    reasons = dict.fromkeys(units.convert_message(reason) for reasons in missing.values() for reason in reasons)
    return [ready, *(f"  {reason}" for reason in reasons)]


def _rendered(table: Table, console: Console) -> list[str]:
    """The lines of a table as the console prints them."""
    with console.capture() as captured:
        console.print(table)
    return [line.rstrip() for line in captured.get().splitlines() if line.strip()]


def _number(value: float, form: str) -> str:
    return "-" if math.isnan(value) else format(value, form)
