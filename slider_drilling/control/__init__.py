"""Controllers in plain Python: a trajectory, a control law, and what a controller is. No ROS."""

from slider_drilling.control.fixed_rocking import FixedRocking, FixedRockingSettings
from slider_drilling.control.interface import Controller, Level, Status
from slider_drilling.control.rocking import Rocking
from slider_drilling.control.slide_controller import SlideController
from slider_drilling.control.slide_settings import SlideSettings

__all__ = ["Controller", "FixedRocking", "FixedRockingSettings", "Level", "Rocking", "SlideController",
           "SlideSettings", "Status"]
