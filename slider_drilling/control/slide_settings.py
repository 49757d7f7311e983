"""Settings of SlideController, each with unit, range and meaning."""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.control.settings import setting


@dataclass(frozen=True)
class SlideSettings:
    """Settings of SlideController; where the description says "0: automatic" the controller finds the value itself."""

    amplitude: float = setting(0.0, "rad", 0.0, 200.0, "rocking amplitude, to either side; 0: automatic")
    period: float = setting(0.0, "s", 0.0, 300.0, "rocking period; 0: automatic")
    holding_amplitude_share: float = setting(
        0.53, "-", 0.05, 1.2, "amplitude over the one that frees the whole string, while the toolface is held")
    setting_amplitude_share: float = setting(0.60, "-", 0.05, 1.5, "the same while the toolface is being set")
    friction_factor: float = setting(
        0.235, "-", 0.02, 1.0, "friction factor assumed where the rig file's factor is 1, until measured")
    rounding_acceleration: float = setting(16.0, "rad/s2", 0.5, 100.0, "acceleration at the reversals")
    max_rocking_speed: float = setting(12.0, "rad/s", 0.1, 30.0, "fastest stroke")
    make_up_torque_limit: float = setting(25e3, "N m", 500.0, 100e3, "torque limit to the right (make-up)")
    back_off_torque_limit: float = setting(15e3, "N m", 500.0, 100e3, "torque limit to the left (back-off)")
    right_reversal_torque: float = setting(
        0.0, "N m", 0.0, 100e3, "reverse strokes to the right at this torque; 0: at the amplitude")
    left_reversal_torque: float = setting(
        0.0, "N m", 0.0, 100e3, "reverse strokes to the left at this torque; 0: at the amplitude")
    response_time: float = setting(
        0.0, "s", 0.0, 600.0, "lag of the toolface behind the centre of rocking; 0: automatic")
    gain: float = setting(4.5, "-", 0.0, 8.0, "largest centre shift per toolface error, beyond feed-forward")
    trim_rate: float = setting(0.01, "1/s", 0.0, 0.1, "speed of the centre per toolface error, near the target")
    max_lead: float = setting(5.0, "rad", 0.0, 40.0, "largest centre shift for the toolface error")
    feed_forward: float = setting(1.0, "-", 0.0, 1.5, "share of the reactive twist given to the centre")
    rate_of_penetration: float = setting(
        0.0025, "m/s", 0.0, 0.05, "rate of penetration that sets the target pressure")
    differential_pressure: float = setting(
        0.0, "Pa", 0.0, 20e6, "target pressure across the motor; 0: from the rate of penetration")
    pressure_ramp_time: float = setting(60.0, "s", 5.0, 600.0, "from no weight on bit to the target pressure")
    auto_driller_time: float = setting(0.0, "s", 0.0, 600.0, "time constant of a pressure error; 0: automatic")
    max_block_speed: float = setting(0.1, "m/s", 0.0, 0.1, "fastest lowering")
    pick_up_speed: float = setting(0.2, "m/s", 0.005, 0.5, "speed at which the bit is lifted after a stall")
    compensation_speed: float = setting(
        0.2, "m/s", 0.0, 1.0, "fastest block speed against heave; 0: no compensation")
    off_bottom_pressure: float = setting(
        0.0, "Pa", 0.0, 100e6, "standpipe pressure at reference flow, off bottom; 0: the rig file's")
    pump_speed: float = setting(0.0, "rad/s", 0.0, 60.0, "crank speed of the mud pump; 0: for the reference flow")
    weight_on_bit_limit: float = setting(
        0.0, "N", 0.0, 1e6, "largest weight on bit by hook load or torque; 0: 1.4 times the target weight")
    stall_share: float = setting(0.85, "-", 0.2, 1.0, "share of the motor's pressure limit that counts as stall")
    rocking: float = setting(1.0, "-", 0.0, 1.0, "0 parks the top drive smoothly, 1 rocks")
