"""One turn of the attribution: screen, fit the survivors, accept the best that passes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from slider_drilling.gap.contender import Base, Contender, End, fit_candidate, indistinguishable, judge, make_base
from slider_drilling.gap.findings import Findings
from slider_drilling.gap.fit import Fit
from slider_drilling.gap.model import Effect
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.residuals import Problem
from slider_drilling.gap.screen import screen
from slider_drilling.gap.survivors import Survivor, survivors
from slider_drilling.gap.tune import CONTENT, GROWTH, begun_again, fit_growing, foreseen, roamed, settle, sharpen

# Of least squares where a search has been.
_ITERATIONS = 6
# A tuning is better when its cost falls by more than fits from different starts scatter.
_BETTER = 0.98
_MUCH_BETTER = 0.8
# Once one candidate explains the log down to its noise, only so many are fitted in all: it and its rivals.
ENOUGH = 3
# Times that an end is followed further.
_FOLLOWED = 3
# So many of the best are taken to the end before one is preferred to another.
POLISHED = 2
# One that leaves so many times what the polished best leaves beyond noise is not taken further.
_FAR_BEHIND = 2.0


@dataclass
class _Turn:
    """What one turn works on. number: 0 for the first effect; candidates: by how many acceptance is corrected."""

    findings: Findings
    base: Base
    number: int
    candidates: int
    contenders: list[Contender] = field(default_factory=list)

    def compare(self, survivor: Survivor, scatter: int) -> bool:
        """Fit one candidate and judge it; whether its fit has turned up a much better tuning without it."""
        candidate = survivor.candidate
        self.base.problem.anchor(self.base.fit.values)
        ends, agree = fit_candidate(self.base, candidate, scatter=scatter, thorough=survivor.thorough)
        own, best = ends[0]
        much = self.retune(best, ())
        own.anchor(best.values)
        judged = judge(own, self.findings.bootstrap, self.base, candidate.effect, best, agree, self.candidates)
        self.contenders.append(replace(judged, others=tuple(ends[1:])))
        return much

    def retune(self, other: Fit, shaken: Sequence[float]) -> bool:
        """Put a better fit without the candidate in the base's place; whether it was much better.

        Searched for from where the candidate's fit left the rest: a candidate must not win because its search found a
        better tuning that needs no effect at all. shaken: so that this one is searched for as the candidate was.
        """
        base, findings = self.base, self.findings
        start = {name: other.values[name] for name in base.fit.values}
        again = fit_growing(
            base.problem, base.fit.parameters, start, iterations=_ITERATIONS, shares=(1.0,), shaken=shaken
        )
        if again.cost >= _BETTER * base.fit.cost:
            return False
        own, polished = settle(findings.problem, again)
        self.base = findings.current = make_base(own, findings.bootstrap, polished)
        if self.number == 0:
            findings.tuned = findings.current
        self.contenders[:] = [self.again(contender) for contender in self.contenders]
        return again.cost < _MUCH_BETTER * base.fit.cost

    def again(self, contender: Contender) -> Contender:
        """A contender judged against the base as it is now."""
        own = contender.problem
        own.anchor(contender.fit.values)
        judged = judge(
            own, self.findings.bootstrap, self.base, contender.effect, contender.fit, contender.starts_agree,
            self.candidates,
        )  # fmt: skip
        return replace(judged, others=contender.others)

    def winner(self) -> Contender | None:
        """The best that passes, once the best few are fitted to the end."""
        self.contenders.sort(key=lambda contender: contender.score.surprise)
        for index, contender in enumerate(self.contenders[:POLISHED]):
            leader = self.contenders[0]
            if index > 0 and contender.score.surprise - 1.0 > _FAR_BEHIND * (leader.score.surprise - 1.0):
                break
            # What fits no better than the model without it is lost in its search, and polishing finds no way back.
            if contender.fit.cost < self.base.fit.cost:
                self.contenders[index] = self.polished(contender, contender.others if contender is leader else ())
        self.contenders.sort(key=lambda contender: contender.score.surprise)
        return self.best()

    def polished(self, contender: Contender, others: Sequence[End]) -> Contender:
        """Fitted to the end, from where it stands and, on rough ground, from what a wide search around that finds.

        others: further ends of its search to begin from.
        """
        own, fine = self.begun(contender.problem, contender.fit)
        found = roamed(own, fine, _ITERATIONS)
        fits = [(own, fine)] if found is fine else [(own, fine), (own, found)]
        fits += [self.begun(*end) for end in others]
        ends = [self.followed(replace(contender, problem=problem), start) for problem, start in fits]
        least = min(end.score.surprise for end in ends)
        # Of ends that are as good, a bit that points where the log says is worth more than its luck elsewhere.
        return min((e for e in ends if e.score.surprise <= CONTENT * least), key=lambda end: end.score.gap_squared)

    def begun(self, problem: Problem, found: Fit) -> End:
        """A fit in its own floors, and begun again."""
        own, fine = settle(problem, found)
        return own, begun_again(own, fine)

    def followed(self, contender: Contender, found: Fit) -> Contender:
        """Settled for as long as that leaves clearly less surprise."""
        best = self.settled(contender, found)
        for _ in range(_FOLLOWED):
            further = self.settled(best, best.fit)
            if further.score.surprise > _BETTER * best.score.surprise:
                break
            best = further
        return best

    def settled(self, contender: Contender, found: Fit) -> Contender:
        """A contender at another fit in its own floors, missed steps priced higher where held-out stretches allow."""
        own, fine = settle(contender.problem, found)
        plain = self.again(replace(contender, problem=own, fit=fine))
        own, fine = foreseen(own, sharpen(own, fine))
        sharper = self.again(replace(contender, problem=own, fit=fine))
        return sharper if sharper.score.surprise <= CONTENT * plain.score.surprise else plain

    def best(self) -> Contender | None:
        """The first that passes every test."""
        return next((contender for contender in self.contenders if contender.accepted), None)

    def explained(self) -> bool:
        """Whether one that passes leaves noise alone, and enough rivals have been seen."""
        done = any(c.accepted and self.findings.at_floor(c.score) for c in self.contenders)
        return done and len(self.contenders) >= ENOUGH


def add_one(
    findings: Findings, catalogue: Sequence[Effect], number: int, scatter: int, progress: Progress, restarts: int = 1
) -> bool:
    """Screen everything not yet accepted, fit the survivors, accept the best that passes. False when none does.

    Where a candidate's fit turns up a much better tuning, the screening was done at the wrong place and starts again.
    """
    base = findings.current
    assert base is not None
    names = {contender.effect.name for contender in findings.accepted}
    begin = 0.18 + 0.27 * number
    progress("screening", begin)
    screened = screen(base.problem, base.fit, [effect for effect in catalogue if effect.name not in names])
    turn = _Turn(findings, base, number, len(catalogue))
    findings.screened.append(screened)
    findings.rounds.append(turn.contenders)
    chosen = survivors(base, screened, further=number > 0)
    for index, survivor in enumerate(chosen):
        progress(f"fitting {survivor.candidate.effect.name}", begin + 0.03 + 0.24 * index / len(chosen))
        elsewhere = turn.compare(survivor, scatter)
        if findings.at_floor(turn.base.score):
            return False
        if elsewhere and restarts > 0:
            findings.screened.pop()
            findings.rounds.pop()
            return add_one(findings, catalogue, number, scatter, progress, restarts - 1)
        if turn.explained():
            break
    return _accept(turn, turn.winner())


def _accept(turn: _Turn, winner: Contender | None) -> bool:
    """Accept a winner, unless a tuning that is searched for as hard does without it."""
    if winner is not None:
        turn.retune(winner.fit, GROWTH[2:])
        winner = turn.best()
    findings = turn.findings
    if winner is None or findings.at_floor(turn.base.score):
        return False
    findings.groups[winner.effect.name] = _group(turn.base, winner, turn.contenders)
    findings.accepted.append(winner)
    findings.current = Base(winner.problem, winner.fit, winner.score)
    winner.problem.anchor(winner.fit.values)
    return True


def _group(base: Base, winner: Contender, contenders: Sequence[Contender]) -> dict[str, str]:
    group = {}
    for other in contenders:
        if other is winner or not other.physical or other.gain_bound <= 0.0:
            continue
        why = indistinguishable(base, winner, other)
        if why is not None:
            group[other.effect.name] = why
    return group
