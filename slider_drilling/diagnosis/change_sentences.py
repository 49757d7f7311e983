"""The sentences on what is different between two logs."""

from __future__ import annotations

from slider_drilling.diagnosis.change import Change
from slider_drilling.diagnosis.change_answer import ChangedParameter
from slider_drilling.diagnosis.effect_phrases import SITES
from slider_drilling.diagnosis.result import Diagnosis
from slider_drilling.plain_names import plain_name
from slider_drilling.units import Sentence, Text, displayed, format_number, sentence

_PLAIN = {
    "motor_gain": "the motor's torque per pressure", "pressure_gain": "circulating pressure",
    "bit_stiffness": "the rock's stiffness", "hook_load_offset": "the zero of the hook load",
    "hook_load_gain": "the hook load reading", "sheave_friction": "friction of the sheaves",
    "torsional_damping": "torsional damping", "axial_damping": "axial damping",
    "torque_gain": "the torque reading", "torque_offset": "the zero of the torque reading",
    "torque_delay": "the delay of the torque reading",
}  # fmt: skip

_OF_FILE = ("than the file says", "than its sections say")


def change_summary(diagnosis: Diagnosis, named: Text) -> Sentence:
    """What is different now, in a driller's words.

    Args:
        diagnosis: With a change.
        named: The clause on the named effect.
    """
    change = diagnosis.change
    assert change is not None
    if diagnosis.verdict == "none":
        return sentence("Nothing is different: the simulation fits this log as well as it fitted the baseline.")
    if diagnosis.verdict == "unknown":
        where = "" if diagnosis.site is None else f", most likely at {SITES.get(diagnosis.site, diagnosis.site)}"
        return sentence(
            f"Something is different{_since(change)}{where}; no known change explains it. ", _size(change), "."
        )
    if diagnosis.verdict == "parameters":
        if not change.moved:
            return sentence(
                f"What is different{_since(change)} may be the rig's own numbers; none has changed for certain by "
                "itself. ", _explained(change)
            )
        clauses = [moved_clause(name, moved) for name, moved in change.moved.items()]
        text = sentence(*clauses[:1], *(sentence(", and ", clause) for clause in clauses[1:]))
        return sentence(f"What is different{_since(change)}: ", text, ". ", _explained(change))
    partial = " Something else is different too." if diagnosis.verdict == "effect_and_unknown" else ""
    grows = ", and it grows" if change.growing else ""
    return sentence(
        f"What is different{_since(change)}: ", _than_before(named), grows, ". ", _explained(change), partial
    )


def change_technical_summary(diagnosis: Diagnosis) -> str:
    """The answer with code names and E."""
    change, gap = diagnosis.change, diagnosis.gap
    assert change is not None and gap is not None
    numbers = "calibrated numbers together" if diagnosis.verdict == "parameters" else "nothing that is known"
    names = ", ".join(diagnosis.effects or change.moved) or numbers
    with_it = "" if gap.with_effect is None else f", {gap.with_effect:.2f} with it"
    return (
        f"{diagnosis.verdict}: {names} (E {_number(gap.nominal)} with the baseline's model, {_number(gap.tuned)} "
        f"calibrated again{with_it}; 1 is what the baseline left, {change.baseline_gap:.2f} times the noise)."
    )


def moved_clause(name: str, moved: ChangedParameter) -> Sentence:
    """One calibrated number, before and after."""
    plain = _PLAIN.get(name, plain_name(name))
    if moved.unit == "-" and moved.before:
        share = 100.0 * (moved.after / moved.before - 1.0)
        low, high = (100.0 * (end / moved.before - 1.0) for end in moved.interval)
        return sentence(f"{plain} changed by {format_number(share, 2)} % [{low:+.0f}, {high:+.0f}]")
    return sentence(f"{plain} went from ", displayed(moved.before, moved.unit, 2), " to ",
                    displayed(moved.after, moved.unit, 2))  # fmt: skip


def _since(change: Change) -> str:
    if change.since is None:
        return ""
    interval = ""
    if change.since_interval is not None:
        interval = f" ({change.since_interval[0]:.0f} to {change.since_interval[1]:.0f} s)"
    return f" since {change.since:.0f} s{interval}"


def _size(change: Change) -> str:
    return f"The error is {format_number(change.gap_before, 2)} times that over the baseline"


def _explained(change: Change) -> str:
    if change.explained is None:
        return f"{_size(change)}."
    span = (
        ""
        if change.explained_interval is None
        else " [{:.0f}, {:.0f}]".format(*(100.0 * end for end in change.explained_interval))
    )
    return f"That explains {100.0 * change.explained:.0f} %{span} of the difference."


def _than_before(text: Text) -> Sentence:
    """A clause inside a sentence; what an effect's phrase compares with the rig file is compared with the baseline."""
    first, *rest = text.parts if isinstance(text, Sentence) else (text,)
    parts = [first[:1].lower() + first[1:] if isinstance(first, str) else first, *rest]
    return sentence(*(_with_baseline(part) if isinstance(part, str) else part for part in parts))


def _with_baseline(text: str) -> str:
    for of_file in _OF_FILE:
        text = text.replace(of_file, "than before")
    return text


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"
