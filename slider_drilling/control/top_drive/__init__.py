"""Top-drive control: rocking reference, amplitude and the centre of rocking."""
