"""Campaigns: many independent jobs, each a pure function of files, on this machine or on a cluster."""
