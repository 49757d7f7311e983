"""One job of a campaign: a function, the files it reads, its options and its seed."""

from __future__ import annotations

import hashlib
import importlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from slider_drilling.campaign.code_version import code_version
from slider_drilling.errors import InputError


def key_of(dependencies: Any) -> str:
    """Returns the key of what `Job.dependencies` returned."""
    return hashlib.sha256(json.dumps(dependencies, sort_keys=True).encode()).hexdigest()[:24]


@dataclass(frozen=True)
class Job:
    """A call of a pure function: the same files, options, seed and code give the same result.

    Attributes:
        call: ``module:function``. The function takes this job and returns a tree that JSON can hold.
        name: For messages.
        inputs: Files that the function reads, by the names under which it knows them.
        options: A tree that JSON can hold.
        seed: Of the function.
        outputs: Files that the function writes besides its result. The job is done only while they exist.
        forbidden_folders: Folders in which the function can open nothing but its inputs and outputs.
        new_process: Whether the function needs a process that has run no other job, as one that measures its memory
            does.
    """

    call: str
    name: str
    inputs: Mapping[str, str] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0
    outputs: tuple[str, ...] = ()
    forbidden_folders: tuple[str, ...] = ()
    new_process: bool = False

    def dependencies(self) -> dict[str, Any]:
        """Returns everything that the result depends on.

        Raises:
            InputError: An input cannot be read.
        """
        return {
            "call": self.call,
            "inputs": {name: _hash_of_path(path) for name, path in sorted(self.inputs.items())},
            "options": dict(self.options),
            "seed": self.seed,
            "code": code_version(),
        }

    def key(self) -> str:
        """Returns the name of the result: a hash of `dependencies`.

        Raises:
            InputError: An input cannot be read.
        """
        return key_of(self.dependencies())

    def function(self) -> Callable[[Job], dict[str, Any]]:
        """Imports the function that `call` names."""
        module, _, name = self.call.partition(":")
        function: Callable[[Job], dict[str, Any]] = getattr(importlib.import_module(module), name)
        return function


def _hash_of_path(path: str) -> str:
    """Hash of a file, or of the names and contents of the files in a folder, such as a bag. Raises InputError."""
    if not Path(path).is_dir():
        return _hash_of_file(path)
    files = sorted(file for file in Path(path).iterdir() if file.is_file())
    return hashlib.sha256(json.dumps([[file.name, _hash_of_file(str(file))] for file in files]).encode()).hexdigest()


def _hash_of_file(path: str) -> str:
    try:
        with Path(path).open("rb") as file:
            digest = hashlib.sha256()
            while block := file.read(1 << 20):
                digest.update(block)
            return digest.hexdigest()
    except OSError as error:
        raise InputError(f"{path}: cannot read this file: {error.strerror}") from None
