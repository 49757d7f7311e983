"""The first look at a log, in seconds and before any fit: can it be used, and does it belong to this rig file?"""

from slider_drilling.log_checks.finding import Finding
from slider_drilling.log_checks.look import FirstLook, first_look

__all__ = ["Finding", "FirstLook", "first_look"]
