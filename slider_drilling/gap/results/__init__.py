"""What is reported beside the verdict: where the gap lies, parameter intervals, prediction errors, the next run."""
