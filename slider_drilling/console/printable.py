"""Text from files, logs and arguments as a terminal may show it."""

from __future__ import annotations

import re

# What moves a terminal's cursor, changes its colours or title, turns the direction of reading round, or is half a
# character: bytes of a file's name that are no UTF-8 come as such halves.
_STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


def printable(text: str) -> str:
    r"""The text with every character that would steer a terminal, or that UTF-8 does not have, as its escape (\x1b)."""
    return _STEERING.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)


def is_valid_utf8(text: str) -> bool:
    """Whether UTF-8 can hold it: an argument that was not UTF-8 comes with halves of characters."""
    return not any("\ud800" <= character <= "\udfff" for character in text)
