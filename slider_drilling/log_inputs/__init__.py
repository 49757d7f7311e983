"""Inputs of the plant that are rebuilt from a log: commands, the initial state, and motion or flow that is missing.

`commands_from_log` puts them together. The other modules each repair one thing: gaps (`fill_drive_gaps`,
`fill_pump_gaps`), a position and a speed that disagree (`fuse_position_and_speed`), and channels that the log lacks
(`reconstruct_block`, `reconstruct_flow`).
"""
