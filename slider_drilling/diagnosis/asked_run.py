"""The run that a diagnosis asks for next, in words and as a programme."""

from __future__ import annotations

from slider_drilling.diagnosis.drilling_programmes import DrillingManoeuvre
from slider_drilling.diagnosis.programme_words import in_one_line, programme_in_words
from slider_drilling.gap.results.next_manoeuvre import RecommendedManoeuvre
from slider_drilling.pages import BulletList
from slider_drilling.plain_names import plain_name
from slider_drilling.programmes import Programme
from slider_drilling.rig import Rig
from slider_drilling.units import Sentence, Text, sentence


def asked_programme(asked: RecommendedManoeuvre) -> Programme:
    """The programme of the run."""
    manoeuvre = asked.manoeuvre
    assert isinstance(manoeuvre, DrillingManoeuvre)
    return manoeuvre.programme


def ask_next(asked: RecommendedManoeuvre, rig: Rig) -> Sentence:
    """The run in one line."""
    return sentence(f"ask next ({asked.reason}): ", in_one_line(programme_in_words(asked_programme(asked), rig)))


def asked_items(asked: RecommendedManoeuvre, rig: Rig) -> list[Text | BulletList]:
    """The run for a page: why, what to do, and what it would show."""
    steps = programme_in_words(asked_programme(asked), rig)
    items: list[Text | BulletList] = [
        f"This is open: {asked.reason}. Ask the rig for this next ({steps[-1].begin + steps[-1].duration:.0f} s), "
        "and diagnose both logs together:",
        BulletList(tuple(sentence(step.text, f" ({step.duration:.0f} s)") for step in steps)),
    ]
    if asked.separates:
        first, second = (plain_name(name) for name in asked.separates)
        items.append(
            f"If {first} or {second} is true, the log likelihood ratio between the two is expected to be "
            f"{asked.log_likelihood_ratio:.0f} after it; 7 decides 1000 to 1."
        )
    return items
