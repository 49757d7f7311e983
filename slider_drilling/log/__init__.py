"""Logs: MCAP files are read and written, other formats are imported. Needs no ROS."""

from slider_drilling.log.read import read_log
from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.save import save_log
from slider_drilling.log.series import JointSeries, ScalarSeries
from slider_drilling.log.write import LogWriter
from slider_drilling.messages.health import Level, Status
from slider_drilling.messages.topics import DIAGNOSTICS, TOPICS, Topic

__all__ = [
    "DIAGNOSTICS",
    "TOPICS",
    "JointSeries",
    "Level",
    "LogWriter",
    "RigLog",
    "ScalarSeries",
    "Status",
    "Topic",
    "read_log",
    "save_log",
]
