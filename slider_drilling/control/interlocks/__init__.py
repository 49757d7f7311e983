"""Interlocks: conditions that stop lowering, stop rocking, end a stroke or lift the bit."""
