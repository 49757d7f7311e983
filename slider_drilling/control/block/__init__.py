"""Block control: auto-driller, return to bottom and heave compensation."""
