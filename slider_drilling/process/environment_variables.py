"""Checks environment variables whose bad values would make libraries fail with a traceback on import."""

from __future__ import annotations

from collections.abc import Mapping

from slider_drilling.errors import InputError


def check_variables(variables: Mapping[str, str]) -> None:
    """Raises InputError if SOURCE_DATE_EPOCH, from which numpy and matplotlib take dates, is not a number."""
    given = variables.get("SOURCE_DATE_EPOCH", "0")
    try:
        int(given)
    except ValueError:
        raise InputError(
            f"SOURCE_DATE_EPOCH = {given!r}: must be a whole number of seconds since 1970; correct it, or unset it"
        ) from None
