import numpy as np

from slider_drilling.twin.channels import COMPARED
from slider_drilling.twin.features import features


def _found(expected, more):
    grid = np.repeat(expected[:, None], len(COMPARED), axis=1)
    noise = dict.fromkeys(COMPARED, 2.0)
    found = features(np.full(grid.shape, more), grid, np.zeros((*grid.shape, 1)), noise)
    return {(feature.channel, feature.kind): feature.value for feature in found}


def test_mean_of_a_channel_that_stands_still_is_all_of_it():
    """Rounding makes a channel that stands still differ from its mean: that is no shape of its own."""
    standing = np.full(100, 1.7e7 / 3.0)
    assert standing.mean() != standing[0]
    found = _found(standing, 8.0)
    assert abs(found["standpipe_pressure", "mean"] - 4.0) < 1e-9
    assert abs(found["standpipe_pressure", "gain"]) + abs(found["standpipe_pressure", "lag"]) < 1e-9


def test_mean_is_told_from_the_shape_of_a_channel():
    swing = 10.0 * np.sin(np.arange(100) / 5.0)
    found = _found(swing, 8.0)
    assert abs(found["surface_torque", "mean"] - 4.0) < 1e-9 and abs(found["surface_torque", "gain"]) < 1e-9
