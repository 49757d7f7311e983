"""The page's token, in a file that only its owner can read.

A token on a command line stands in `ps`, one in a parameter is given to every node that asks, and one in a log message
is on /rosout and in log files.
"""

from __future__ import annotations

import os
import re
import secrets
import stat
import tempfile
from dataclasses import dataclass
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text

_TOKEN = re.compile(r"[A-Za-z0-9]{8,200}")


@dataclass(frozen=True)
class TokenFile:
    """A token and where it is.

    Attributes:
        token: Letters and digits.
        path: Its file.
        is_temporary: Whether the file is to be deleted at the end.
    """

    token: str
    path: Path
    is_temporary: bool

    @property
    def query(self) -> str:
        """The end of the page's address, which a shell completes with the token."""
        return f"?token=$(cat {self.path})"

    def remove(self) -> None:
        """Delete a temporary file."""
        if self.is_temporary:
            self.path.unlink(missing_ok=True)


def open_token_file(name: str) -> TokenFile:
    """The token of a file.

    Args:
        name: Of the file, which is made with a random token if it does not exist; "" for a temporary one.

    Raises:
        InputError: The file cannot be read or made, others can read it, or it holds no token.
    """
    if not name:
        folder = os.environ.get("XDG_RUNTIME_DIR")
        folder = folder if folder and os.path.isdir(folder) else tempfile.gettempdir()
        descriptor, made = tempfile.mkstemp(prefix="slider_drilling_token_", dir=folder)
        return TokenFile(_write_random(descriptor), Path(made), True)
    path = Path(name)
    try:
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        return TokenFile(_read(path), path, False)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot make this token file: {getattr(error, 'strerror', error)}") from None
    return TokenFile(_write_random(descriptor), path, False)


def _write_random(descriptor: int) -> str:
    token = secrets.token_hex(16)
    with os.fdopen(descriptor, "w") as file:
        file.write(f"{token}\n")
    return token


def _read(path: Path) -> str:
    token = read_text(path, "token file", max_bytes=1000).strip()
    if stat.S_IMODE(path.stat().st_mode) & (stat.S_IRWXG | stat.S_IRWXO):
        raise InputError(f"{path}: others can read this token; `chmod 600` it")
    if not _TOKEN.fullmatch(token):
        raise InputError(f"{path}: not a token: must be 8 to 200 letters and digits")
    return token
