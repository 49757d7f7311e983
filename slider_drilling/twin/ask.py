"""What a twin asks after a detection, in a process of its own: what is different now?"""

from __future__ import annotations

from typing import Any, Protocol

from slider_drilling.log import RigLog
from slider_drilling.rig import Rig


class Ask(Protocol):
    """A question that is asked in another process; it must be picklable, as a function of a module is."""

    def __call__(self, before: RigLog, after: RigLog, rig: Rig, since: float) -> dict[str, Any]:
        """Diagnose a change.

        Args:
            before: Samples from before the change.
            after: Samples from then on.
            rig: The rig file as given.
            since: s after the start of `after` at which the change began.

        Returns:
            The content of diagnosis.json: verdict, site, effects, suspected and the rest.

        Raises:
            InputError: These samples cannot be diagnosed.
        """
        ...


def diagnose_after(before: RigLog, after: RigLog, rig: Rig, since: float) -> dict[str, Any]:
    """What is different since the change, with what was before as the baseline; see `Ask`."""
    from slider_drilling.diagnosis.diagnose_change import Since, diagnose_change
    from slider_drilling.diagnosis.to_json import to_json
    from slider_drilling.log.time_window import cut_time_window

    end = max(float(series.time[-1]) for series in after.series().values())
    changed = cut_time_window(after, since, end)
    return to_json(diagnose_change([before], [changed], rig, since=Since(since, found=True)))
