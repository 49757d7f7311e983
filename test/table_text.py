"""Tables written for a test, and what is read from them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from slider_drilling.log import RigLog

KLBF = 4448.2216152605


def written(folder: Path, text: str, encoding: str = "utf-8", name: str = "t.csv") -> Path:
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


def hook(log: RigLog) -> np.ndarray:
    assert log.draw_works is not None
    return log.draw_works.effort / KLBF
