"""What is to be explained: residuals of all runs and channels, their noise, and how the model is run."""
