import numpy as np
from short_well import short_rig

from slider_drilling.drillstring import Commands, InitialState, simulate
from slider_drilling.twin.follower import Follower
from slider_drilling.twin.tracked import tracked_parameters


def test_plants_drill_on_where_the_file_s_motor_would_stall():
    """The rig may have turned on at the brink; a plant that stalls would stay so until it is picked up."""
    rig = short_rig()
    time = np.arange(0.0, 300.0, 0.1)
    turning = np.full_like(time, 6.0)
    speed = np.where(time < 60.0, 0.014, 0.0)
    lowered = np.concatenate([[0.0], np.cumsum(0.1 * speed)[:-1]])
    commands = Commands(time, 6.0 * time, turning, lowered, speed, np.full_like(time, 12.3))
    stalled = simulate(rig, commands, 30).weight_on_bit
    assert stalled[-1] > 0.95 * stalled.max()
    follower = Follower(rig, tracked_parameters(rig), 30, 0.1, 0.0, 0.0, InitialState())
    follower.advance(commands)
    assert 0.0 < follower.weight_on_bit < 0.1 * stalled[-1]
