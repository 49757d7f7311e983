"""Benchmarks of `slider-drilling bench`: each figure beside a reference from the same run."""
