"""Slide drilling: a plant, ROS 2 nodes, and the diagnosis of where the two part.

Everything inside is SI and radians; positive axial is down-hole, positive rotation is clockwise
looking down-hole.
"""

__version__ = "0.1.0"
