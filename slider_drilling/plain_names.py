"""Keys as people say them: spelled as SPE and IADC spell them, without underscores."""

from __future__ import annotations

_SPELLED = {"tool face": "toolface", "draw works": "drawworks", "mwd": "MWD"}


def plain_name(key: str) -> str:
    """The words for a key of a channel, an effect, a site, a parameter or a status.

    Args:
        key: Such as ``mwd_tool_face``, which is the MWD toolface.
    """
    words = f" {key.replace('_', ' ')} "
    for keyed, spelled in _SPELLED.items():
        words = words.replace(f" {keyed} ", f" {spelled} ")
    return words[1:-1]
