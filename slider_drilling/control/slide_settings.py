"""Settings of SlideController, each with unit, range and meaning."""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.control.settings import setting


@dataclass(frozen=True)
class SlideSettings:
    """A setting of 0 whose description says "own" is found by the controller itself."""

    amplitude: float = setting(0.0, "rad", 0.0, 200.0, "rocking amplitude, to either side; 0: own")
    period: float = setting(0.0, "s", 0.0, 300.0, "rocking period; 0: own")
    holding_amplitude_share: float = setting(
        0.53, "-", 0.05, 1.2, "amplitude over that which frees the whole string, holding")
    setting_amplitude_share: float = setting(0.60, "-", 0.05, 1.5, "the same while the toolface is being set")
    friction_factor: float = setting(0.235, "-", 0.02, 1.0, "friction factor believed where the rig file says 1")
    rounding_acceleration: float = setting(16.0, "rad/s2", 0.5, 100.0, "acceleration at the reversals")
    max_rocking_speed: float = setting(12.0, "rad/s", 0.1, 30.0, "fastest stroke")
    make_up_torque_limit: float = setting(25e3, "N m", 500.0, 100e3, "never more to the right: make-up")
    back_off_torque_limit: float = setting(15e3, "N m", 500.0, 100e3, "never more to the left: back-off")
    right_reversal_torque: float = setting(0.0, "N m", 0.0, 100e3, "end strokes to the right here; 0: at amplitude")
    left_reversal_torque: float = setting(0.0, "N m", 0.0, 100e3, "end strokes to the left here; 0: at amplitude")
    response_time: float = setting(0.0, "s", 0.0, 600.0, "lag of the toolface behind the centre; 0: own")
    gain: float = setting(4.5, "-", 0.0, 8.0, "most centre shift per toolface error, beyond feed-forward")
    trim_rate: float = setting(0.01, "1/s", 0.0, 0.1, "speed of the centre per toolface error, near the target")
    max_lead: float = setting(5.0, "rad", 0.0, 40.0, "most that the error may shift the centre")
    feed_forward: float = setting(1.0, "-", 0.0, 1.5, "share of the reactive twist given to the centre")
    rate_of_penetration: float = setting(0.0025, "m/s", 0.0, 0.05, "drilling rate that sets the pressure wanted")
    differential_pressure: float = setting(0.0, "Pa", 0.0, 20e6, "pressure wanted; 0: from the drilling rate")
    pressure_ramp_time: float = setting(60.0, "s", 5.0, 600.0, "from no weight on bit to the pressure wanted")
    auto_driller_time: float = setting(0.0, "s", 0.0, 600.0, "in which an error of pressure decays; 0: own")
    max_block_speed: float = setting(0.1, "m/s", 0.0, 0.1, "fastest lowering")
    pick_up_speed: float = setting(0.2, "m/s", 0.005, 0.5, "at which the bit is lifted after a stall")
    compensation_speed: float = setting(0.2, "m/s", 0.0, 1.0, "fastest that the block moves against heave; 0: not")
    off_bottom_pressure: float = setting(0.0, "Pa", 0.0, 100e6, "at reference flow, off bottom; 0: rig file's")
    pump_speed: float = setting(0.0, "rad/s", 0.0, 60.0, "crank speed of the mud pump; 0: for reference flow")
    stall_share: float = setting(0.85, "-", 0.2, 1.0, "share of the motor's limit that counts as stall")
    rocking: float = setting(1.0, "-", 0.0, 1.0, "0 parks the top drive smoothly, 1 rocks")
