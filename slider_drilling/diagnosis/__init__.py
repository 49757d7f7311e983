"""The drill string under the gap engine: what is wrong with this rig's simulation, and how far it can be mended."""
