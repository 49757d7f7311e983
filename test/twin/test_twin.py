import numpy as np
import pytest

from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.rig import load_rig
from slider_drilling.twin import Twin


def _feed(twin, log, until):
    for second in np.arange(0.0, until, 1.0):
        for name, series, array in (
            ("top_drive_angle", log.top_drive, "position"), ("top_drive_speed", log.top_drive, "velocity"),
            ("surface_torque", log.top_drive, "effort"), ("block_position", log.draw_works, "position"),
            ("block_speed", log.draw_works, "velocity"), ("hook_load", log.draw_works, "effort"),
            ("standpipe_pressure", log.standpipe_pressure, "value"), ("pump_speed", log.mud_pump, "velocity"),
        ):  # fmt: skip
            rows = (series.time >= second) & (series.time < second + 1.0)
            twin.add(name, series.time[rows], getattr(series, array)[rows])
        yield from twin.advance()


def test_twin_of_nominal_rig_follows_it(shared_data):
    log = read_log(shared_data / "logs" / "nominal_short.mcap")
    twin = Twin(log.rig())
    report = [*_feed(twin, log, 100.0)][-1]
    assert report.channels["surface_torque"].gap_60 < 0.5
    assert report.channels["standpipe_pressure"].gap_60 < 0.5


def test_unknown_channel_is_refused(repository):
    twin = Twin(load_rig(repository / "config" / "rig.short.yaml"))
    with pytest.raises(InputError, match="twin: torque: no such channel"):
        twin.add("torque", 0.0, 1.0)
