"""The hole and the string that lies in it: course, mesh, and loads at rest or in steady motion."""
