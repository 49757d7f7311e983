"""Optimal design of experiments: which run of the real thing would show most of what is not known yet."""
