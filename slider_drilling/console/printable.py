"""Makes text from files, logs and arguments safe to print on a terminal."""

from __future__ import annotations

import re

# Control characters, changes of reading direction, and surrogates, which stand for bytes of a file name that is not
# valid UTF-8.
_UNSAFE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


def printable(text: str) -> str:
    r"""The text with control characters and characters that UTF-8 does not have replaced by escapes such as \x1b."""
    return _UNSAFE.sub(lambda match: match[0].encode("unicode_escape").decode("ascii"), text)


def is_valid_utf8(text: str) -> bool:
    """Whether UTF-8 can encode a text; an argument that was not UTF-8 holds surrogates."""
    return not any("\ud800" <= character <= "\udfff" for character in text)
