"""The fitting problem: residuals of all runs and channels in noise units, their noise floors, and their cost."""
