"""What a run was recorded for: the friction in its log, and where it acts. No ROS needed.

`cycles` reads torque and angle alone, `friction` fits the plant's friction to the log, `along_string` replays the
fitted plant to see downhole, `report` puts it on paper.
"""
