"""What a slide teaches of its string: compliance, motor gain, sensor bias and mobility, together with the toolface.

States: x the mean toolface, b where the bend points, the two parts c and d of the swing that rocking leaves at the
bit, and four small corrections of what the rig file says,

    S = S0 (1 + s),    T = (1 + k) T0,    M = Mm - beta,    tau = tau0 exp(l),

of the string's torsional compliance, the reactive torque that pressure shows, the mean of measured surface torque Mm
and the time in which the toolface follows what pulls. Two laws tie them to what is measured:

    x' = S (M - T) / tau                                  what pulls turns the bit,
    angle - x + b = S (w M + (1 - w) T)                   the string is twisted by what it carries,

and MWD reads x + c cos p + d sin p at the phase p of rocking. Off bottom T is zero and shows beta; the ramp of pressure
shows S (1 + k) against MWD; a toolface that rests shows M = T. An extended Kalman filter (Joseph form) weighs all of
it, so that each has its one-sigma.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_X, _B, _S, _K, _BETA, _TAU, _C, _D = range(8)
_STATES = 8
_ANYWHERE = 100.0         # rad2
_THROUGH_DOUBT = 0.3     # of a twist that changes
_LEAST_STIFFNESS, _LEAST_MOTOR, _MOST = -0.3, -0.6, 0.6   # bounds of s and of k
_MOST_MOBILE = 1.6        # bound of l, to either side
_PRIOR = {"compliance": 0.08, "motor": 0.12, "bias": 200.0, "mobility": 0.5}
_SWING, _KEPT = math.radians(3.0), 120.0   # rad, of each part of the swing before any sample; s, over which it is kept
_WALK = {"compliance": 2e-4, "motor": 2e-3, "bias": 12.0, "mobility": 4e-2}   # per sqrt(s)


@dataclass(frozen=True)
class StringEstimate:
    """What is learnt of a string, each with one standard deviation. compliance, motor: shares beyond the rig file's;
    bias: N m; response_time: s."""

    compliance: float
    compliance_sigma: float
    motor: float
    motor_sigma: float
    bias: float
    bias_sigma: float
    response_time: float


class StringKalmanFilter:
    """compliance: rad/(N m), S0; response_time: s, tau0; bias: N m, beta as believed; quickest: s, that tau is at
    least."""

    def __init__(self, compliance: float, response_time: float, bias: float = 0.0, quickest: float = 0.0):
        self._compliance = compliance
        self.response_time = response_time
        self._quickest = quickest
        self.mean: Array = np.zeros(_STATES)
        self.mean[_BETA] = bias
        self._covariance: Array = np.diag(
            [1.0, 1.0, _PRIOR["compliance"] ** 2, _PRIOR["motor"] ** 2, _PRIOR["bias"] ** 2, _PRIOR["mobility"] ** 2,
             _SWING**2, _SWING**2])

    def reset_tool_face(self, tool_face: float, offset: float, variance: float) -> None:
        """The toolface (rad) is known anew, with this variance (rad2), the offset roughly; what was learnt stays.
        `string` then ties the offset to it, and to what is in doubt of the string."""
        self.mean[_X], self.mean[_B] = tool_face, offset
        for row, own in ((_X, variance), (_B, _ANYWHERE)):
            self._covariance[row, :] = 0.0
            self._covariance[:, row] = 0.0
            self._covariance[row, row] = own

    @property
    def estimate(self) -> StringEstimate:
        """As it stands."""
        sigma = np.sqrt(np.diag(self._covariance))
        m = self.mean
        return StringEstimate(float(m[_S]), float(sigma[_S]), float(m[_K]), float(sigma[_K]), float(m[_BETA]),
                      float(sigma[_BETA]), self.response_time * math.exp(float(m[_TAU])))

    def _least_log_time(self) -> float:
        """Least l. Where the loop has corrected what one sample was wrong by, the next one reads as if the bit had
        followed at once: the fewer samples there are, the quicker a string is learnt that is not."""
        quickest = min(self._quickest, self.response_time)
        return max(math.log(max(quickest, 1e-3) / self.response_time), -_MOST_MOBILE)

    @property
    def compliance(self) -> float:
        """S, rad/(N m)."""
        return self._compliance * (1.0 + float(self.mean[_S]))

    @property
    def motor_gain(self) -> float:
        """1 + k."""
        return 1.0 + float(self.mean[_K])

    @property
    def tool_face_sigma(self) -> float:
        """One standard deviation of the toolface, rad."""
        return math.sqrt(float(self._covariance[_X, _X]))

    def pull(self, torque: float, reactive: float) -> float:
        """S (M - T), rad, from measured mean torque and what pressure shows, N m."""
        return self.compliance * (torque - float(self.mean[_BETA]) - self.motor_gain * reactive)

    def twist(self, torque: float, reactive: float, carried: float) -> float:
        """rad, of the whole string; carried: w."""
        own = carried * (torque - float(self.mean[_BETA])) + (1.0 - carried) * self.motor_gain * reactive
        return self.compliance * own

    def follow_torque_step(self, change: float, carried: float) -> None:
        """Reactive torque (as pressure shows it) has changed by N m: what the pipe near the bit gives, it gives at
        once."""
        moved = self.compliance * self.motor_gain * change
        self.mean[_X] -= (1.0 - carried) * moved
        self._covariance[_X, _X] += (_THROUGH_DOUBT * moved) ** 2

    def advance(self, step: float, torque: float, reactive: float, mobility: float, walk: float, drift: float) -> None:
        """On by `step` s. mobility: share of 1 / tau that rocking leaves; walk, drift: rad/sqrt(s), of x and b."""
        pull = self.pull(torque, reactive)
        share = mobility * step / (self.response_time * math.exp(float(self.mean[_TAU])))
        rate = np.eye(_STATES)
        rate[_X, _S] = share * pull / (1.0 + self.mean[_S])
        rate[_X, _K] = -share * self.compliance * reactive
        rate[_X, _BETA] = -share * self.compliance
        rate[_X, _TAU] = -share * pull
        # What is not renewed of the swing is forgotten.
        kept = math.exp(-step / _KEPT)
        rate[_C, _C] = rate[_D, _D] = kept
        self.mean[_X] += share * pull
        self.mean[_C:] *= kept
        noise = np.array([walk * walk, drift * drift, *(value**2 for value in _WALK.values()), 0.0, 0.0]) * step
        noise[_C:] = (1.0 - kept * kept) * _SWING**2
        self._covariance = rate @ self._covariance @ rate.T + np.diag(noise)

    def update_with_cycle(self, angle: float, mean_tool_face: float, torque: float, reactive: float, carried: float,
               variance: float) -> float:
        """Take the mean of a cycle: rad, N m; mean_tool_face: rad, x as held over it; variance: rad2. Returns by how
        much x changes."""
        m = self.mean
        expected = mean_tool_face - m[_B] + self.twist(torque, reactive, carried)
        row = np.zeros(_STATES)
        row[_X], row[_B] = 1.0, -1.0
        row[_S] = self.twist(torque, reactive, carried) / (1.0 + m[_S])
        row[_K] = self.compliance * (1.0 - carried) * reactive
        row[_BETA] = -self.compliance * carried
        return self._correct(row, angle - expected, variance)

    def update_with_mwd(self, innovation: float, phase: float, variance: float, genuine: float) -> float:
        """Take an MWD sample: rad beyond x and swing as held when it was read; phase: rad, of rocking then; variance:
        rad2; genuine: probability that it is no outlier. Returns the change of x."""
        return self._correct(_read_at(phase), innovation, variance, genuine)

    def mwd_variance(self, phase: float) -> float:
        """rad2, of what MWD would read at this phase (rad), beside its own noise."""
        row = _read_at(phase)
        return float(row @ self._covariance @ row)

    def swing_at(self, phase: float) -> float:
        """rad, of the swing at this phase (rad) as far as it is known."""
        return float(_read_at(phase)[_C:] @ self.mean[_C:])

    @property
    def swing(self) -> float:
        """rad, its amplitude, less what noise adds to it."""
        known = float(self.mean[_C] ** 2 + self.mean[_D] ** 2) - 2.0 * self.swing_sigma**2
        return math.sqrt(max(known, 0.0))

    @property
    def swing_sigma(self) -> float:
        """rad, one standard deviation of that."""
        return math.sqrt(0.5 * float(self._covariance[_C, _C] + self._covariance[_D, _D]))

    def _correct(self, row: Array, innovation: float, variance: float, genuine: float = 1.0) -> float:
        """Mean and covariance of two cases: the measurement is what it says, or it says nothing."""
        before = float(self.mean[_X])
        covariance = self._covariance
        gain = covariance @ row / (row @ covariance @ row + variance)
        self.mean = self.mean + genuine * innovation * gain
        self.mean[_S] = min(max(self.mean[_S], _LEAST_STIFFNESS), _MOST)
        self.mean[_K] = min(max(self.mean[_K], _LEAST_MOTOR), _MOST)
        self.mean[_TAU] = min(max(self.mean[_TAU], self._least_log_time()), _MOST_MOBILE)
        left = np.eye(_STATES) - np.outer(gain, row)
        taken = left @ covariance @ left.T + variance * np.outer(gain, gain)
        apart = genuine * (1.0 - genuine) * innovation**2 * np.outer(gain, gain)
        self._covariance = genuine * taken + (1.0 - genuine) * covariance + apart
        return float(self.mean[_X]) - before


def _read_at(phase: float) -> Array:
    """What MWD reads of the states at this phase (rad); NaN: of a phase that is not known, the mean toolface."""
    row = np.zeros(_STATES)
    row[_X] = 1.0
    if math.isfinite(phase):
        row[_C], row[_D] = math.cos(phase), math.sin(phase)
    return row
