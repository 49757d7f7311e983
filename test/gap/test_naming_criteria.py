"""Every rule that an effect must pass before it is named, on both sides of its threshold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2
from toy import EFFECTS, TIME, fit_toy, toy

from slider_drilling.gap import criteria_table
from slider_drilling.gap.evidence.block_bootstrap import make_bootstrap
from slider_drilling.gap.evidence.compare import NAMING_LEVEL, gap_closed, predicts_better
from slider_drilling.gap.evidence.free_form_fit import FreeFormFit
from slider_drilling.gap.evidence.score import HeldOutScore, make_folds
from slider_drilling.gap.problem.model_error import INDEPENDENT_ERRORS
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.results.intervals import ONE_SIDED_95, SPREAD_OF_ANSWERS, parameter_intervals
from slider_drilling.gap.search.multi_start import NUISANCE_LIMIT
from slider_drilling.gap.selection import evidence_tests, naming_criteria
from slider_drilling.gap.selection.evidence_tests import MIN_GAP, MIN_GAP_CLOSED, MIN_SHARE_OF_CAUSE, Evidence
from slider_drilling.gap.selection.naming_criteria import CRITERIA, Kind, Stage, criterion, failures

PROBLEM = build_problem(toy({}, 1), [{"force": 1.0}])
BOOTSTRAP = make_bootstrap(make_folds(PROBLEM), 0)
NOISE = np.random.default_rng(3).normal(size=TIME.size)
SINE = EFFECTS[0]
CANDIDATES = 16
INSIDE, OUTSIDE = 1.01, 0.99  # times a threshold


def scored(squares: object = 3.0, density: object = 0.0) -> HeldOutScore:
    squares, density = (np.broadcast_to(np.asarray(each, dtype=float), TIME.shape) for each in (squares, density))
    gap = float(np.sqrt(np.mean(squares)))
    return HeldOutScore(density, np.sqrt(squares), squares, gap, {"force": gap}, 0)


def model(score: HeldOutScore, cost: float = 0.0, parameters: int = 2, effects: tuple = (), **more: object):
    values = {"sine": 1.0}
    simulated = more.pop("simulated", np.zeros(TIME.size))
    found = SimpleNamespace(
        cost=cost, parameters=("free",) * parameters, values=values, residual=cost, simulated=simulated
    )  # fmt: skip
    # The log alone costs as much as the fit with its priors: the stub has none.
    pieces = more.pop("pieces", PROBLEM.pieces)
    problem = SimpleNamespace(cost=lambda residual: (residual, {}), model=SimpleNamespace(nuisance=()), pieces=pieces)
    names = tuple(effect.name for effect in effects)
    return SimpleNamespace(effects=effects, names=names, score=score, fit=found, problem=problem, **more)


def evidence(without: object, fitted: object, candidates: int = 1, **state: object) -> Evidence:
    adequate = bool(state.pop("adequate", False))
    adequacy = SimpleNamespace(adequate=adequate, within_thresholds=adequate)
    whole = SimpleNamespace(
        bootstrap=BOOTSTRAP, adequacy=adequacy, calibrated=without, calibrated_adequacy=adequacy
    )  # fmt: skip
    forms = state.pop("free_forms", ())
    return Evidence(whole, without, fitted, [SINE] * candidates, free_forms=forms)


def form(score: HeldOutScore, site: str = "string", like: tuple[str, ...] = ()) -> FreeFormFit:
    x = np.zeros(1)
    return FreeFormFit(site, "a curve", like, x, "-", x, "-", score)


def least_certain_gain(forms: int = 1) -> float:
    """Gain per sample whose lower bound is zero, beside `NOISE` (resamples are as long as the log)."""
    return -float(np.quantile(BOOTSTRAP.resampled_sum(NOISE), NAMING_LEVEL / forms)) / TIME.size


def least_certain_reduction() -> float:
    """Reduction of E^2 whose lower bound is zero, beside `NOISE`, of a gap of E^2 = 3."""
    (low, _) = gap_closed(BOOTSTRAP, scored(3.0), scored(3.0 - 0.1 * NOISE))[1]
    return -2.0 * low


def predicts(times: float) -> Evidence:
    gain = times * least_certain_gain() + NOISE
    return evidence(model(scored(3.0, 2.0)), model(scored(3.0, 2.0 - gain), effects=(SINE,)))


def is_evident(times: float) -> Evidence:
    gain = times * 2.0 * np.log(CANDIDATES / NAMING_LEVEL)
    without = model(scored(1.0, 2.0), 1000.0)
    fitted = model(scored(1.0, 2.0 - gain / TIME.size), 1000.0 - gain - 2.0, 3, (SINE,))
    return evidence(without, fitted, CANDIDATES, adequate=True)


def is_likelier(times: float) -> Evidence:
    gain = times * chi2.ppf(1.0 - NAMING_LEVEL / CANDIDATES, 1)
    fitted = model(scored(), 1000.0 - gain, 3, (SINE,))
    return evidence(model(scored(), 1000.0), fitted, CANDIDATES)


def shrinks(times: float) -> Evidence:
    after = 3.0 - times * least_certain_reduction() - 0.1 * NOISE
    return evidence(model(scored(3.0)), model(scored(after), effects=(SINE,)))


def has_a_gap(times: float) -> Evidence:
    return evidence(model(scored(1.0 + times * smallest_gap())), model(scored(1.0), effects=(SINE,)))


def smallest_gap() -> float:
    """E^2 - 1 that white noise of so few samples may leave, where that is more than `MIN_GAP`."""
    return max(MIN_GAP, 3.0 * np.sqrt(2.0 / TIME.size))


def exceeds_model_error(times: float) -> Evidence:
    """A model that is wrong by a tenth of what the channel moves: by one noise unit."""
    (piece,) = PROBLEM.pieces
    pieces = (replace(piece, channel=replace(piece.channel, model_error=0.1)),)
    moved = 10.0 * np.where(np.arange(TIME.size) % 2, 1.0, -1.0)
    held = 1.0
    without = model(scored(3.0), pieces=pieces, simulated=moved)
    return evidence(without, model(scored(3.0 - times * held), effects=(SINE,)))


def is_material(times: float) -> Evidence:
    sine = replace(SINE, material={"sine": 2.0})
    fitted = model(scored(), effects=(sine,))
    fitted.fit.values["sine"] = 2.0 * times
    return evidence(model(scored()), fitted)


def differs(times: float, material: float = 0.0, adequate: bool = False) -> Evidence:
    """A sine whose amplitude is half of its interval, and so many times what is material, more than none."""
    problem, found = fit_toy(toy({"sine": 4.0}, 3), ["sine"])
    low, high = parameter_intervals(problem, found, ONE_SIDED_95)["sine"]
    half = 0.5 * (high - low)
    amplitude = half + times * material if material else times * SPREAD_OF_ANSWERS * half
    found = replace(found, values=found.values | {"sine": amplitude})
    sine = replace(SINE, material={"sine": material} if material else {})
    fitted = model(scored(), effects=(sine,))
    fitted.problem, fitted.fit = problem, found
    without = model(scored())
    # As good a fit, so that the interval alone decides.
    without.fit = found
    return evidence(without, fitted, adequate=adequate)


def is_certainly_material(times: float) -> Evidence:
    return differs(times, material=2.0, adequate=True)


def test_where_there_is_a_gap_a_size_need_not_be_certainly_material():
    found = differs(OUTSIDE, material=2.0, adequate=False)
    assert criterion("certainly material").passes(found) and criterion("more than none").passes(found)


@pytest.mark.parametrize("times", [OUTSIDE, INSIDE])
def test_a_size_that_may_be_none_stays_where_a_refit_is_clearly_worse(times):
    found = differs(OUTSIDE)
    left = np.exp(0.5 * times * chi2.ppf(0.9, 1) / INDEPENDENT_ERRORS)
    fit = found.fitted.fit
    scale = 2.0 / float(np.sqrt(np.mean(fit.residual**2)))
    found.fitted.fit = replace(fit, residual=scale * fit.residual)
    found.without.fit = replace(fit, residual=left * scale * fit.residual, parameters=fit.parameters[:-1])
    assert criterion("more than none").passes(found) == (times == INSIDE)


def closes(times: float) -> Evidence:
    after = 3.0 - times * MIN_GAP_CLOSED * 2.0
    return evidence(model(scored(3.0)), model(scored(after), effects=(SINE,)))


def closes_most(times: float) -> Evidence:
    after = 3.0 - times * MIN_SHARE_OF_CAUSE * 2.0
    return evidence(model(scored(3.0)), model(scored(after), effects=(SINE,)))


def makes_no_channel_worse(times: float) -> Evidence:
    after = 3.0 + 3.0 * np.sqrt(2.0 / TIME.size) / times
    return evidence(model(scored(3.0)), model(scored(after), effects=(SINE,)))


def is_physical(times: float) -> Evidence:
    sine = replace(SINE, physical=(1.0, 9.0), nonphysical="a cosine")
    fitted = model(scored(), effects=(sine,))
    fitted.fit.values["sine"] = times
    return evidence(model(scored()), fitted)


def closes_of_calibrated(times: float) -> Evidence:
    calibrated = model(scored(3.0))
    without = model(scored(1.5))
    fitted = model(scored(1.5 - times * MIN_GAP_CLOSED * 2.0), effects=(SINE,))
    found = evidence(without, fitted, adequate=True)
    return replace(found, state=SimpleNamespace(**{**vars(found.state), "calibrated": calibrated}))


def in_other_runs(found: Callable[[float], Evidence]) -> Callable[[float], Evidence]:
    def made(times: float) -> Evidence:
        there = found(times)
        before, after = (
            SimpleNamespace(**{**vars(each), "cross_run_score": each.score, "score": scored(1.0)})
            for each in (there.without, there.fitted)
        )
        return replace(there, without=before, fitted=after)

    return made


def outperforms_forms(times: float) -> Evidence:
    density = 2.0 - times * least_certain_gain(2) - NOISE
    forms = [form(scored(3.0, 2.0)), form(scored(3.0, 3.0))]
    return evidence(model(scored()), model(scored(3.0, density)), free_forms=forms)


def calibrates_to(times: float) -> Evidence:
    fitted = model(scored())
    parameter = SimpleNamespace(name="level", nominal=1.0, spread=2.0, per_run=False)
    fitted.problem.model.nuisance = (parameter,)
    fitted.fit.values["level"] = 1.0 + 2.0 * NUISANCE_LIMIT / times
    return evidence(model(scored()), fitted)


def is_needed(times: float) -> Evidence:
    gain = times * chi2.ppf(1.0 - NAMING_LEVEL, 1)
    return evidence(model(scored(3.0), 1000.0), model(scored(2.0), 1000.0 - gain, 3))


def ends_the_gap(times: float) -> Evidence:
    return evidence(model(scored(3.0)), model(scored(1.0), effects=EFFECTS[:2]), adequate=times > 1.0)


def beats_no_named_effect(times: float) -> Evidence:
    alternative = form(scored(3.0, 2.0 - least_certain_gain() / times - NOISE), site="contact")
    return evidence(model(scored()), model(scored(3.0, 2.0), effects=(SINE,)), free_forms=[alternative])


def is_no_likelier_elsewhere(times: float) -> Evidence:
    gain = chi2.ppf(1.0 - NAMING_LEVEL, 1) / times
    alternative = form(scored(2.9, np.where(TIME < 6.0, 2.0 - gain / np.sum(TIME < 6.0), 2.0)))
    return evidence(model(scored()), model(scored(3.0, 2.0), effects=(SINE,)), free_forms=[alternative])


# By name of a criterion: evidence at so many times its threshold.
AT_THRESHOLD: dict[str, Callable[[float], Evidence]] = {
    "predicts held-out data": predicts,
    "strong evidence where noise is enough": is_evident,
    "likelihood ratio": is_likelier,
    "gap reduction significant": shrinks,
    "a gap to explain": has_a_gap,
    "beyond the model's error": exceeds_model_error,
    "material": is_material,
    "gap reduction relevant": closes,
    "closes most of the gap": closes_most,
    "most channels no worse": makes_no_channel_worse,
    "sign and size physical": is_physical,
    "relevant after calibration": closes_of_calibrated,
    "gap reduction significant in other runs": in_other_runs(shrinks),
    "gap reduction relevant in other runs": in_other_runs(closes),
    "no free form of a known effect": outperforms_forms,
    "plausible calibration": calibrates_to,
    "supported without priors": is_likelier,
    "still needed": is_needed,
    "pair ends the gap": ends_the_gap,
    "more than none": differs,
    "certainly material": is_certainly_material,
    "no free form predicts better": beats_no_named_effect,
    "no free form at another site is likelier": is_no_likelier_elsewhere,
}


def test_every_criterion_has_a_case():
    assert list(AT_THRESHOLD) == [each.name for each in CRITERIA]


@pytest.mark.parametrize("name", AT_THRESHOLD)
def test_criterion_passes_above_its_threshold_only(name):
    assert criterion(name).passes(AT_THRESHOLD[name](INSIDE))
    assert not criterion(name).passes(AT_THRESHOLD[name](OUTSIDE))


@pytest.mark.parametrize("name", AT_THRESHOLD)
def test_failed_criterion_gives_its_message(name, monkeypatch):
    rejected = SimpleNamespace(complete=False, within_thresholds=False, adequate=False)
    monkeypatch.setattr(evidence_tests, "check_adequacy", lambda *given: rejected)
    # The stubs have no Jacobian.
    monkeypatch.setattr(evidence_tests, "parameter_intervals", lambda *given: {})
    monkeypatch.setattr(evidence_tests, "user_parameters", lambda *given: {})
    rule, found = criterion(name), AT_THRESHOLD[name](OUTSIDE)
    for stage in rule.stages:
        assert set(rule.messages(found)) <= set(failures(stage, found))


@pytest.mark.parametrize("channels, passes", [(2, False), (3, True)])
def test_no_name_that_makes_half_of_the_channels_worse(channels, passes):
    names = ("force", "speed", "angle")[:channels]
    pieces = [replace(piece, channel=replace(piece.channel, name=name)) for piece in PROBLEM.pieces for name in names]
    before, after = (replace(scored(), by_channel=dict.fromkeys(names, 2.0) | {"force": worst}) for worst in (2.0, 3.0))
    found = evidence(model(before, pieces=pieces), model(after, effects=(SINE,), pieces=pieces))
    assert criterion("most channels no worse").passes(found) == passes


def test_messages_name_size_and_significance_apart():
    significance, size = criterion("gap reduction significant"), criterion("gap reduction relevant")
    assert "significantly" in significance.message and "5 %" not in significance.message
    assert size.message == "too small: closes less than 5 % of the gap"
    assert criterion("relevant after calibration").message != size.message


def test_nonphysical_effects_each_get_a_message():
    sine, bend = (replace(each, physical=(0.0, 9.0), nonphysical=f"no {each.name}") for each in EFFECTS[:2])
    fitted = model(scored(1.0), effects=(sine, bend))
    fitted.fit.values |= {"sine": -1.0, "bend": -2.0}
    messages = criterion("sign and size physical").messages(evidence(model(scored()), fitted))
    assert [message.rpartition(": ")[2] for message in messages] == ["it would be no sine", "it would be no bend"]


def test_table_holds_plain_strings_in_order():
    rows = criteria_table()
    assert [row.name for row in rows] == list(AT_THRESHOLD)
    assert all(isinstance(cell, str) and cell and "{" not in cell for row in rows for cell in row)
    assert len({row.message for row in rows}) == len(rows)
    assert "5 %" in criterion("gap reduction relevant").threshold


# An exemption: a slow effect gains little everywhere, and one event at the end outweighs many a stretch.
EVENT = np.where(TIME > 115.0, 6.0, 0.0)
WITHOUT, SLOW = scored(3.0, 2.0), scored(1.1, 1.5 + EVENT)
# A log that shows its cause once: most resamples do not hold it.
ONCE, BETTER = scored(1.0 + EVENT, 2.0 + EVENT), scored(1.0, 2.0)


@pytest.fixture
def exempt(monkeypatch):
    """Whether an effect is exempt from predicting better in every block, given what it leaves."""

    def tested(before, after, *, within=True, adequate=False, already_within=False):
        left = SimpleNamespace(within_thresholds=within, adequate=adequate)
        monkeypatch.setattr(evidence_tests, "check_adequacy", lambda *given: left)
        found = evidence(model(before), model(after, effects=(SINE,)), CANDIDATES)
        found.state.adequacy.within_thresholds = already_within
        exemption = criterion("predicts held-out data").exemption
        assert exemption is not None
        return exemption.holds(found)

    return tested


def test_slow_effect_that_ends_the_gap_is_exempt(exempt):
    assert not predicts_better(BOOTSTRAP, SLOW, WITHOUT, CANDIDATES)
    assert exempt(WITHOUT, SLOW)


def test_effect_that_leaves_a_gap_is_not_exempt(exempt):
    assert not exempt(WITHOUT, SLOW, within=False)


def test_nothing_is_exempt_where_only_noise_is_left(exempt):
    assert not exempt(WITHOUT, SLOW, already_within=True)


def test_worse_prediction_is_not_exempt(exempt):
    assert not exempt(WITHOUT, scored(1.1, 2.1))


def test_gap_reduction_by_chance_is_not_exempt(exempt):
    assert not exempt(WITHOUT, scored(2.9 + np.sin(TIME / 7.0), 1.5))


def test_single_event_needs_strong_evidence_and_adequacy(exempt):
    assert not predicts_better(BOOTSTRAP, BETTER, ONCE, CANDIDATES)
    assert exempt(ONCE, BETTER, adequate=True)
    assert not exempt(ONCE, BETTER)
    assert not exempt(scored(1.0 + EVENT, 2.0 + 0.15 * EVENT), BETTER, adequate=True)


@pytest.mark.parametrize(("complete", "messages"), [(True, 0), (False, 1)])
def test_small_effect_is_exempt_if_nothing_is_left(complete, messages, monkeypatch):
    monkeypatch.setattr(evidence_tests, "check_adequacy", lambda *given: SimpleNamespace(complete=complete))
    monkeypatch.setattr(naming_criteria, "CRITERIA", (criterion("relevant after calibration"),))
    assert len(failures(Stage.CANDIDATE, closes_of_calibrated(OUTSIDE))) == messages


def test_exemption_is_not_tried_after_another_failure(monkeypatch):
    monkeypatch.setattr(evidence_tests, "check_adequacy", lambda *given: pytest.fail("simulated for nothing"))
    found = closes_of_calibrated(OUTSIDE)
    assert criterion("relevant after calibration").message in failures(Stage.CANDIDATE, found)


def test_size_and_evidence_are_different_kinds():
    assert criterion("material").kind is Kind.SIZE
    assert criterion("likelihood ratio").kind is Kind.EVIDENCE
    assert criterion("sign and size physical").kind is Kind.MEANING

