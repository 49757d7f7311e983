"""Quality control of a log before any fit: is it usable, and does it belong to this rig file?

One module per check; `run_checks` calls them in order.
"""

from slider_drilling.log_checks.check_table import CheckRow
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.log_checks.run_checks import LogChecks, check_log, check_without_rig

__all__ = ["CheckRow", "LogChecks", "LogIssue", "check_log", "check_without_rig"]
