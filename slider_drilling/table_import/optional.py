"""Imports the libraries that only some formats need."""

from __future__ import annotations

import importlib
from types import ModuleType

from slider_drilling.errors import InputError


def library(name: str, path: object, what: str) -> ModuleType:
    """A library of the extra `tables`. Raises InputError where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        package = name.partition(".")[0]
        raise InputError(
            f"{path}: {what} needs {package}; install it with `pip install 'slider_drilling[tables]'`"
        ) from None
