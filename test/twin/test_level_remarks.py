"""Values that no such rig has are said once for each channel."""

from dataclasses import replace

import numpy as np
import pytest

from slider_drilling.commands.watch_output import JsonLines, TableLines
from slider_drilling.log import read_log
from slider_drilling.rig import load_rig
from slider_drilling.twin import Twin, TwinSettings
from slider_drilling.twin.feed import LogFeed
from slider_drilling.twin.watch import reports_of, watch
from slider_drilling.twin.wits_feed import WitsFeed
from slider_drilling.units import UNITS
from slider_drilling.wellbore.static_loads import static_loads

UNIT = {"klbf": 4448.2, "psi": 6894.8, "kft lbf": 1355.8, "kdaN": 1e4, "kPa": 1e3, "kN m": 1e3}


@pytest.fixture
def rig(request):
    return load_rig(request.config.rootpath / "config" / "rig.short.yaml")


def _stream(rig, seconds=70):
    """WITS records in field units of this rig while it rocks."""
    hook, pressure = static_loads(rig, elements=50).hook_load / UNIT["klbf"], rig.circulating_pressure / UNIT["psi"]
    strokes = rig.reference_pump_speed * 60.0 / (2.0 * np.pi)
    for second in range(seconds):
        rpm = 25.0 * np.sin(2.0 * np.pi * second / 20.0)
        items = {"0105": "261127", "0106": f"12{second // 60:02d}{second % 60:02d}", "0118": round(0.1 * rpm, 3),
                 "0120": round(rpm, 2), "0114": round(hook, 1), "0121": round(pressure, 1), "0112": 80.0,
                 "0123": round(strokes, 1)}  # fmt: skip
        yield "&&\r\n" + "".join(f"{item}{value}\r\n" for item, value in items.items()) + "!!\r\n"


def _watch(rig, units, lines_of):
    blocks = [record.encode() for record in _stream(rig)] + [b""]
    twin = Twin(rig, TwinSettings(forecast=0.0))
    watch(twin, WitsFeed(lambda: blocks.pop(0), "standard input", units, rig), lines_of(twin).show, "-")
    return twin


@pytest.mark.parametrize("lines_of", [JsonLines, lambda twin: TableLines(twin, UNITS["si"])])
def test_wrong_units_of_a_stream_are_said_once(rig, capfd, lines_of):
    _watch(rig, "metric", lines_of)
    said = [line for line in capfd.readouterr().err.splitlines() if line.startswith("note: ")]
    assert sum("standpipe_pressure is" in line for line in said) == 1
    assert all("psi" in line for line in said if "standpipe_pressure is" in line)


@pytest.mark.parametrize("without", [("mud_pump",), ("mud_pump", "standpipe_pressure")])
def test_pump_that_is_not_sent_is_said_once(shared_data, without):
    log = replace(read_log(shared_data / "logs" / "nominal_short.mcap"), **dict.fromkeys(without))
    twin = Twin(log.rig(), TwinSettings(forecast=0.0))
    for report in reports_of(twin, LogFeed(log)):
        if report.time > 130.0:
            break
    (said,) = [each for each in twin.remarks if "pump" in each]
    assert said.startswith("the pump is not sent: the flow is assumed to be the rig file's reference flow")
    assert ("pressure" in said) == (len(without) == 1)


def test_right_units_of_a_stream_need_no_remark(rig):
    assert [each for each in _watch(rig, "field", JsonLines).remarks if "sampled at" not in each] == []


@pytest.mark.parametrize(("channel", "factor"), [("hook_load", 1e-3), ("hook_load", 1e3), ("standpipe_pressure", 1e-5),
                                                 ("standpipe_pressure", 1e3), ("pump_speed", 60.0),
                                                 ("surface_torque", 1e4)])  # fmt: skip
def test_unit_of_each_channel_is_seen(rig, channel, factor):
    twin = Twin(rig, TwinSettings(forecast=0.0))
    values = {"hook_load": static_loads(rig, elements=50).hook_load, "standpipe_pressure": rig.circulating_pressure,
              "pump_speed": rig.reference_pump_speed, "surface_torque": 1000.0}  # fmt: skip
    for second in range(66):
        time = second + np.arange(0.0, 1.0, 0.1)
        twin.add("top_drive_angle", time, 9.0 * np.sin(2.0 * np.pi * time / 20.0))
        twin.add("block_position", time, np.zeros(10))
        for name, value in values.items():
            twin.add(name, time, np.full(10, value * (factor if name == channel else 1.0)))
        twin.advance()
    known = [remark for remark in twin.remarks if remark.split()[0] in (channel, "mud_pump")]
    assert len(known) == 1
