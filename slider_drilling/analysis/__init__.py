"""Friction in a log, and where along the string it acts.

`cycles` reads torque and angle alone, `fit_friction` fits the plant's friction to the log, `along_string` simulates the
fitted plant to see downhole, `report` writes the result. `torque_drag` draws the broomstick plot.
"""
