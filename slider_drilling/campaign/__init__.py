"""Campaigns: many independent jobs, each a pure function of files, on this machine or on a cluster.

`run` runs jobs and keeps their results in a folder, `worker_processes` gives each job a process that may die, `cluster`
sends jobs to a dask scheduler.
"""
