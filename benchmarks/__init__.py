"""Benchmarks beyond `slider-drilling bench`: `make bench` runs them all and writes docs/benchmarks.md."""
