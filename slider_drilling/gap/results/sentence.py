"""The verdict on any model as one sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence

from slider_drilling.gap.evidence.adequacy import HARDLY_MORE_THAN_NOISE
from slider_drilling.plain_names import plain_name


def verdict_sentence(
    verdict: str,
    effects: tuple[str, ...],
    site: str | None,
    gaps: tuple[float, float, float, float],
    closed: float,
    interval: tuple[float, float],
    alternative: str = "",
    remainder: str = "",
    masked_effects: tuple[str, ...] = (),
    misfit_channels: tuple[str, ...] = (),
    fed_back: str | None = None,
    small_cause: str | None = None,
) -> str:
    """The verdict with its figures.

    Args:
        verdict: ``none``, ``parameters``, ``effect``, ``effect_and_unknown`` or ``unknown``.
        effects: What is named.
        site: Where an unknown cause most likely lies.
        gaps: E as given, calibrated, with the effects (NaN without any), and its null threshold.
        closed: Share of the gap that the effects close, NaN where it says nothing.
        interval: Its 95 % interval, NaN where it says nothing.
        alternative: A free form that fits as well as the effects.
        remainder: The free form that predicts best what they leave.
        masked_effects: Effects that calibration may hide.
        misfit_channels: Channels that the final model misfits.
        fed_back: The measured channel that is fed back in the runs that E counts.
        small_cause: An effect too small to act on that explains what calibration leaves.
    """
    nominal, calibrated, with_effects, threshold = gaps
    final = calibrated if math.isnan(with_effects) else with_effects
    fed = f"with the measured {plain_name(fed_back)} fed back " if fed_back else ""
    figures = f"E {fed}{nominal:.2f} as given, {calibrated:.2f} calibrated"
    figures += "" if math.isnan(with_effects) else f", {with_effects:.2f} with it"
    figures += f"; up to {threshold:.2f} counts as no gap"
    figures += _structured_residual_clause(verdict, final, threshold, misfit_channels)
    if verdict == "none":
        return f"The model as given leaves only noise ({figures})."
    if verdict == "parameters":
        hidden = f", which may hide {' or '.join(masked_effects)}" if masked_effects else ""
        rest = f", and {small_cause}, too small to act on, explains the rest" if small_cause else ""
        return f"The model only needs calibration{hidden}{rest} ({figures})."
    if verdict == "unknown":
        return f"No known effect explains what calibration leaves, most likely at the {site or 'model'} ({figures})."
    text = f"{' and '.join(effects)}: explains the log best"
    if not math.isnan(closed) and calibrated > HARDLY_MORE_THAN_NOISE:
        span = "" if math.isnan(interval[0]) else f" [{interval[0]:.2f}, {interval[1]:.2f}]"
        text += f" and closes {closed:.2f}{span} of the gap"
    if verdict == "effect":
        return f"{text} ({figures})."
    rest = f"a structured residual remains{f': {remainder}' if remainder else ''}"
    return f"Like {text} ({figures}); {f'{alternative} fits as well' if alternative else rest}."


def _structured_residual_clause(verdict: str, gap: float, threshold: float, channels: Sequence[str]) -> str:
    """Which channels are not noise, where E alone would not show it and the verdict says that something is left."""
    if verdict not in ("unknown", "effect_and_unknown") or gap > threshold or not channels:
        return ""
    return f", but the residual of {' and '.join(channels)} is not noise"
