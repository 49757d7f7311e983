"""A twin beside the rig: it simulates along with the samples as they come, and says what changed, when, and why."""

from slider_drilling.twin.ask import Ask, diagnose_after
from slider_drilling.twin.channels import CHANNELS, COMPARED, DRIVING
from slider_drilling.twin.report import ChannelState, Detection, Forecast, Trend, TwinReport
from slider_drilling.twin.settings import TwinSettings
from slider_drilling.twin.stall_watch import MotorStall
from slider_drilling.twin.twin import Twin

__all__ = [
    "CHANNELS", "COMPARED", "DRIVING", "Ask", "ChannelState", "Detection", "Forecast", "MotorStall", "Trend", "Twin",
    "TwinReport", "TwinSettings", "diagnose_after",
]  # fmt: skip
