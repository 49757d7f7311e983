"""The verdict of any model as one sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence


def verdict_sentence(
    verdict: str, effects: tuple[str, ...], site: str | None, gaps: tuple[float, float, float, float],
    closed: float, interval: tuple[float, float], alike: str = "", rest: str = "", instead: tuple[str, ...] = (),
    stand_out: tuple[str, ...] = (),
) -> str:  # fmt: skip
    """gaps: E as given, re-tuned, with the effects (NaN without), and what noise alone stays below; alike: what else
    foretells as much as the effects, at another site; rest: what foretells most of what they leave; instead: laws that
    re-tuning may stand for; stand_out: channels of which what is left is not noise.
    """
    nominal, tuned, explained, threshold = gaps
    figures = f"E {nominal:.2f} as given, {tuned:.2f} re-tuned"
    figures += "" if math.isnan(explained) else f", {explained:.2f} with it"
    figures += f"; noise alone stays below {threshold:.2f}"
    figures += structured_residual_clause(verdict, tuned if math.isnan(explained) else explained, threshold, stand_out)
    if verdict == "none":
        return f"The model as given leaves what noise would ({figures})."
    if verdict == "parameters":
        stands_for = f", or {' or '.join(instead)} makes it look so" if instead else ""
        return f"The model is only mis-tuned{stands_for} ({figures})."
    if verdict == "unknown":
        return f"No known effect explains what re-tuning leaves, most of it at the {site or 'model'} ({figures})."
    share = "" if math.isnan(closed) or tuned <= threshold else (
        f" and closes {closed:.2f} [{interval[0]:.2f}, {interval[1]:.2f}] of the gap"
    )
    like = "Like " if verdict == "effect_and_unknown" else ""
    remains = f"something structured remains{f': {rest}' if rest else ''}"
    beside = f"; {alike} would explain it as well" if alike else f"; {remains}"
    end = beside if verdict == "effect_and_unknown" else ""
    return f"{like}{' and '.join(effects)}: it explains the log best{share} ({figures}){end}."


def structured_residual_clause(verdict: str, left: float, threshold: float, channels: Sequence[str]) -> str:
    """What is to be said beside an E (left) that noise alone could leave, where it is not noise that is left of
    channels and the verdict says that something is.
    """
    if verdict not in ("unknown", "effect_and_unknown") or left > threshold or not channels:
        return ""
    return f", but what is left of {' and '.join(channels)} is not noise"
