"""Test programmes for a rig: which one shows most of what is not known, what it shows, and a sheet for the driller."""
