"""Sealed slides: a controller slides on a foreign rig, operations come in between, and in most something begins."""
