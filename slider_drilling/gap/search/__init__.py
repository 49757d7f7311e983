"""Search for parameter values: least squares, screening of effects, races of fits, and global search."""
