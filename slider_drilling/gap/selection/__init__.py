"""Selection of effects: calibration, forward selection by the naming criteria, and the verdict."""
