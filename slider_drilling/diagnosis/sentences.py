"""The sentences of a diagnosis: the summary in a driller's words, and the one with code names and E."""

from __future__ import annotations

import math

from slider_drilling.diagnosis.change_sentences import change_summary, change_technical_summary
from slider_drilling.diagnosis.describe_curve import describe_curve
from slider_drilling.diagnosis.effect_phrases import SITES, effect_phrase
from slider_drilling.diagnosis.hook_load_excess import SHARES_OF_EXCESS, hook_load_excess
from slider_drilling.diagnosis.replay import TOOL_FACE_TOLERANCE
from slider_drilling.diagnosis.result import (
    ChannelErrors,
    Diagnosis,
    FittedParameter,
    Gap,
    Interval,
    RankedEffect,
    ResidualShape,
)
from slider_drilling.gap.results.sentence import VerdictFigures, verdict_sentence
from slider_drilling.plain_names import plain_name
from slider_drilling.units import Quantity, Sentence, Text, displayed, format_number, sentence

_WHOLE = 0.995  # of the gap: by chance a model may leave less than the noise, and close more than the gap
_MAX_PARAMETERS = 3  # named in a sentence
_MIN_CHANGE = 0.05  # of a multiple of the rig file's value that is worth naming
_MAX_SPREAD = 3.0  # ratio of an interval's ends up to which a value counts as known
_NOISE_ALONE = 1.5  # times the noise: an error that noise alone may leave in a few toolfaces
_NOISE_ALONE_OF_MANY = 1.25  # times the noise: in a channel of many samples
_LOCATED = ("cuttings_bed",)  # named with its place, however uncertain


def summary(diagnosis: Diagnosis) -> Sentence:
    """The answer in a driller's words, a few sentences."""
    gap = diagnosis.gap
    if diagnosis.change is not None:
        ranked = [found for name in diagnosis.effects if (found := diagnosis.candidate(name)) is not None]
        return change_summary(diagnosis, _phrase(ranked[0]) if ranked else "")
    if diagnosis.verdict == "inconclusive" or gap is None:
        return sentence("This log allows no conclusion about the simulation: ", *_why_inconclusive(diagnosis), ".")
    excess = hook_load_excess(diagnosis)
    answer = _answer(diagnosis, gap)
    return answer if excess is None else sentence(answer, " ", excess)


def _answer(diagnosis: Diagnosis, gap: Gap) -> Sentence:
    """The verdict in a driller's words."""
    if diagnosis.verdict == "none":
        return sentence("The simulation with this rig file ", _matches(diagnosis, gap, "nominal"), ".")
    if diagnosis.verdict == "parameters":
        calibrated = f"The simulation only needs calibration{_calibrated(diagnosis)}. "
        return sentence(calibrated, _residual_gap(diagnosis, gap), _masked(diagnosis))
    if diagnosis.verdict == "unknown":
        return _unknown(diagnosis, gap)
    return _effects(diagnosis, gap)


def technical_summary(diagnosis: Diagnosis) -> str:
    """The answer with code names and E."""
    gap, shape = diagnosis.gap, diagnosis.residual_shape
    if diagnosis.change is not None:
        return change_technical_summary(diagnosis)
    if diagnosis.verdict == "inconclusive" or gap is None:
        return str(sentence("No conclusion: ", *_why_inconclusive(diagnosis), "."))
    ranked = {name: diagnosis.candidate(name) for name in diagnosis.effects}
    groups = {name: found.group for name, found in ranked.items() if found is not None}
    return verdict_sentence(VerdictFigures(
        diagnosis.verdict, diagnosis.effects, groups, diagnosis.site,
        _or_nan(gap.nominal), _or_nan(gap.tuned), _or_nan(gap.with_effect), _or_nan(gap.threshold),
        _or_nan(gap.closed), gap.closed_interval or (math.nan, math.nan),
        shape.disturbance if shape is not None and shape.of == "alternative" else "",
        shape.disturbance if shape is not None and shape.of == "rest" else "",
        diagnosis.masked_effects, tuple(plain_name(name) for name in gap.misfit_channels),
        diagnosis.fed_back, diagnosis.small_cause,
    ))  # fmt: skip


def remarks_beside_checks(diagnosis: Diagnosis) -> tuple[Text, ...]:
    """The remarks that the table of log checks does not hold."""
    texts = {str(issue.text) for checked in diagnosis.log_checks for issue in checked.issues}
    sources = [f"{checked.log.source}: " for checked in diagnosis.log_checks]
    held = texts | {source + text for source in sources for text in texts}
    return tuple(remark for remark in diagnosis.remarks if str(remark) not in held)


