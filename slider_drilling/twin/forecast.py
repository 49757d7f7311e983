"""What the twin expects of the next minute: a free run of its plants, the drives going on as they did."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slider_drilling.angles import wrap_angle
from slider_drilling.drillstring import Commands
from slider_drilling.twin.channels import COMPARED
from slider_drilling.twin.follower import Follower
from slider_drilling.twin.report import Forecast
from slider_drilling.twin.samples import Array

_ROWS = {name: row for row, name in enumerate(COMPARED)}
_STEADY_S = 60.0  # over which the block's speed is averaged
_PRIOR_SQUARES, _KEPT = 5.0, 0.98  # rad2; share of older forecasts that still counts
_STEERING_KEPT = 0.5  # of the centre's motion from one rocking period to the next
_JOINED_S = 1.0  # in which the repeated motion joins the present one
_TOLERANCE = 0.15  # of the period, within which the repetition that fits best is sought


def make_forecast(follower: Follower, values: Array, past: Commands, period: float | None, ahead: float) -> Forecast:
    """Simulate on from now, then bring the plants back to where they are.

    Args:
        follower: The plants, up to date.
        values: (p,) calibrated values.
        past: The drives of the last minutes, evenly sampled, up to now.
        period: s, of the rocking; None where the drive does not rock.
        ahead: s to look ahead.
    """
    interval = follower.bank.interval
    state = follower.bank.save()
    followed = follower.advance(continued(past, period, ahead, interval))
    follower.bank.restore(state)
    channels = followed.at(values)
    return Forecast(
        float(past.time[-1]), followed.time, channels[:, _ROWS["tool_face"]],
        channels[:, _ROWS["surface_torque"]],
    )  # fmt: skip


class ToolFaceSkill:
    """How much of a predicted turn of the toolface comes true, from the forecasts so far.

    A free run without feedback may turn its bit where the rig's is held. The change that it predicts is multiplied by
    the share that came true before, by least squares with a prior towards none: the toolface stays as it is.
    """

    def __init__(self) -> None:
        self._open: deque[tuple[float, float, float]] = deque()
        self._squares, self._products = _PRIOR_SQUARES, 0.0

    @property
    def share(self) -> float:
        """0 to 1."""
        return min(max(self._products / self._squares, 0.0), 1.0)

    def shrunk(self, forecast: Forecast, present: float, offset: float, reading: float) -> Forecast:
        """The forecast with this share of its change, from the present reading on.

        Args:
            forecast: Of the plant alone.
            present: The plant's toolface when it was made, rad.
            offset: Of the rig's toolface to the plant's, rad.
            reading: The latest MWD toolface, rad.
        """
        while self._open and self._open[0][0] <= forecast.made_at:
            _, predicted, before = self._open.popleft()
            self._squares = _PRIOR_SQUARES + _KEPT * (self._squares - _PRIOR_SQUARES) + predicted**2
            self._products = _KEPT * self._products + predicted * wrap_angle(reading - before)
        change = forecast.tool_face - present
        self._open.append((float(forecast.time[-1]), wrap_angle(float(change[-1])), reading))
        begin = present + offset + wrap_angle(reading - present - offset)
        return replace(forecast, tool_face=begin + self.share * change)


def continued(past: Commands, period: float | None, ahead: float, interval: float) -> Commands:
    """The drives after the past: the last rocking period repeated, or steady speeds; the block at its mean speed."""
    steps = np.arange(1, round(ahead / interval) + 1)
    time = past.time[-1] + interval * steps
    angle, speed = _drive(past, period, steps, interval)
    recent = past.time >= past.time[-1] - _STEADY_S
    moved = past.block_position[recent]
    span = max(float(past.time[-1] - past.time[recent][0]), interval)
    rate = float(moved[-1] - moved[0]) / span
    block = past.block_position[-1] + rate * interval * steps
    pump = np.full(steps.size, past.pump_speed[-1])
    return Commands(time, angle, speed, block, np.full(steps.size, rate), pump)


def _drive(past: Commands, period: float | None, steps: NDArray[np.int_], interval: float) -> tuple[Array, Array]:
    """Angle rad and speed rad/s of the top drive at so many steps from now."""
    angle, speed = past.top_drive_angle, past.top_drive_speed
    lag = None if period is None else best_lag(angle, period, interval)
    if lag is None:
        return angle[-1] + speed[-1] * interval * steps, np.full(steps.size, speed[-1])
    repeats, within = np.divmod(steps - 1, lag)
    rows = angle.size - lag + within
    # The centre's own motion fades: steering ends within a few periods. A lag of whole samples leaves a small jump.
    drift = float(np.mean(angle[-lag:]) - np.mean(angle[-2 * lag : -lag]))
    moved = drift * (1.0 - _STEERING_KEPT ** (repeats + 1)) / (1.0 - _STEERING_KEPT) * _STEERING_KEPT
    jump = float(angle[-1] + speed[-1] * interval - angle[-lag] - drift * _STEERING_KEPT)
    return angle[rows] + moved + jump * np.exp(-interval * steps / _JOINED_S), speed[rows]


def best_lag(angle: Array, period: float, interval: float) -> int | None:
    """Samples after which an angle (n,) repeats itself best, near a period s; None if the past is too short."""
    low, high = (math.floor(share * period / interval) for share in (1.0 - _TOLERANCE, 1.0 + _TOLERANCE))
    if low < 2 or angle.size < 2 * high + 1:
        return None
    last = angle[-high:]

    def mismatch(lag: int) -> float:
        difference = last - angle[-high - lag : -lag]
        return float(np.var(difference))

    return min(range(low, high + 1), key=mismatch)
