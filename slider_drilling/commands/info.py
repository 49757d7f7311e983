"""`slider-drilling info`: lists what a log holds, what is lost, and what a replay and a diagnosis lack."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import json_option, namespace_option, print_json, topics_option, units_option

if TYPE_CHECKING:
    from slider_drilling.log import RigLog
    from slider_drilling.log.info import LogInfo, TopicInfo
    from slider_drilling.log_checks import CheckRow
    from slider_drilling.rig import Rig
    from slider_drilling.units import Text, Units


@click.command(epilog="Example:\n\n  slider-drilling info run.mcap")
@click.argument("log", type=click.Path(path_type=Path))
@click.option("--rig", "rig_path", type=click.Path(path_type=Path), help="Rig file instead of the log's own.")
@namespace_option
@topics_option
@click.option("--all", "show_all", is_flag=True, help="Print every topic and note, however many lines that takes.")
@units_option
@json_option
def command(
    log: Path, rig_path: Path | None, namespace: str | None, topics_path: Path | None, show_all: bool, units: Units,
    as_json: bool,
) -> None:  # fmt: skip
    """List the topics of LOG, or of a folder of its parts: types, rates, gaps, steps of the clock, lost messages.

    Then print what is missing for a replay and for a diagnosis.
    """
    from slider_drilling.errors import InputError
    from slider_drilling.log import read_log
    from slider_drilling.log.info import log_info
    from slider_drilling.log.topic_map import NO_TOPICS, read_topic_map

    topics = NO_TOPICS if topics_path is None else read_topic_map(topics_path)
    info = log_info(log, topics)
    record: RigLog | None = None
    try:
        record = read_log(log, rig_path, namespace, topics_path)
        refused = ""
    except InputError as error:
        refused = str(error)
    notes = list(info.notes)
    for note in record.notes if record is not None else ():
        if note not in notes:
            notes.append(note)
    missing: dict[str, list[Text]] = {
        use: [refused] if record is None else _missing(record, use) for use in ("replay", "diagnosis")
    }
    assumed = [] if record is None else _assumed(record)
    rows = () if record is None else _checks(record, missing["diagnosis"])
    if as_json:
        _print_json(info, notes, missing, assumed, rows)
        return
    from slider_drilling.commands.info_lines import print_info

    print_info(info, notes, missing, assumed, rows, units, show_all)


def _checks(record: RigLog, missing: list[Text]) -> tuple[CheckRow, ...]:
    """The table of log checks; what a diagnosis would be refused for is added to what it misses."""
    from slider_drilling.errors import InputError
    from slider_drilling.log_checks import check_log, check_without_rig

    try:
        rig = record.rig()
    except InputError:
        rig = None
    if record.top_drive is None:
        checked = check_without_rig(record, "needs top_drive/joint_states, which the log does not hold")
    elif rig is None:
        unreadable = "" if record.rig_text is None else "needs a rig file that can be read: give it with --rig"
        checked = check_without_rig(record, unreadable)
    else:
        checked = check_log(record, rig)
    missing += [*checked.texts("unusable"), *checked.texts("uninformative")]
    return checked.rows()


def _missing(record: RigLog, use: str) -> list[Text]:
    """Reasons why the log cannot be used for this, one sentence each; empty where it can."""
    from slider_drilling.diagnosis.replay import measured_channels
    from slider_drilling.errors import InputError
    from slider_drilling.log_inputs.commands_from_log import commands_from_log

    reasons: list[Text] = []
    rig: Rig | None
    try:
        rig = record.rig()
    except InputError as error:
        rig = None
        reasons.append(str(error))
    if record.top_drive is None:
        return [*reasons, record.lack_of_top_drive("drives the plant")]
    if rig is None:
        return reasons
    try:
        commands_from_log(record, rig)
        channels = measured_channels(record, rig)
    except InputError as error:
        return [str(error)]
    if use == "diagnosis" and "surface_torque" not in channels:
        why = record.why_unreadable("top_drive")
        reasons.append(f"no surface torque (effort of top_drive/joint_states): friction cannot be identified{why}")
    return reasons


def _assumed(record: RigLog) -> list[Text]:
    """What a replay assumes where the log lacks data."""
    from slider_drilling.errors import InputError
    from slider_drilling.log_inputs.commands_from_log import commands_from_log

    try:
        return list(commands_from_log(record, record.rig()).assumptions)
    except InputError:
        return []  # the reason is printed as missing


def _row(topic: TopicInfo) -> dict[str, object]:
    return {
        "topic": topic.topic, "type": topic.message_type, "messages": topic.messages, "first_s": topic.first,
        "last_s": topic.last, "rate_hz": topic.rate, "longest_gap_s": topic.longest_gap, "gaps": topic.gaps,
        "lost": topic.lost, "clock_steps_back": topic.stamp_steps_back, "furthest_back_s": topic.largest_step_back,
        "lag_s": topic.lag, "channels": topic.channels,
    }  # fmt: skip


def _print_json(info: LogInfo, notes: list[str], missing: dict[str, list[Text]], assumed: list[Text],
                rows: Sequence[CheckRow]) -> None:  # fmt: skip
    print_json({
        "files": info.files, "bytes": info.bytes, "start_ns": info.start_ns, "duration_s": info.seconds,
        "messages": sum(topic.messages for topic in info.topics), "topics": [_row(topic) for topic in info.topics],
        "attachments": info.attachments, "metadata": info.metadata, "notes": notes,
        **{f"missing_for_{use}": [str(text) for text in reasons] for use, reasons in missing.items()},
        "assumed_in_replay": [str(text) for text in assumed],
        "log_checks": [{"check": row.check, "result": row.result, "text": str(row.text)} for row in rows],
    })  # fmt: skip
