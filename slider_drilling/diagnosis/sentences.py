"""The outcome in sentences: first for a driller, then with code names for who goes on working with it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from slider_drilling.diagnosis.effect_phrases import SITES, display_unit, effect_phrase, format_quantity
from slider_drilling.diagnosis.result import (
    ChannelErrors,
    ClosedShare,
    FittedParameter,
    Gap,
    Interval,
    Outcome,
    RankedEffect,
    ResidualShape,
)
from slider_drilling.gap.results.sentence import structured_residual_clause
from slider_drilling.units import format_number

_CLOSES, _UNSEEN, _LEFT_BY = "closes [95 %]", "of unseen runs", "of what is left by"  # heads of a ranking's shares
_WHOLE = 0.995  # of the gap; a model in which luck leaves less than noise does closes more than all of it
_MOST_TUNED = 3  # parameters named in a sentence
_TUNED_BY = 0.05  # of a multiple of the rig file's value: less is not worth a word
_KNOWN = 3.0  # a value's interval may reach from this many times one end to the other
_PLACED = ("cuttings_bed",)  # told by where it is, however roughly
_PLAIN = {
    "surface_torque": "surface torque",
    "hook_load": "hook load",
    "standpipe_pressure": "standpipe pressure",
    "tool_face": "toolface",
}


def plain_name(name: str) -> str:
    """A channel's or parameter's name as it is spoken."""
    return _PLAIN.get(name, name.replace("_", " "))


def driller(outcome: Outcome) -> str:
    """The answer in the words of the rig floor, one or two sentences."""
    gap = outcome.gap
    if outcome.verdict == "inconclusive" or gap is None:
        why = "; ".join(outcome.remarks) or "the fits did not converge"
        return f"This log says nothing about the simulation: {why}."
    if outcome.verdict == "none":
        return "The simulation with this rig file matches the log as closely as the sensors' noise lets anybody tell."
    if outcome.verdict == "parameters":
        return f"The simulation is only mis-tuned{_tuned(outcome)}{_as_near(gap)}.{_instead(outcome)}"
    if outcome.verdict == "unknown":
        return _unknown(outcome, gap)
    return _found(outcome, gap)


def _found(outcome: Outcome, gap: Gap) -> str:
    found = [one for name in outcome.effects if (one := outcome.candidate(name)) is not None]
    clauses = [_named(one) for one in found]
    text = ", and ".join([*clauses[:1], *(_lower(clause) for clause in clauses[1:])])
    if outcome.verdict == "effect_and_unknown":
        text = f"It acts as if {_lower(text)}"
    falls = _falls(gap)
    text += f"; with that in, {falls}{' and ' if falls else ''}{closed_in_words(gap.closed, gap.closed_interval)}."
    return text + (f" {_beside(outcome, gap)}" if outcome.verdict == "effect_and_unknown" else "")


def _beside(outcome: Outcome, gap: Gap) -> str:
    """What there is beside the effects that are named: what explains as much, or what they leave."""
    shape = outcome.shape
    if shape is not None and shape.of == "alternative":
        return f"Something else would explain as much: {shape.words}."
    rest = _largest(gap, "with_effect")
    where = f", most of it in {plain_name(rest)}" if rest else ""
    like = f"; it looks like this: {shape.words}" if shape is not None else ""
    return f"Something that no known effect explains remains{where}{like}."


def _falls(gap: Gap) -> str:
    """By how much the error of the channel that is helped most falls, "" where two digits do not show it."""
    channel = _most_improved(gap)
    if channel is None:
        return ""
    name, errors = channel
    assert errors.tuned is not None and errors.with_effect is not None
    before, after = format_quantity(errors.tuned, errors.unit, 2), format_quantity(errors.with_effect, errors.unit, 2)
    return (
        ""
        if before == after
        else f"{plain_name(name)} error falls from {_amount(errors.tuned, errors.unit)} to {after}"
    )


def _lower(clause: str) -> str:
    return clause[:1].lower() + clause[1:]


def _named(candidate: RankedEffect) -> str:
    amplitude = next(iter(candidate.parameters), "")
    values = {
        name.rpartition(".")[2]: fitted.value for name, fitted in candidate.parameters.items()
        if name == amplitude or candidate.effect in _PLACED or _is_known(fitted)
    }  # fmt: skip
    text = effect_phrase(candidate.effect, values)
    if candidate.group:
        rivals = " or ".join(plain_name(name) for name in candidate.group)
        text += f" (or {rivals}: this log cannot tell them apart)"
    return text


def _is_known(fitted: FittedParameter) -> bool:
    """Whether a log tells a value: what may as well be several times as much, or nothing, is not worth a word."""
    if fitted.interval is None:
        return True
    low, high = sorted(abs(end) for end in fitted.interval)
    return fitted.interval[0] * fitted.interval[1] > 0.0 and high <= _KNOWN * low


def closed_in_words(closed: float | None, interval: Interval | None) -> str:
    """The share of the gap that is closed, where it is one."""
    if closed is None:
        return "the gap shrinks, by how much of it cannot be said"
    if closed >= _WHOLE:
        return "the whole gap is closed"
    span = f" [{100.0 * interval[0]:.0f}, {100.0 * interval[1]:.0f}]" if interval is not None else ""
    return f"{100.0 * closed:.0f} %{span} of the gap is closed"


def format_share(found: RankedEffect | ClosedShare | None) -> str:
    """The share of the gap that is closed with its interval, "-" where that says nothing."""
    if found is None or found.closed is None:
        return "-"
    span = "" if found.interval is None else f" [{found.interval[0]:.2f}, {found.interval[1]:.2f}]"
    return f"{found.closed:.2f}{span}"


def share_headers(ranking: Sequence[RankedEffect]) -> tuple[str, ...]:
    """Heads of the shares of a ranking: also of what a fit to other runs closes where that was asked, and of what gap
    these are shares where one was found before another.
    """
    heads = [_CLOSES]
    if any(one.other_runs is not None for one in ranking):
        heads.append(_UNSEEN)
    if any(one.beside for one in ranking):
        heads.append(_LEFT_BY)
    return tuple(heads)


def share_cells(candidate: RankedEffect, heads: Sequence[str]) -> tuple[str, ...]:
    """The shares below those heads."""
    cells = {
        _CLOSES: format_share(candidate),
        _UNSEEN: format_share(candidate.other_runs),
        _LEFT_BY: _left_by(candidate),
    }
    return tuple(cells[head] for head in heads)


def _left_by(candidate: RankedEffect) -> str:
    """What left the gap of which a candidate closes a share: re-tuning, or what had been found before it."""
    return ", ".join(plain_name(name) for name in candidate.beside) or "re-tuning"


def prediction_horizon(outcome: Outcome) -> list[str]:
    """What the answer does not reach: how far ahead the model foretells."""
    lost = [name for name in outcome.horizon or {} if name not in outcome.foretold]
    found = []
    if lost:
        assert outcome.horizon is not None
        ahead = ", ".join(f"{plain_name(name)} {outcome.horizon[name]:.0f} s" for name in lost)
        found.append(
            f"The model foretells so far ahead before its error is as large as the channel's own spread: {ahead}."
        )
    if outcome.foretold:
        channels = ", ".join(plain_name(name) for name in outcome.foretold)
        found.append(f"To the end of the log the model's error stays below the channel's own spread: {channels}.")
    return found


def fitted_and_others(outcome: Outcome) -> tuple[list[RankedEffect], str]:
    """The candidates of the ranking that were fitted, and why the others were not, "" where there are none."""
    fitted = [one for one in outcome.ranking if one.parameters]
    others: dict[str, list[str]] = {}
    for one in outcome.ranking:
        if not one.parameters:
            others.setdefault("; ".join(one.why_not), []).append(one.effect)
    return fitted, " ".join(f"{', '.join(names)}: {why}." for why, names in others.items())


def candidate_status(candidate: RankedEffect) -> str:
    """What became of a candidate: in the answer, passed but not in it, or why not."""
    if candidate.in_answer:
        return _in_the_answer(candidate)
    why = "; ".join(candidate.why_not)
    return f"passed, not in the answer: {why}" if candidate.passed and why else "passed" if candidate.passed else why


def candidate_status_by_number(candidate: RankedEffect, reasons: Sequence[str]) -> str:
    """The same where there is little room, with the numbers of the reasons in their list."""
    if candidate.in_answer:
        return _in_the_answer(candidate)
    why = " ".join(f"({reasons.index(one) + 1})" for one in candidate.why_not)
    return f"{'passed' if candidate.passed else 'not'} {why}".rstrip()


def _in_the_answer(candidate: RankedEffect) -> str:
    others = " and ".join(plain_name(name) for name in candidate.together)
    return f"in the answer, together with {others}" if others else "in the answer"


def _unknown(outcome: Outcome, gap: Gap) -> str:
    channel = _largest(gap, "tuned")
    text = "None of the known effects explains what re-tuning leaves"
    if channel is not None:
        errors = gap.rms[channel]
        assert errors.tuned is not None
        text += f" ({format_quantity(errors.tuned, errors.unit, 2)} of {plain_name(channel)})"
    if outcome.site is not None:
        text += f"; most of it points at {SITES.get(outcome.site, outcome.site)}"
    if outcome.shape is not None:
        text += f", where it looks like this: {outcome.shape.words}"
    return f"{text}."


def _tuned(outcome: Outcome) -> str:
    """The multiples of the rig file's values that moved most, in words; what may as well be the file's has none."""
    moved = {
        name: fitted.value for name, fitted in outcome.tuned_parameters.items()
        if fitted.nominal == 1.0 and fitted.unit == "-" and "." not in name and abs(fitted.value - 1.0) > _TUNED_BY
        and not (fitted.interval is not None and fitted.interval[0] <= 1.0 <= fitted.interval[1])
    }  # fmt: skip
    most = sorted(moved, key=lambda name: -abs(moved[name] - 1.0))[:_MOST_TUNED]
    if not most:
        return ""
    return ": " + ", ".join(f"{plain_name(name)} is {format_number(moved[name])} times the file's" for name in most)


def _instead(outcome: Outcome) -> str:
    """The laws that would do what re-tuning does, where that went far."""
    found = [one for name in outcome.instead if (one := outcome.candidate(name)) is not None]
    if not found:
        return ""
    laws = " or ".join(_lower(_named(one)) for one in found)
    return f" That takes values far from the file's; they may stay near it if {laws}: this log cannot tell."


def _as_near(gap: Gap) -> str:
    if gap.tuned is None or gap.threshold is None:
        return ""
    if gap.tuned <= gap.threshold:
        return "; re-tuned it matches the log as closely as noise lets anybody tell"
    return (
        f"; re-tuned it leaves {format_number(gap.tuned)} times the noise, little more than noise can "
        f"({format_number(gap.threshold)}), and no known effect takes that away"
    )


def _most_improved(gap: Gap) -> tuple[str, ChannelErrors] | None:
    """The channel whose error falls most in noise floors, None where none falls."""
    fall: dict[str, float] = {}
    for name, errors in gap.rms.items():
        if errors.tuned is not None and errors.with_effect is not None and name in gap.noise_floor:
            floor = gap.noise_floor[name].value
            fall[name] = (errors.tuned**2 - errors.with_effect**2) / floor**2
    best = max(fall, key=lambda name: fall[name], default=None)
    return None if best is None or fall[best] <= 0.0 else (best, gap.rms[best])


def _largest(gap: Gap, stage: str) -> str | None:
    """The channel with the largest error at a stage, in noise floors."""
    size = {
        name: value / gap.noise_floor[name].value for name, errors in gap.rms.items()
        if (value := getattr(errors, stage)) is not None and name in gap.noise_floor
    }  # fmt: skip
    return max(size, key=lambda name: size[name], default=None)


def _amount(value: float, unit: str) -> str:
    """The number alone: its unit follows with the next one."""
    return format_quantity(value, unit, 2).removesuffix(f" {display_unit(unit)[0]}")


def sentence(outcome: Outcome) -> str:
    """The verdict with code names and E."""
    gap = outcome.gap
    if outcome.verdict == "inconclusive" or gap is None:
        return f"No conclusion: {'; '.join(outcome.remarks) or 'the fits did not converge'}."
    stages = [(gap.nominal, "as given"), (gap.tuned, "re-tuned"), (gap.with_effect, "with it")]
    figures = "E = " + ", ".join(f"{value:.2f} {name}" for value, name in stages if value is not None)
    if gap.threshold is not None:
        figures += f"; noise alone stays below {gap.threshold:.2f}"
        left = next((value for value in (gap.with_effect, gap.tuned) if value is not None), math.inf)
        channels = [plain_name(name) for name in gap.stand_out]
        figures += structured_residual_clause(outcome.verdict, left, gap.threshold, channels)
    if outcome.verdict == "none":
        return f"none: the rig file as given leaves what noise would ({figures})."
    if outcome.verdict == "parameters":
        stands_for = f"; they may stand for {' or '.join(outcome.instead)}" if outcome.instead else ""
        return f"parameters: re-fitting them leaves no effect of the catalogue to find ({figures}){stands_for}."
    if outcome.verdict == "unknown":
        return f"unknown, at {outcome.site or 'no site'}: no effect of the catalogue is accepted ({figures})."
    names = " and ".join(_with_rivals(outcome.candidate(name), name) for name in outcome.effects)
    closes = (
        ""
        if gap.closed is None
        else f", closes {gap.closed:.2f}"
        + ("" if gap.closed_interval is None else " [{:.2f}, {:.2f}]".format(*gap.closed_interval))
    )
    end = f"; {_rest(outcome.shape)}" if outcome.verdict == "effect_and_unknown" else ""
    return f"{outcome.verdict}: {names}{closes} ({figures}){end}."


def _rest(shape: ResidualShape | None) -> str:
    if shape is not None and shape.of == "alternative":
        return f"{shape.words}: explains as much"
    return "something structured remains" + ("" if shape is None else f": {shape.words}")


def _with_rivals(candidate: RankedEffect | None, name: str) -> str:
    rivals: Sequence[str] = () if candidate is None else candidate.group
    return name + (f" (or {', '.join(rivals)}: not told apart)" if rivals else "")
