"""The hole and the string in it: well path, mesh, side force, and loads at rest or in steady motion."""
