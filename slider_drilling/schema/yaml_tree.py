"""YAML as plain dicts, lists, strings and decimal numbers, without the surprising conversions of YAML 1.1."""

from __future__ import annotations

import contextlib
import re
import reprlib
from typing import Any

import yaml

from slider_drilling.errors import InputError

_INTEGER = re.compile(r"[-+]?(0|[1-9][0-9]{0,999})")
_PREFIX = "tag:yaml.org,2002:"
_MAX_SHOWN = 100  # characters of a value that an error shows


def parse_yaml(text: str, source: str) -> Any:
    """The tree that a YAML text holds.

    Numbers are decimal. What YAML 1.1 would also read as a number (``12:30`` as 750, ``010`` as 8) stays text, and so
    do dates.

    Args:
        text: YAML.
        source: Names the text in errors.

    Raises:
        InputError: For invalid YAML, a repeated key, a tag, and an alias that contains itself.
    """
    try:
        node = _compose(text)
        return None if node is None else _value(node, source, {}, set())
    except yaml.YAMLError as error:
        raise InputError(f"{source}: not YAML: {' '.join(str(error).split())}") from None
    except RecursionError:
        raise InputError(f"{source}: not usable: lists or keys nested too deeply") from None


def _compose(text: str) -> yaml.Node | None:
    """The node of a YAML text.

    libyaml takes a tenth of the time, but words its errors otherwise and takes tabs for spaces: PyYAML's own parser
    reads what it refuses, and what holds tabs or is not ASCII.
    """
    if yaml.__with_libyaml__ and text.isascii() and "\t" not in text:
        with contextlib.suppress(yaml.YAMLError):
            return yaml.compose(text, Loader=yaml.CSafeLoader)
    return yaml.compose(text, Loader=yaml.SafeLoader)


def shorten(value: Any) -> str:
    """A value for an error message: on one line, shortened where it is long."""
    shortened = reprlib.Repr()
    shortened.maxstring = shortened.maxother = shortened.maxlong = _MAX_SHOWN
    shortened.maxlist = shortened.maxdict = 4
    shortened.maxlevel = 2
    return " ".join(shortened.repr(value).split())


def _value(node: yaml.Node, source: str, known: dict[int, Any], above: set[int]) -> Any:
    """The value of a node.

    known: Values of nodes seen before, by identity, since aliases share them; above: nodes that contain this one.
    """
    place = id(node)
    if place in above:
        raise InputError(f"{_line(node, source)}: an alias that contains itself; write the values out")
    if place not in known:
        if isinstance(node, yaml.ScalarNode):
            known[place] = _scalar(node, source)
        elif isinstance(node, yaml.SequenceNode):
            _check_tag(node, "seq", source)
            known[place] = [_value(item, source, known, above | {place}) for item in node.value]
        else:
            known[place] = _mapping(node, source, known, above | {place})
    return known[place]


def _mapping(node: yaml.Node, source: str, known: dict[int, Any], above: set[int]) -> dict[Any, Any]:
    _check_tag(node, "map", source)
    values: dict[Any, Any] = {}
    for key_node, value_node in node.value:
        if not isinstance(key_node, yaml.ScalarNode):
            raise InputError(f"{_line(key_node, source)}: a key must be a word")
        if key_node.tag == f"{_PREFIX}merge":
            raise InputError(f"{_line(key_node, source)}: <<: merging keys is not supported; write them out")
        key = key_node.value
        if key in values:
            raise InputError(f"{_line(key_node, source)}: {shorten(key)[1:-1]}: given twice; keep one")
        values[key] = _value(value_node, source, known, above)
    return values


def _scalar(node: yaml.ScalarNode, source: str) -> Any:
    text: str = node.value
    kind = node.tag.removeprefix(_PREFIX)
    if kind == "null":
        return None
    if kind == "bool":
        return text.lower() in ("yes", "true", "on")
    if kind == "int":
        return int(text) if _INTEGER.fullmatch(text) else text
    if kind == "float":
        return _float(text)
    if kind in ("str", "timestamp", "value"):
        return text
    raise InputError(
        f"{_line(node, source)}: {shorten(text)}: the tag {shorten(node.tag)} is not supported; leave it out"
    )


def _float(text: str) -> float | str:
    plain = text.lower().replace(".inf", "inf").replace(".nan", "nan")
    try:
        # YAML 1.1 also tags numbers with underscores and sexagesimals (1:30.5) as floats.
        return text if "_" in text else float(plain)
    except ValueError:
        return text


def _check_tag(node: yaml.Node, kind: str, source: str) -> None:
    if node.tag != f"{_PREFIX}{kind}":
        raise InputError(f"{_line(node, source)}: the tag {shorten(node.tag)} is not supported; leave it out")


def _line(node: yaml.Node, source: str) -> str:
    return f"{source}: line {node.start_mark.line + 1}"
