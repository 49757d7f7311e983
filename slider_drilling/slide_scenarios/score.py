"""Score of a slide, from its true state.

The toolface is *set* at the first instant from which it stays within 15 degrees of its target for 60 s. Each contender
has four minutes for that, from the start and from every new target. The error is scored outside of these stretches,
whether the toolface was set or not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slider_drilling.slide_scenarios.scenario import Scenario
from slider_drilling.slide_scenarios.trace import Array, SlideTrace

TOLERANCE_DEG = 15.0
MIN_HELD_SHARE = 0.95   # of the scored time within the tolerance, for a toolface that counts as held
SET_TIME = 60.0         # s within the tolerance, for a toolface that counts as set
ALLOWED_TIME = 240.0    # s to set the toolface
MIN_DRILLED = 0.01      # m of new hole; less counts as nothing drilled


@dataclass(frozen=True)
class SlideScore:
    """Figures of one slide.

    The errors are NaN where nothing was drilled. A bit off bottom does not turn the toolface, so a controller that does
    nothing would seem to hold it perfectly.

    Attributes:
        mean_abs_error_deg: Mean toolface error in the scored time, deg.
        p95_abs_error_deg: Its 95 % quantile, deg.
        within_15_deg: Share of the scored time within the tolerance.
        time_to_set_s: Of the slowest target, s; None where one was never set.
        peak_torque_n_m: Largest surface torque to either side, N m.
        make_up_n_m: Largest torque to the right, N m.
        back_off_n_m: Largest torque to the left, N m.
        weight_spread_n: Standard deviation of weight on bit in the scored time, N.
        rop_m_h: Mean rate of penetration in the scored time, m/h.
        drilled_m: New hole, m.
    """

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
        """Whether the slide made no new hole."""
        return self.drilled_m < MIN_DRILLED


def error_deg(trace: SlideTrace) -> Array:
    """Toolface minus target (n,), deg in [-180, 180)."""
    error: Array = (np.degrees(trace.tool_face - trace.target) + 180.0) % 360.0 - 180.0
    return error


def score_slide(scenario: Scenario, trace: SlideTrace) -> SlideScore:
    """Return the figures of one run.

    Args:
        scenario: Its targets and duration.
        trace: Time series of the run.
    """
    error = error_deg(trace)
    scored, times = _scored_time(scenario, trace, error)
    set_times = [time for time in times if time is not None]
    drilled = float(np.max(trace.bit_depth) - trace.bit_depth[0])
    has_drilled = drilled >= MIN_DRILLED
    magnitude = np.abs(error[scored]) if has_drilled else np.array([math.nan])
    rates = trace.rate_of_penetration[scored]
    return SlideScore(
        mean_abs_error_deg=float(np.mean(magnitude)),
        p95_abs_error_deg=float(np.percentile(magnitude, 95.0)),
        within_15_deg=float(np.mean(magnitude <= TOLERANCE_DEG)) if has_drilled else math.nan,
        time_to_set_s=max(set_times) if len(set_times) == len(times) and has_drilled else None,
        peak_torque_n_m=float(np.max(np.abs(trace.surface_torque))),
        make_up_n_m=float(np.max(trace.surface_torque)),
        back_off_n_m=float(-np.min(trace.surface_torque)),
        weight_spread_n=float(np.std(trace.weight_on_bit[scored])),
        rop_m_h=3600.0 * float(np.mean(rates)) if len(rates) else math.nan,
        drilled_m=drilled,
    )


def _scored_time(scenario: Scenario, trace: SlideTrace, error: Array) -> tuple[np.ndarray, list[float | None]]:
    """Which samples are scored (n,), and the time to set each target, s, or None."""
    starts = [start for start, _ in scenario.targets]
    ends = [*starts[1:], scenario.duration]
    scored = np.zeros(len(trace.time), dtype=bool)
    times: list[float | None] = []
    for start, end in zip(starts, ends, strict=True):
        scored |= (trace.time >= start + ALLOWED_TIME) & (trace.time < end)
        inside = (trace.time >= start) & (trace.time < end)
        times.append(_time_to_set(trace.time[inside] - start, error[inside]))
    return scored, times


def _time_to_set(time: Array, error: Array) -> float | None:
    since: float | None = None
    for now, deviation in zip(time, error, strict=True):
        if abs(deviation) > TOLERANCE_DEG:
            since = None
        elif since is None:
            since = float(now)
        elif now - since >= SET_TIME:
            return since
    return None
