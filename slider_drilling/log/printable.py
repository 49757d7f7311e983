"""Text of files made by anyone, fit for a terminal and a page."""

from __future__ import annotations

import unicodedata

_KEPT = "\n\t"


def printable(text: str) -> str:
    """The text with what a terminal would obey, or a reader not see, written out as an escape: ESC as \\x1b."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        one if one in _KEPT or unicodedata.category(one) not in ("Cc", "Cf", "Cs", "Co") else _escape(one)
        for one in text
    )


def _escape(one: str) -> str:
    return one.encode("unicode_escape").decode("ascii")
