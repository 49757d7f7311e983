"""Typed configuration files: YAML trees, and frozen dataclasses whose numbers declare unit and range."""
