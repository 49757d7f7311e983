"""Extended Kalman filter of toolface and string: compliance, motor gain, torque-sensor bias, response time and swing.

States: x the mean toolface, b the toolface offset (where the bend points on an untwisted string), c and d the two parts
of the swing of the bit, and four small corrections of the rig file,

    S = S0 (1 + s),    T = (1 + k) T0,    M = Mm - beta,    tau = tau0 exp(l),

of the torsional compliance of the string, the reactive torque from pressure, the measured mean of surface torque Mm,
and the response time of the toolface. Two laws relate them to measurements:

    x' = S (M - T) / tau                                  the driving twist turns the bit,
    angle - x + b = S (w M + (1 - w) T)                   the string is twisted by the torque it carries,

where w is the share of the compliance that carries the surface torque. MWD reads x + c cos p + d sin p at the phase p
of rocking. What makes the corrections observable: off bottom T is zero, which shows beta; the ramp of pressure shows
S (1 + k) against MWD; a toolface at rest shows M = T. The covariance update has Joseph form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_X, _B, _S, _K, _BETA, _TAU, _C, _D = range(8)
_STATES = 8
_UNKNOWN_ANGLE = 100.0    # rad2, variance of an angle that may be anywhere
_STEP_SIGMA = 0.3         # share of the twist by a change of reactive torque
_SHIFT_SIGMA = 0.15        # share of a jump of the bias
_MIN_S, _MIN_K, _MAX_CORRECTION = -0.3, -0.6, 0.6   # bounds of s and of k
_MAX_LOG_TIME = 1.6       # bound of l, to either side
_PRIOR_SIGMA = {"compliance": 0.08, "motor": 0.12, "bias": 200.0, "log_time": 0.5}
_RANDOM_WALK = {"compliance": 2e-4, "motor": 2e-3, "bias": 12.0, "log_time": 4e-2}   # per sqrt(s)
_SWING_SIGMA, _SWING_TIME = math.radians(3.0), 120.0   # rad, prior of each part; s, after which it is forgotten


@dataclass(frozen=True)
class StringEstimate:
    """Corrections of the rig file, each with one standard deviation.

    Attributes:
        compliance: Torsional compliance, as a share beyond the rig file's.
        compliance_sigma: Share.
        motor: Motor torque per pressure, as a share beyond the rig file's.
        motor_sigma: Share.
        bias: Of the torque sensor, N m.
        bias_sigma: N m.
        response_time: Of the toolface, s.
    """

    compliance: float
    compliance_sigma: float
    motor: float
    motor_sigma: float
    bias: float
    bias_sigma: float
    response_time: float


class StringKalmanFilter:
    """The filter.

    Args:
        compliance: S0, rad/(N m).
        response_time: tau0, s.
        bias: Prior mean of beta, N m.
        min_response_time: Lower bound of tau, s.
        bias_sigma: Prior standard deviation of beta, N m.

    Attributes:
        response_time: tau0, s.
        bias_sigma: Prior standard deviation of beta, N m.
        mean: Mean of the states (8,).
    """

    def __init__(
        self, compliance: float, response_time: float, bias: float = 0.0, min_response_time: float = 0.0,
        bias_sigma: float = _PRIOR_SIGMA["bias"],
    ):  # fmt: skip
        self._compliance = compliance
        self.response_time = response_time
        self._min_response_time = min_response_time
        self.bias_sigma = bias_sigma
        self.mean: Array = np.zeros(_STATES)
        self.mean[_BETA] = bias
        self._covariance: Array = np.diag(
            [1.0, 1.0, *(sigma**2 for sigma in {**_PRIOR_SIGMA, "bias": bias_sigma}.values()),
             _SWING_SIGMA**2, _SWING_SIGMA**2])

    def reset_tool_face(self, tool_face: float, offset: float, variance: float) -> None:
        """Set the toolface (rad, variance rad2) and a rough offset (rad); the corrections of the string stay.

        A following `update_with_cycle` ties the offset to the toolface and to the uncertainty of the string.
        """
        self.mean[_X], self.mean[_B] = tool_face, offset
        for row, own in ((_X, variance), (_B, _UNKNOWN_ANGLE)):
            self._covariance[row, :] = 0.0
            self._covariance[:, row] = 0.0
            self._covariance[row, row] = own

    def shift_bias(self, earlier: tuple[Array, Array], shift: float) -> None:
        """Go back to an earlier `memory` with another torque-sensor bias: what came since was taken for twist.

        Args:
            earlier: Mean and covariance before the bias changed.
            shift: Change of beta, N m.
        """
        self.mean, self._covariance = (part.copy() for part in earlier)
        self.mean[_BETA] += shift
        self._covariance[_BETA, _BETA] += (_SHIFT_SIGMA * shift) ** 2

    @property
    def memory(self) -> tuple[Array, Array]:
        """Mean and covariance of the states, for `shift_bias`."""
        return self.mean.copy(), self._covariance.copy()

    @property
    def estimate(self) -> StringEstimate:
        """The corrections as they stand."""
        mean, covariance = self.mean, self._covariance  # asked for several times a sample, so without arrays
        sigma_s, sigma_k, sigma_beta = (math.sqrt(covariance[k, k]) for k in (_S, _K, _BETA))
        return StringEstimate(float(mean[_S]), sigma_s, float(mean[_K]), sigma_k, float(mean[_BETA]), sigma_beta,
                              self.response_time * math.exp(float(mean[_TAU])))

    def _min_log_time(self) -> float:
        """Lower bound of l.

        After the loop has corrected the error of one MWD sample, the next one reads as if the bit had followed
        immediately. Without a bound, few samples make the string look quicker than torsion spreads.
        """
        shortest = min(self._min_response_time, self.response_time)
        return max(math.log(max(shortest, 1e-3) / self.response_time), -_MAX_LOG_TIME)

    @property
    def tool_face(self) -> float:
        """x, rad."""
        return float(self.mean[_X])

    @property
    def offset(self) -> float:
        """b, rad."""
        return float(self.mean[_B])

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

    def driving_twist(self, torque: float, reactive_torque: float) -> float:
        """S (M - T), rad, from the measured mean torque and the torque from pressure, N m."""
        return self.compliance * (torque - float(self.mean[_BETA]) - self.motor_gain * reactive_torque)

    def twist(self, torque: float, reactive_torque: float, torque_share: float) -> float:
        """Twist of the whole string, rad; torque_share: w."""
        carried = (torque_share * (torque - float(self.mean[_BETA]))
                   + (1.0 - torque_share) * self.motor_gain * reactive_torque)
        return self.compliance * carried

    def follow_torque_step(self, change: float, torque_share: float) -> None:
        """Turn the toolface by a change of the reactive torque (from pressure, N m).

        The pipe near the bit twists immediately, long before the response time.
        """
        moved = self.compliance * self.motor_gain * change
        self.mean[_X] -= (1.0 - torque_share) * moved
        self._covariance[_X, _X] += (_STEP_SIGMA * moved) ** 2

    def advance(
        self, step: float, torque: float, reactive_torque: float, mobility: float, walk: float, drift: float
    ) -> None:
        """Prediction step.

        Args:
            step: s.
            torque: Measured mean at surface, N m.
            reactive_torque: From pressure, N m.
            mobility: Factor on 1 / tau.
            walk: Random walk of x, rad/sqrt(s).
            drift: Random walk of b, rad/sqrt(s).
        """
        driving_twist = self.driving_twist(torque, reactive_torque)
        share = mobility * step / (self.response_time * math.exp(float(self.mean[_TAU])))
        transition = np.eye(_STATES)
        transition[_X, _S] = share * driving_twist / (1.0 + self.mean[_S])
        transition[_X, _K] = -share * self.compliance * reactive_torque
        transition[_X, _BETA] = -share * self.compliance
        transition[_X, _TAU] = -share * driving_twist
        # The swing is forgotten unless MWD renews it.
        decay = math.exp(-step / _SWING_TIME)
        transition[_C, _C] = transition[_D, _D] = decay
        self.mean[_X] += share * driving_twist
        self.mean[_C:] *= decay
        noise = np.array([walk * walk, drift * drift, *(value**2 for value in _RANDOM_WALK.values()), 0.0, 0.0]) * step
        noise[_C:] = (1.0 - decay * decay) * _SWING_SIGMA**2
        self._covariance = transition @ self._covariance @ transition.T + np.diag(noise)

    def update_with_cycle(
        self, angle: float, mean_tool_face: float, torque: float, reactive_torque: float, torque_share: float,
        variance: float,
    ) -> float:  # fmt: skip
        """Correction step with the average of a rocking cycle.

        Args:
            angle: Mean of the top drive, rad.
            mean_tool_face: x as estimated over the cycle, rad.
            torque: Mean at surface, N m.
            reactive_torque: Mean from pressure, N m.
            torque_share: w.
            variance: Of the twist law, rad2.

        Returns:
            Change of x, rad.
        """
        mean = self.mean
        expected = mean_tool_face - mean[_B] + self.twist(torque, reactive_torque, torque_share)
        row = np.zeros(_STATES)
        row[_X], row[_B] = 1.0, -1.0
        row[_S] = self.twist(torque, reactive_torque, torque_share) / (1.0 + mean[_S])
        row[_K] = self.compliance * (1.0 - torque_share) * reactive_torque
        row[_BETA] = -self.compliance * torque_share
        return self._correct(row, angle - expected, variance)

    def update_with_mwd(self, innovation: float, phase: float, variance: float, inlier_probability: float) -> float:
        """Correction step with an MWD sample.

        Args:
            innovation: Sample minus toolface and swing as estimated when it was read, rad.
            phase: Of rocking when it was read, rad; NaN where unknown.
            variance: Of the sample, rad2.
            inlier_probability: Probability that the sample is no outlier.

        Returns:
            Change of x, rad.
        """
        return self._correct(_mwd_row(phase), innovation, variance, inlier_probability)

    def mwd_variance(self, phase: float) -> float:
        """Variance (rad2) of the predicted MWD reading at this phase (rad), without the sample's own noise."""
        row = _mwd_row(phase)
        return float(row @ self._covariance @ row)

    def swing_at(self, phase: float) -> float:
        """Estimated swing at this phase (rad), rad."""
        return float(_mwd_row(phase)[_C:] @ self.mean[_C:])

    @property
    def swing(self) -> float:
        """Amplitude of the swing, rad, less what noise adds to it."""
        squared = float(self.mean[_C] ** 2 + self.mean[_D] ** 2) - 2.0 * self.swing_sigma**2
        return math.sqrt(max(squared, 0.0))

    @property
    def swing_sigma(self) -> float:
        """One standard deviation of the swing, rad."""
        return math.sqrt(0.5 * float(self._covariance[_C, _C] + self._covariance[_D, _D]))

    def _correct(self, row: Array, innovation: float, variance: float, inlier_probability: float = 1.0) -> float:
        """Correction step of a mixture: the measurement is right, or it says nothing (probabilistic data association).

        Returns the change of x, rad.
        """
        before = float(self.mean[_X])
        covariance = self._covariance
        gain = covariance @ row / (row @ covariance @ row + variance)
        self.mean = self.mean + inlier_probability * innovation * gain
        self.mean[_S] = min(max(self.mean[_S], _MIN_S), _MAX_CORRECTION)
        self.mean[_K] = min(max(self.mean[_K], _MIN_K), _MAX_CORRECTION)
        self.mean[_TAU] = min(max(self.mean[_TAU], self._min_log_time()), _MAX_LOG_TIME)
        left = np.eye(_STATES) - np.outer(gain, row)
        updated = left @ covariance @ left.T + variance * np.outer(gain, gain)
        # Variance between the means of the two cases.
        between = inlier_probability * (1.0 - inlier_probability) * innovation**2 * np.outer(gain, gain)
        self._covariance = inlier_probability * updated + (1.0 - inlier_probability) * covariance + between
        return float(self.mean[_X]) - before


def _mwd_row(phase: float) -> Array:
    """Measurement row of MWD at this phase (rad); NaN, an unknown phase, reads the mean toolface."""
    row = np.zeros(_STATES)
    row[_X] = 1.0
    if math.isfinite(phase):
        row[_C], row[_D] = math.cos(phase), math.sin(phase)
    return row
