"""The structure of a foreign plant: small differences from our model that no effect of the catalogue is.

A plant draws all of them at once, whatever effect it carries, so that a diagnosis is never tried on a plant of its own
kind. `draw_structure` says which ranges have a source, and which are assumed.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np


class FrictionState(IntEnum):
    """Which law holds the memory of a contact, in place of the paper's two-dimensional Dahl operator."""

    REGULARISED_COULOMB = 0  # no memory: force along the slip, smoothed below a creep speed
    RADIAL_DAHL = 1  # LuGre without its damping: dz/dt = v - |v| z / z_ss, one vector
    ELASTO_PLASTIC = 2  # Dupont et al. 2002: purely elastic up to a break-away stretch


@dataclass(frozen=True)
class Structure:
    """What a foreign plant has that the nominal one has not.

    Attributes:
        friction_state: law of the contact's memory.
        presliding: m, stretch of a contact that slips.
        break_away: share of `presliding` below which an elasto-plastic contact does not slip.
        creep_speed: m/s, at which regularised Coulomb friction reaches 0.7 of itself.
        isotropy: share (0 to 1) of the direction dependence of friction that is missing.
        bending_length: m, over which the pipe's bending stiffness spreads a change of curvature.
        bending_force: share of the beam's own side force ``E I d2 kappa / ds2``.
        joint_weight: share by which tool joints make the string heavier than its section.
        joint_radius: share by which friction acts at a larger radius, on the joints.
        joint_stiffness: share by which joints make the string stiffer in torsion.
        added_mass: share of mud that moves with the pipe, of its mass.
        slow_friction, slow_bit, slow_pressure: standard deviation of slow changes of friction, bit torque per weight
            and circulating pressure, shares.
        slow_memory: s, of these changes.
        drive_lag: s, of the top drive's speed loop.
        drive_droop: rad/s per N m, by which load slows the drive.
        ripple: share of the torque, once and six times a turn of the drive.
        encoder_step: rad, resolution of the drive's encoder.
        deadline_hysteresis: N, friction of sheaves and dead line, against the block's motion.
        hook_load_offset: N, what is left of the block's weight after the tare.
        hook_load_gain, torque_gain: shares by which readings are off.
        torque_filter: s, first-order filter of the torque reading.
        held_hook_load: s, for which the hook load reading is held (its own sampling interval).
        clock_jitter: s, standard deviation of stamps.
        warming: share of circulating pressure lost in all as the mud warms up.
        warming_time: s, of it.
        pump_ripple: share of standpipe pressure, at three times the pump's strokes.
    """

    friction_state: FrictionState = FrictionState.RADIAL_DAHL
    presliding: float = 0.01
    break_away: float = 0.7
    creep_speed: float = 2e-5
    isotropy: float = 0.0
    bending_length: float = 0.0
    bending_force: float = 0.0
    joint_weight: float = 0.0
    joint_radius: float = 0.0
    joint_stiffness: float = 0.0
    added_mass: float = 0.0
    slow_friction: float = 0.0
    slow_bit: float = 0.0
    slow_pressure: float = 0.0
    slow_memory: float = 60.0
    drive_lag: float = 0.0
    drive_droop: float = 0.0
    ripple: float = 0.0
    encoder_step: float = 0.0
    deadline_hysteresis: float = 0.0
    hook_load_offset: float = 0.0
    hook_load_gain: float = 0.0
    torque_gain: float = 0.0
    torque_filter: float = 0.0
    held_hook_load: float = 0.0
    clock_jitter: float = 0.0
    warming: float = 0.0
    warming_time: float = 600.0
    pump_ripple: float = 0.0


def draw_structure(generator: np.random.Generator) -> Structure:
    """A structure as rigs have it.

    Sources of the ranges: friction states, Dupont et al., IEEE TAC 47 (2002), and Astrom and Canudas de Wit, IEEE CSM
    28 (2008); stiff string, Ho, SPE 18047 (1988), and Mitchell and Samuel, SPE 105068 (2009); tool joints, API RP 7G
    (adjusted weights 4 to 12 % above plain ends, of which a tally keeps most) and API 5DP (joint 1.2 to 1.3 times the
    pipe's diameter, in contact over a part of the load); dead line and sheaves, Luke and Juvkam-Wold, SPE Drilling
    Engineering 8 (1993): 1 to 3 % of the load; hook load and torque transducers, 0.5 to 2 % (Cayeux et al., SPE 163492,
    2013); pressure and temperature of mud, Bourgoyne et al., Applied Drilling Engineering (1986). Assumed, for want of
    a published range: added mass, slow changes, lag, droop, ripple and encoder (10 to 14 bits) of the drive, filter,
    hold and stamps of readings, and ripple of the pumps.

    Args:
        generator: source of randomness.

    Returns:
        The structure drawn.
    """
    uniform, normal = generator.uniform, generator.normal
    return Structure(
        friction_state=FrictionState(int(generator.integers(3))),
        presliding=float(uniform(0.004, 0.016)),
        break_away=float(uniform(0.5, 0.9)),
        creep_speed=float(10.0 ** uniform(-5.3, -4.5)),
        isotropy=float(uniform(0.0, 1.0)),
        bending_length=float(uniform(5.0, 30.0)),
        bending_force=float(uniform(0.0, 1.0)),
        joint_weight=float(uniform(0.0, 0.03)),
        joint_radius=float(uniform(0.0, 0.12)),
        joint_stiffness=float(uniform(0.0, 0.03)),
        added_mass=float(uniform(0.0, 0.1)),
        slow_friction=float(uniform(0.0, 0.02)),
        slow_bit=float(uniform(0.0, 0.03)),
        slow_pressure=float(uniform(0.0, 0.001)),
        slow_memory=float(uniform(30.0, 150.0)),
        drive_lag=float(uniform(0.05, 0.25)),
        drive_droop=float(uniform(0.0, 4e-6)),
        ripple=float(uniform(0.0, 0.006)),
        encoder_step=float(2.0 * np.pi / generator.choice([1024, 4096, 16384])),
        deadline_hysteresis=float(uniform(0.0, 4e3)),
        hook_load_offset=float(normal(0.0, 3e3)),
        hook_load_gain=float(normal(0.0, 0.006)),
        torque_gain=float(normal(0.0, 0.01)),
        torque_filter=float(uniform(0.0, 0.1)),
        held_hook_load=float(generator.choice([0.0, 0.2, 0.5])),
        clock_jitter=float(uniform(0.0, 0.004)),
        warming=float(normal(0.0, 0.004)),
        warming_time=float(uniform(300.0, 1200.0)),
        pump_ripple=float(uniform(0.0, 0.001)),
    )
