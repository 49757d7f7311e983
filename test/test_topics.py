"""What follows the registry of topics, topic by topic: a new entry needs no other change in these."""

from __future__ import annotations

import typing
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.errors import InputError
from slider_drilling.log import JointSeries, LogWriter, RigLog, ScalarSeries, read_log, save_log
from slider_drilling.log.contents import logged_quantities
from slider_drilling.log.info import log_info
from slider_drilling.log.series import build_series
from slider_drilling.messages import cdr
from slider_drilling.messages.decoder import TopicDecoder
from slider_drilling.messages.message_types import MESSAGE_TYPES
from slider_drilling.messages.topics import CLOCK_TOPICS, TOPICS, Topic, fitting_keys
from slider_drilling.table_import.mapping import IMPORT_CHANNELS
from slider_drilling.units import KINDS

COUNT = 5
every_topic = pytest.mark.parametrize("key", TOPICS)


def numbers(key: str) -> np.ndarray:
    """(COUNT, fields): other numbers in each field and sample."""
    fields = len(TOPICS[key].message_type().logged)
    return 0.1 + 0.2 * np.arange(COUNT * fields, dtype=float).reshape(COUNT, fields)


def written(path: Path, key: str) -> Path:
    with LogWriter(path) as writer:
        for k, row in enumerate(numbers(key)):
            writer.sample(TOPICS[key], 0.1 * k, row.tolist(), 0.1 * k + 0.02)
    return path


def test_log_has_a_field_for_each_topic() -> None:
    hints = typing.get_type_hints(RigLog)
    fields = {name: kind for name, kind in hints.items() if kind in (JointSeries | None, ScalarSeries | None)}
    assert list(fields) == list(TOPICS)
    time = np.zeros(1)
    for key, kind in fields.items():
        assert type(build_series(TOPICS[key], time, time, {})) | None == kind


@every_topic
def test_reader_returns_what_the_writer_wrote(key: str, tmp_path: Path) -> None:
    log = read_log(written(tmp_path / "run.mcap", key))
    assert list(log.series()) == [key]
    series = log.series()[key]
    for column, logged in enumerate(TOPICS[key].message_type().logged):
        assert np.array_equal(getattr(series, logged.array), numbers(key)[:, column])
    assert np.allclose(series.arrival - series.time, 0.02)
    (topic,) = log_info(tmp_path / "run.mcap").topics
    assert topic.messages == COUNT and topic.lag == pytest.approx(0.02)
    save_log(log, tmp_path / "again.mcap", "test")
    again = read_log(tmp_path / "again.mcap").series()[key]
    assert all(np.array_equal(one, other, equal_nan=True)
               for one, other in zip(vars(series).values(), vars(again).values(), strict=True))


@every_topic
def test_tables_and_contents_show_every_quantity(key: str, tmp_path: Path) -> None:
    log = read_log(written(tmp_path / "run.mcap", key))
    columns = log.columns()
    quantities = TOPICS[key].quantities
    assert {name: columns.units[name] for name in columns.values} == {
        "time": "s", **{quantity.column: quantity.unit for quantity in quantities}}
    assert [(row.topic, row.quantity, row.unit) for row in logged_quantities(log)] == [
        (TOPICS[key].name, quantity.array, quantity.unit) for quantity in quantities]


@every_topic
def test_entry_is_complete(key: str) -> None:
    topic = TOPICS[key]
    arrays = [logged.array for logged in topic.message_type().logged if logged.array != "variance"]
    assert [quantity.array for quantity in topic.quantities] == arrays
    assert topic.content and bool(topic.joint) == ("position" in arrays)
    assert topic.is_simulated_only == key.startswith("truth_")
    assert key in CLOCK_TOPICS
    units = {next(iter(known)) for known in KINDS.values()}
    assert all(quantity.unit in units and quantity.label for quantity in topic.quantities)


def test_columns_and_imports_are_named_once() -> None:
    quantities = [quantity for topic in TOPICS.values() for quantity in topic.quantities]
    columns = [quantity.column for quantity in quantities]
    imports = [quantity.import_name for quantity in quantities if quantity.import_name]
    assert len(set(columns)) == len(columns)
    assert sorted([*imports, "pump_flow"]) == sorted(IMPORT_CHANNELS)


def test_every_registered_type_is_described() -> None:
    assert {topic.type for topic in TOPICS.values()} <= set(MESSAGE_TYPES)


def test_unknown_message_type_is_refused() -> None:
    topic = Topic("gripper", "std_msgs/msg/Float64")
    nothing = np.zeros(1)
    for use in (
        lambda: TopicDecoder(topic),
        lambda: cdr.encode_numbers(topic, 0, [1.0]),
        lambda: build_series(topic, nothing, nothing, {}),
    ):
        with pytest.raises(InputError, match=r"gripper: message type std_msgs/msg/Float64 .* use one of"):
            use()


def test_expected_channels_are_no_measurements(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with LogWriter(path) as writer:
        for k in range(COUNT):
            for key in ("top_drive", "expected_top_drive", "forecast_top_drive"):
                ahead = 60.0 if key.startswith("forecast") else 0.0
                writer.sample(TOPICS[key], k + ahead, [0.0, 0.0, float(len(key))], float(k))
    log = read_log(path)
    for key in ("top_drive", "expected_top_drive", "forecast_top_drive"):
        assert log.series()[key].effort.tolist() == COUNT * [float(len(key))]
    assert log.start == 0.0 and log.notes == ()
    assert log.forecast_top_drive.time[0] == pytest.approx(60.0)


@pytest.mark.parametrize("space", ["", "/rig_a"])
@every_topic
def test_most_specific_topic_is_taken(key: str, space: str) -> None:
    assert fitting_keys(f"{space}/{TOPICS[key].name}") == [key]
