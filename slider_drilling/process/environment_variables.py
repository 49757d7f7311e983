"""Variables of the environment that libraries read as they are loaded, and would answer with a traceback."""

from __future__ import annotations

from collections.abc import Mapping

from slider_drilling.errors import InputError


def check_variables(variables: Mapping[str, str]) -> None:
    """Raises InputError for a SOURCE_DATE_EPOCH that is no number: numpy and matplotlib date by it what they make."""
    given = variables.get("SOURCE_DATE_EPOCH", "0")
    try:
        int(given)
    except ValueError:
        raise InputError(
            f"SOURCE_DATE_EPOCH = {given!r}: must be a whole number of seconds since 1970; mend it, or unset it"
        ) from None