def _why_inconclusive(diagnosis: Diagnosis) -> list[Text]:
    parts: list[Text] = []
    for checked in diagnosis.log_checks:
        for issue in checked.issues:
            if issue.severity == "uninformative":
                parts += ["; ", issue.text]
    return parts[1:] or ["the fits did not converge"]


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value


def model_error_allowed(diagnosis: Diagnosis) -> str | None:
    """By how much the simulation may be wrong before anything has a name; None where nothing was compared."""
    shares: dict[float, list[str]] = {}
    for name, share in (diagnosis.gap or Gap()).model_error.items():
        shares.setdefault(share, []).append(plain_name(name))
    if not shares:
        return None
    parts = (f"{100.0 * share:g} % of the spread of {_listed(names)}" for share, names in shares.items())
    return (f"The simulation itself may be wrong by {'; '.join(parts)} (`model_error` of the rig file's sensors): "
            "nothing smaller is named.")  # fmt: skip


def _listed(names: list[str]) -> str:
    return " and ".join(part for part in (", ".join(names[:-1]), names[-1]) if part)


def prediction_horizon(diagnosis: Diagnosis) -> list[str]:
    """How far ahead the model predicts each channel."""
    errors = diagnosis.whole_run_errors
    if errors is None:
        return []
    limited = [name for name in errors.horizon if name not in errors.predictable_to_end]
    sentences = []
    if limited:
        ahead = ", ".join(f"{plain_name(name)} {errors.horizon[name]:.0f} s" for name in limited)
        sentences.append(
            f"A free simulation predicts so far before its error reaches the channel's own spread: {ahead}."
        )
    if errors.predictable_to_end:
        channels = ", ".join(plain_name(name) for name in errors.predictable_to_end)
        sentences.append(
            f"The error of a free simulation stays below the channel's own spread to the end of the log: {channels}."
        )
    return sentences


def describe_shape(shape: ResidualShape) -> Sentence:
    """A residual's shape with its numbers."""
    return describe_curve(shape.disturbance, shape.x, shape.x_unit, shape.y, shape.y_unit)


def closed_in_words(closed: float | None, interval: Interval | None) -> str:
    """The share of the gap that is closed."""
    if closed is None:
        return "the gap shrinks by a share that cannot be stated"
    if closed >= _WHOLE:
        return "the whole gap is closed"
    span = f" [{100.0 * interval[0]:.0f}, {100.0 * interval[1]:.0f}]" if interval is not None else ""
    return f"{100.0 * closed:.0f} %{span} of the gap is closed"


def while_fed_back(diagnosis: Diagnosis) -> str:
    """That a measured channel is fed back in the runs that E and shares count, as a clause; "" for free runs."""
    fed = diagnosis.fed_back
    return "" if fed is None else f" while the measured {plain_name(fed)} is fed back"


def about_shares(diagnosis: Diagnosis) -> Text:
    """The caption of the ranking: what its shares are of, and what is fed back in the runs that they count."""
    of_change = "Shares are of what calibrating again leaves." if diagnosis.change is not None else ""
    return counted(diagnosis, of_change)


def counted(diagnosis: Diagnosis, caption: Text = "") -> Text:
    """The caption of E or of shares, with what is fed back in the runs that they count."""
    clause = while_fed_back(diagnosis)
    if not clause:
        return caption
    return sentence(caption, f" Counted{clause}.") if caption else f"Counted{clause}."


def _effects(diagnosis: Diagnosis, gap: Gap) -> Sentence:
    ranked = [found for name in diagnosis.effects if (found := diagnosis.candidate(name)) is not None]
    clauses = [_phrase(effect) for effect in ranked]
    text: Text = sentence(*clauses[:1], *(sentence(", and ", lower_first(clause)) for clause in clauses[1:]))
    partial = diagnosis.verdict == "effect_and_unknown"
    if partial:
        text = sentence("The rig behaves as if ", lower_first(text))
    falls = _falls(diagnosis, gap)
    closes = closed_in_words(gap.closed, gap.closed_interval) + while_fed_back(diagnosis)
    errors: tuple[Text, ...] = () if falls is None else (falls, " and ")
    text = sentence(text, ". With that in the model, ", *errors, closes, ".")
    return sentence(text, " ", _remainder(diagnosis, gap)) if partial else text


