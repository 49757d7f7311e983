"""Where parameters are looked for: least squares from many starts, and the race between explanations."""
