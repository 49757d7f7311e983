"""The verdict on any model as one sentence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from slider_drilling.gap.evidence.adequacy import HARDLY_MORE_THAN_NOISE
from slider_drilling.plain_names import plain_name

NAN = math.nan


@dataclass(frozen=True)
class VerdictFigures:
    """A verdict with its figures; NaN where one says nothing.

    Attributes:
        verdict: ``none``, ``parameters``, ``effect``, ``effect_and_unknown`` or ``unknown``.
        effects: What is named.
        indistinguishable: By effect, the others that the log cannot distinguish from it.
        site: Where an unknown cause most likely lies.
        nominal: E as given.
        calibrated: E calibrated.
        with_effects: E with the effects, NaN without any.
        threshold: E up to which nothing counts as a gap.
        closed: Share of the gap that the effects close.
        interval: Its 95 % interval.
        alternative: A free form that fits as well as the effects.
        remainder: The free form that predicts best what they leave.
        masked_effects: Effects that calibration may hide.
        misfit_channels: Channels that the final model misfits.
        fed_back: The measured channel that is fed back in the runs that E counts.
        small_cause: An effect too small to act on that explains what calibration leaves.
    """

    verdict: str
    effects: tuple[str, ...] = ()
    indistinguishable: Mapping[str, Sequence[str]] = field(default_factory=dict)
    site: str | None = None
    nominal: float = NAN
    calibrated: float = NAN
    with_effects: float = NAN
    threshold: float = NAN
    closed: float = NAN
    interval: tuple[float, float] = (NAN, NAN)
    alternative: str = ""
    remainder: str = ""
    masked_effects: tuple[str, ...] = ()
    misfit_channels: tuple[str, ...] = ()
    fed_back: str | None = None
    small_cause: str | None = None

    @property
    def final(self) -> float:
        """E of the final model."""
        return self.calibrated if math.isnan(self.with_effects) else self.with_effects


def verdict_sentence(of: VerdictFigures) -> str:
    """The verdict with its figures in one sentence."""
    figures = _figures(of)
    if of.verdict == "none":
        return f"The model as given leaves only noise ({figures})."
    if of.verdict == "parameters":
        hidden = f", which may hide {' or '.join(of.masked_effects)}" if of.masked_effects else ""
        rest = f", and {of.small_cause}, too small to act on, explains the rest" if of.small_cause else ""
        return f"The model only needs calibration{hidden}{rest} ({figures})."
    if of.verdict == "unknown":
        return f"No known effect explains what calibration leaves, most likely at the {of.site or 'model'} ({figures})."
    text = f"{' and '.join(_with_others(name, of) for name in of.effects)}: explains the log best{_closes(of)}"
    if of.verdict == "effect":
        return f"{text} ({figures})."
    rest = f"a structured residual remains{f': {of.remainder}' if of.remainder else ''}"
    return f"Like {text} ({figures}); {f'{of.alternative} fits as well' if of.alternative else rest}."


def _figures(of: VerdictFigures) -> str:
    fed = f"with the measured {plain_name(of.fed_back)} fed back " if of.fed_back else ""
    text = f"E {fed}{of.nominal:.2f} as given, {of.calibrated:.2f} calibrated"
    text += "" if math.isnan(of.with_effects) else f", {of.with_effects:.2f} with it"
    return f"{text}; up to {of.threshold:.2f} counts as no gap{_structured_residual_clause(of)}"


def _with_others(name: str, of: VerdictFigures) -> str:
    others = of.indistinguishable.get(name, ())
    return name + (f" (or {' or '.join(others)}: indistinguishable)" if others else "")


def _closes(of: VerdictFigures) -> str:
    if math.isnan(of.closed) or not of.calibrated > HARDLY_MORE_THAN_NOISE:
        return ""
    low, high = of.interval
    return f" and closes {of.closed:.2f}{'' if math.isnan(low) else f' [{low:.2f}, {high:.2f}]'} of the gap"


def _structured_residual_clause(of: VerdictFigures) -> str:
    """Which channels are not noise, where E alone would not show it and the verdict says that something is left."""
    if of.verdict not in ("unknown", "effect_and_unknown") or of.final > of.threshold or not of.misfit_channels:
        return ""
    return f", but the residual of {' and '.join(of.misfit_channels)} is not noise"
