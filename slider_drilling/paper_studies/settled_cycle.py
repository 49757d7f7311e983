"""The friction to which a repeated motion settles, and how it starts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slider_drilling.contact import FrictionHistory, FrictionMeans, friction_coefficient_of_direction, friction_history
from slider_drilling.errors import InputError
from slider_drilling.paper_studies.pipe import Pipe
from slider_drilling.paper_studies.tool_motions import ToolMotion
from slider_drilling.rig import Contact

SETTLED = 1e-7
"""Largest change of the deformation from one settled cycle to the next, over z_ss."""
MAX_SAMPLES = 20_000_000
BLOCK_SAMPLES = 20_000


@dataclass(frozen=True)
class SettledCycle:
    """The last cycle of a motion that has settled.

    Attributes:
        history: Of that cycle, time from 0.
        means: Over it.
        coulomb_force: Friction of plain sliding at the same mean load, N.
    """

    history: FrictionHistory
    means: FrictionMeans
    coulomb_force: float

    @property
    def friction_ratio(self) -> float:
        """Mean magnitude of the axial force over Coulomb friction."""
        return self.means.absolute_axial_force / self.coulomb_force

    @property
    def signed_friction_ratio(self) -> float:
        """Mean axial force over Coulomb friction, positive where friction opposes the feed."""
        return -self.means.axial_force / self.coulomb_force


def coulomb_force(pipe: Pipe, contact: Contact) -> float:
    """Friction (N) of the pipe when it slides straight down the hole without vibration."""
    return float(friction_coefficient_of_direction(contact, contact.asperity.orientation)) * pipe.normal_force


def from_rest(motion: ToolMotion, duration: float, pipe: Pipe, contact: Contact) -> FrictionHistory:
    """The motion from rest without deformation, in whole periods for at least `duration` s."""
    return _cycles(motion, math.ceil(duration / motion.period - 1e-9), pipe, contact, (0.0, 0.0))


def settled_cycle(motion: ToolMotion, pipe: Pipe, contact: Contact) -> SettledCycle:
    """The cycle to which a motion settles.

    Raises InputError where it does not settle within 2e7 samples; a motion that hardly slips takes very long.
    """
    scale = coulomb_force(pipe, contact) / contact.stiffness
    per_block = max(1, BLOCK_SAMPLES // motion.time.size)
    deformation, spent = (0.0, 0.0), 0
    while spent < MAX_SAMPLES:
        history = _cycles(motion, per_block, pipe, contact, deformation)
        spent += history.time.size
        m_x, m_y = history.deformation_axial, history.deformation_tangential
        before = -motion.time.size
        change = math.hypot(m_x[-1] - m_x[before], m_y[-1] - m_y[before])
        deformation = float(m_x[-1]), float(m_y[-1])
        if change <= SETTLED * scale:
            last = _cycles(motion, 1, pipe, contact, deformation)
            return SettledCycle(last, last.means(), coulomb_force(pipe, contact))
    raise InputError(f"motion with a period of {motion.period:g} s: has not settled after {spent} samples")


def _cycles(
    motion: ToolMotion, cycles: int, pipe: Pipe, contact: Contact, deformation: tuple[float, float]
) -> FrictionHistory:
    time, axial, tangential, load = motion.repeated(cycles)
    return friction_history(
        time, axial, tangential, load * pipe.normal_force, contact, pipe.radius, deformation=deformation
    )


def harmonic_share(signal: np.ndarray) -> float:
    """Fraction of the variance of one cycle (n + 1 samples, ends joined) in its first harmonic."""
    spectrum = np.abs(np.fft.rfft(signal[:-1])) ** 2
    total = spectrum[1:].sum()
    return float(spectrum[1] / total) if total > 0.0 else 0.0