def _remainder(diagnosis: Diagnosis, gap: Gap) -> Sentence:
    """What there is beside the named effects: a disturbance that explains as much, or what they leave."""
    shape = diagnosis.residual_shape
    if shape is not None and shape.of == "alternative":
        return sentence("Something else would explain as much: ", describe_shape(shape), ".")
    channel = _worst_channel(gap, "with_effect")
    mostly = f", mostly in {plain_name(channel)}" if channel else ""
    looks: tuple[Text, ...] = () if shape is None else ("; it looks like this: ", describe_shape(shape))
    return sentence(f"A residual that no known effect explains remains{mostly}", *looks, ".")


def _unknown(diagnosis: Diagnosis, gap: Gap) -> Sentence:
    parts: list[Text] = ["No known effect explains what calibration leaves"]
    channel = _worst_channel(gap, "tuned")
    if channel is not None:
        errors = gap.rms[channel]
        fed = diagnosis.fed_back
        feedback = "" if fed is None else f", predicted from the {plain_name(fed)} measured so far"
        parts.append(sentence(" (", displayed(errors.tuned, errors.unit, 2), f" of {plain_name(channel)}{feedback})"))
    if diagnosis.site is not None:
        parts.append(f". Most of it points at {SITES.get(diagnosis.site, diagnosis.site)}")
    if diagnosis.residual_shape is not None:
        parts += [". It looks like this: ", describe_shape(diagnosis.residual_shape)]
    return sentence(*parts, ".")


def _phrase(ranked: RankedEffect) -> Sentence:
    """The effect with the values that the log determines."""
    amplitude = next(iter(ranked.parameters), "")
    values = {
        name.rpartition(".")[2]: fitted.value for name, fitted in ranked.parameters.items()
        if name == amplitude or ranked.effect in _LOCATED or _is_known(fitted)
    }  # fmt: skip
    phrase = effect_phrase(ranked.effect, values)
    if not ranked.group:
        return phrase
    group = " or ".join(plain_name(name) for name in ranked.group)
    return sentence(phrase, f" (or {group}: this log cannot distinguish them)")


def _is_known(fitted: FittedParameter) -> bool:
    """Whether the log determines a value: its interval excludes zero, and its ends are within a factor."""
    if fitted.interval is None:
        return True
    low, high = sorted(abs(end) for end in fitted.interval)
    return fitted.interval[0] * fitted.interval[1] > 0.0 and high <= _MAX_SPREAD * low


def lower_first(text: Text) -> Sentence:
    """A clause inside a sentence: its first letter in lower case."""
    first, *rest = text.parts if isinstance(text, Sentence) else (text,)
    return sentence(first[:1].lower() + first[1:] if isinstance(first, str) else first, *rest)


def _falls(diagnosis: Diagnosis, gap: Gap) -> Sentence | None:
    """By how much the error of the most improved channel falls, None if two digits do not show it.

    Errors of runs that are fed with a measured channel are said to be so, and beside them stands the free run's.
    """
    improved = _most_improved(gap)
    if improved is None:
        return None
    name, errors = improved
    before, after = displayed(errors.tuned, errors.unit, 2), displayed(errors.with_effect, errors.unit, 2)
    if str(sentence(before)) == str(sentence(after)):
        return None
    fed = (
        "" if diagnosis.fed_back is None else f", predicted from the {plain_name(diagnosis.fed_back)} measured so far,"
    )
    falls = sentence(f"{plain_name(name)} error{fed} falls from ", before, " to ", after)
    return falls if diagnosis.fed_back is None else sentence(falls, _free_run_falls(diagnosis, name, errors.unit))


def _free_run_falls(diagnosis: Diagnosis, name: str, unit: str) -> Text:
    """How the error of a channel changes in one free simulation, as a clause that goes on."""
    errors = diagnosis.whole_run_errors
    if errors is None or not {"tuned", "with_effect"} <= set(errors.whole):
        return ""
    before, after = (errors.whole[stage].get(name) for stage in ("tuned", "with_effect"))
    shown = (displayed(before, unit, 2), " to ", displayed(after, unit, 2))
    return sentence(" (in one free simulation of the whole log from ", *shown, ")")


def _calibrated(diagnosis: Diagnosis) -> str:
    """The multiples of the rig file's values that changed most; those that may still be 1 are left out.

    So are those that may not be what the hook load holds beyond the rig file.
    """
    doubtful = () if hook_load_excess(diagnosis) is None else SHARES_OF_EXCESS
    changed = {
        name: fitted.value for name, fitted in diagnosis.tuned_parameters.items()
        if fitted.nominal == 1.0 and fitted.unit == "-" and "." not in name
        and name not in doubtful and abs(fitted.value - 1.0) > _MIN_CHANGE
        and not (fitted.interval is not None and fitted.interval[0] <= 1.0 <= fitted.interval[1])
    }  # fmt: skip
    most = sorted(changed, key=lambda name: -abs(changed[name] - 1.0))[:_MAX_PARAMETERS]
    if not most:
        return ""
    clauses = [f"{plain_name(name)} is {format_number(changed[name])} times the rig file's" for name in most]
    return f": {', '.join(clauses)}"


