"""The first look at a log, in seconds and before any fit: can it be used, and does it belong to this rig file?"""

from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.log_checks.run_checks import LogChecks, check_log

__all__ = ["LogChecks", "LogIssue", "check_log"]
