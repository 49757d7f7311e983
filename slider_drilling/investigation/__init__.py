"""An investigation: record, diagnose, plan a test, run it, and again, until the answer stands."""