def _masked(diagnosis: Diagnosis) -> Text:
    """The effects that a far calibration may hide."""
    ranked = [found for name in diagnosis.masked_effects if (found := diagnosis.candidate(name)) is not None]
    if not ranked:
        return ""
    clauses: list[Text] = []
    for effect in ranked:
        clauses += [" or ", lower_first(_phrase(effect))]
    return sentence(
        " It takes values far from the rig file's. They may stay near it if ", *clauses[1:],
        ": this log cannot distinguish the two.",
    )  # fmt: skip


def _residual_gap(diagnosis: Diagnosis, gap: Gap) -> Text:
    if gap.tuned is None or gap.threshold is None:
        return ""
    small = None if diagnosis.small_cause is None else diagnosis.candidate(diagnosis.small_cause)
    if small is not None:
        return sentence(
            f"Calibrated, it leaves {format_number(gap.tuned)} times the noise{while_fed_back(diagnosis)}. ",
            _phrase(small),
            ": that explains the rest, and is too small to act on.",
        )  # fmt: skip
    if gap.tuned <= gap.threshold:
        return sentence("Calibrated, it ", _matches(diagnosis, gap, "tuned"), ".")
    return (
        f"Calibrated, it leaves {format_number(gap.tuned)} times the noise{while_fed_back(diagnosis)}, slightly more "
        f"than counts as no gap ({format_number(gap.threshold)}), and no known effect explains the rest."
    )


def _matches(diagnosis: Diagnosis, gap: Gap, stage: str) -> Text:
    """That no gap is left at a stage; and how far the toolface is off, where that is more than noise."""
    matches = "matches the log within the sensors' noise"
    if _wanders(gap, stage):
        matches += " and what any rig and model are off by"
    matches += while_fed_back(diagnosis)
    errors, noise = gap.rms.get("tool_face"), gap.noise_floor.get("tool_face")
    off = None if errors is None else getattr(errors, stage)
    if errors is None or noise is None or off is None or off <= _NOISE_ALONE * noise.value:
        return matches
    usual = displayed(TOOL_FACE_TOLERANCE, errors.unit, 2)
    off_by = displayed(off, errors.unit, 2)
    compared = "within" if off <= TOOL_FACE_TOLERANCE else "more than"
    steered = (f", {compared} the ", usual, " that drillers steer by")
    return sentence(f"{matches}; the toolface is off by ", off_by, *_free_run_toolface(diagnosis, stage), *steered)


def _free_run_toolface(diagnosis: Diagnosis, stage: str) -> tuple[Text | Quantity, ...]:
    """How far the toolface of one free simulation is off, where E counts runs that are fed back."""
    errors = diagnosis.whole_run_errors
    off = None if errors is None else errors.whole.get(stage, {}).get("tool_face")
    if diagnosis.fed_back is None or off is None:
        return ()
    return (" (", displayed(off, "rad", 2), " in one free simulation of the whole log)")


def _wanders(gap: Gap, stage: str) -> bool:
    """Whether a channel other than the toolface is off by more than its noise, though no gap is left."""
    return any(
        (left := getattr(errors, stage)) is not None and left > _NOISE_ALONE_OF_MANY * gap.noise_floor[name].value
        for name, errors in gap.rms.items() if name != "tool_face" and name in gap.noise_floor
    )  # fmt: skip


def _most_improved(gap: Gap) -> tuple[str, ChannelErrors] | None:
    """The channel whose error falls most, relative to its noise; None if none falls."""
    improvement: dict[str, float] = {}
    for name, errors in gap.rms.items():
        if errors.tuned is not None and errors.with_effect is not None and name in gap.noise_floor:
            noise = gap.noise_floor[name].value
            improvement[name] = (errors.tuned**2 - errors.with_effect**2) / noise**2
    best = max(improvement, key=lambda name: improvement[name], default=None)
    return None if best is None or improvement[best] <= 0.0 else (best, gap.rms[best])


def _worst_channel(gap: Gap, stage: str) -> str | None:
    """The channel with the largest error at a stage, relative to its noise."""
    size = {
        name: value / gap.noise_floor[name].value for name, errors in gap.rms.items()
        if (value := getattr(errors, stage)) is not None and name in gap.noise_floor
    }  # fmt: skip
    return max(size, key=lambda name: size[name], default=None)
