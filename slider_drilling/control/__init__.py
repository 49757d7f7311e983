"""Controllers in plain Python, without ROS: their interface to a rig, rocking trajectories, and two controllers."""

from slider_drilling.control.fixed_rocking import FixedRocking, FixedRockingSettings
from slider_drilling.control.interface import Controller, Level, Status
from slider_drilling.control.rocking import Rocking
from slider_drilling.control.slide_controller import SlideController
from slider_drilling.control.slide_settings import SlideSettings

__all__ = ["Controller", "FixedRocking", "FixedRockingSettings", "Level", "Rocking", "SlideController",
           "SlideSettings", "Status"]
