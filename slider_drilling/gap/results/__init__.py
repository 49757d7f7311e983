"""What is said in the end: where the gap lies, how far the model foretells, what to do next."""
