"""How well a slide went, on truth.

The toolface is *set* at the first instant from which it stays within 15 degrees of its target for 60 s. Four minutes
are allowed for that, from the start and from every new target; the error is scored outside of them, the same stretch
for every contender, whether it had set the toolface or not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slider_drilling.closed_loop.scenario import Scenario
from slider_drilling.closed_loop.trace import Array, SlideTrace

WITHIN_DEG = 15.0
HELD_SHARE = 0.95  # of the scored time within, to count as held
HELD = 60.0       # s within, to count as set
ALLOWED = 240.0   # s for setting
LEAST = 0.01      # m of hole; less is nothing drilled


@dataclass(frozen=True)
class SlideScore:
    """mean_abs_error_deg, p95_abs_error_deg, within_15_deg (share of time): after setting; time_to_set_s: the slowest
    of the scenario's targets, None where one was never set; peak_torque_n_m: of either sign; make_up_n_m, back_off_n_m:
    the most to the right and to the left; weight_spread_n: one standard deviation after setting; rop_m_h: likewise;
    drilled_m: of new hole. The errors are NaN where nothing was drilled: a bit off bottom does not turn the toolface,
    and a controller that does nothing would hold it to perfection."""

    mean_abs_error_deg: float
    p95_abs_error_deg: float
    within_15_deg: float
    time_to_set_s: float | None
    peak_torque_n_m: float
    make_up_n_m: float
    back_off_n_m: float
    weight_spread_n: float
    rop_m_h: float
    drilled_m: float

    @property
    def nothing_drilled(self) -> bool:
        """Whether there was no hole to hold a toolface in."""
        return self.drilled_m < LEAST


def error_deg(trace: SlideTrace) -> Array:
    """Toolface minus target, deg in [-180, 180)."""
    off: Array = (np.degrees(trace.tool_face - trace.target) + 180.0) % 360.0 - 180.0
    return off


def score_slide(scenario: Scenario, trace: SlideTrace) -> SlideScore:
    """The figures of one run."""
    error = error_deg(trace)
    starts = [since for since, _ in scenario.targets]
    ends = [*starts[1:], scenario.duration]
    scored = np.zeros(len(trace.time), dtype=bool)
    times: list[float | None] = []
    for start, end in zip(starts, ends, strict=True):
        scored |= (trace.time >= start + ALLOWED) & (trace.time < end)
        inside = (trace.time >= start) & (trace.time < end)
        times.append(_time_to_set(trace.time[inside] - start, error[inside]))
    known = [time for time in times if time is not None]
    span = trace.time[scored]
    drilled = float(np.max(trace.bit_depth) - trace.bit_depth[0])
    off = np.abs(error[scored]) if drilled >= LEAST else np.array([math.nan])
    return SlideScore(
        mean_abs_error_deg=float(np.mean(off)),
        p95_abs_error_deg=float(np.percentile(off, 95.0)),
        within_15_deg=float(np.mean(off <= WITHIN_DEG)) if drilled >= LEAST else math.nan,
        time_to_set_s=max(known) if len(known) == len(times) and drilled >= LEAST else None,
        peak_torque_n_m=float(np.max(np.abs(trace.surface_torque))),
        make_up_n_m=float(np.max(trace.surface_torque)),
        back_off_n_m=float(-np.min(trace.surface_torque)),
        weight_spread_n=float(np.std(trace.weight_on_bit[scored])),
        rop_m_h=3600.0 * float(np.mean(trace.rate_of_penetration[scored])) if len(span) else float("nan"),
        drilled_m=drilled,
    )


def _time_to_set(time: Array, error: Array) -> float | None:
    since: float | None = None
    for now, off in zip(time, error, strict=True):
        if abs(off) > WITHIN_DEG:
            since = None
        elif since is None:
            since = float(now)
        elif now - since >= HELD:
            return since
    return None
