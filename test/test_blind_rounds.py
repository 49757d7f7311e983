"""Rounds of a blind check: evidence for the truth, totals of arms, and arms against each other."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from click.testing import CliRunner
from short_well import short_rig

from slider_drilling.blind.cases import CasePlan, draw_cases
from slider_drilling.blind.evidence_for_truth import as_diagnosis, evidence_for
from slider_drilling.blind.label import Label
from slider_drilling.blind.recorder import write_sealed_log
from slider_drilling.blind.round_totals import arm_totals, compare_arms, rounds_json
from slider_drilling.blind.rounds import ArmResult, RoundsRequest, check_rounds
from slider_drilling.blind.rounds_page import rounds_page
from slider_drilling.blind.score import score
from slider_drilling.campaign.results import JobResult, ResultFolder
from slider_drilling.campaign.run import CampaignOutcome
from slider_drilling.commands.blind_check import command
from slider_drilling.diagnosis.programme_numbers import programme_of, programme_variables
from slider_drilling.drillstring import simulate
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import read_log
from slider_drilling.pages import page_html
from slider_drilling.programmes import open_loop_commands
from slider_drilling.units import SI

NEEDED = {"stribeck": 14.0, "heave": 14.0}


def result(arm, log, gains, effects=("stribeck",), used=None):
    kind = "two" if len(effects) == 2 else "single"
    label = Label(log, kind, effects, (("contact",),), 1.5, (1.5,) * len(effects), "own", "steady", 1, None, {}, {})
    tree = {"gains": gains, "needed": {name: NEEDED[name] for name in effects}}
    return ArmResult(arm, score(label, as_diagnosis(tree)), used, gains)


RESULTS = [
    result("routine", "a", {"stribeck": 3.0}), result("routine", "b", {"stribeck": 20.0}),
    result("planned 1", "a", {"stribeck": 30.0}, used=0.8), result("planned 1", "b", {"stribeck": 40.0}, used=1.2),
    result("random", "a", {"stribeck": 2.0}, used=0.5), result("random", "b", {"stribeck": 50.0}, used=0.6),
    result("routine", "c", {"stribeck": 30.0, "heave": 3.0}, ("stribeck", "heave")),
]  # fmt: skip


def test_totals_count_what_has_enough_evidence():
    routine, planned, random = arm_totals(RESULTS)
    assert (routine.single_named.count, routine.single_named.total) == (1, 2)
    assert (routine.both_named.count, routine.both_named.total) == (0, 1)
    assert (planned.single_named.count, random.single_named.count) == (2, 1)
    assert (planned.over_limit.count, planned.largest_limit_use) == (1, 1.2)
    assert routine.largest_limit_use is None
    assert routine.extra_names.total == 0  # evidence alone names nothing wrong


def test_arms_are_compared_on_the_same_cases():
    pair = compare_arms(RESULTS, "planned 1", "routine")
    assert (pair.cases, pair.first_missed, pair.second_missed) == (2, 0, 1)
    assert (pair.only_first_missed, pair.only_second_missed, pair.p_value) == (0, 1, 1.0)


def test_page_and_json_hold_every_arm():
    page = page_html(rounds_page(RESULTS, True), SI)
    tree = rounds_json(RESULTS, {"rounds": 1})
    assert [arm["arm"] for arm in tree["arms"]] == ["routine", "planned 1", "random"]
    assert all(arm["arm"] in page for arm in tree["arms"])
    assert {pair["second"] for pair in tree["paired"]} == {"routine", "random"}
    assert len(tree["cases"]) == len(RESULTS)


def test_note_says_how_many_runs_were_planned():
    def note(*arms):
        return rounds_page([result(arm, "a", {"stribeck": 3.0}) for arm in ("routine", *arms)], False).notes[0]

    assert note("planned 1", "random").endswith("longer than a programme may be.")
    assert note("planned 1", "random", "planned 2", "planned 3").endswith("; then with 2 and 3 planned runs.")


def test_headline_names_every_run_that_is_best():
    def headline(*results):
        return rounds_page(results, True).headline.text

    least, enough = {"stribeck": 3.0}, {"stribeck": 30.0}
    assert "after planned 1: 1 of 1" in headline(result("routine", "a", least), result("planned 1", "a", enough))
    both = headline(result("routine", "a", enough), result("planned 1", "a", enough), result("random", "a", least))
    assert "after routine and planned 1: 1 of 1" in both
    assert "after each run: 1 of 1" in headline(result("routine", "a", enough), result("random", "a", enough))


@pytest.mark.parametrize(("bias", "named"), [(900.0, ("torque_sensor_bias",)), (0.0, ())])
def test_evidence_is_there_where_the_effect_is(tmp_path, bias, named):
    rig = short_rig()
    design = {each.name: each.nominal for each in programme_variables(rig)}
    commands = open_loop_commands(programme_of(design, rig, 60.0), rig)
    response = simulate(rig, commands, 60)
    shifted = replace(response, surface_torque=response.surface_torque + bias)
    write_sealed_log(tmp_path / "log.mcap", rig, commands, shifted, np.random.default_rng(2))
    tree = evidence_for([read_log(tmp_path / "log.mcap")], ["torque_sensor_bias"])
    assert as_diagnosis(tree).named_effects == named
    assert tree["gains"]["torque_sensor_bias"] > -1e-6


def test_json_holds_the_options_of_the_logs(tmp_path, monkeypatch):
    """Whoever reads the figures can make the same rigs again."""
    sealed = CampaignOutcome([], ResultFolder(tmp_path), completed=1)
    monkeypatch.setattr("slider_drilling.blind.check.seal", lambda *arguments: sealed)
    monkeypatch.setattr("slider_drilling.blind.rounds.check_rounds", lambda *arguments: (RESULTS, [sealed]))
    given = ["--rounds", "1", "--minutes", "2", "--cases", "1", "--seed", "504", "--effects", "heave", "--sizes", "1.5",
             "--plants", "model", "--duration", "120", "--evidence-only", "-o", str(tmp_path / "out")]  # fmt: skip
    CliRunner().invoke(command, given, catch_exceptions=False, standalone_mode=False)
    options = json.loads((tmp_path / "out" / "rounds.json").read_text())["options"]
    expected = {"seed": 504, "effects": "heave", "sizes": "1.5", "plants": "model", "duration": 120.0, "cases": 1,
                "rounds": 1, "minutes": 2.0, "evidence_only": True}  # fmt: skip
    assert {name: options[name] for name in expected} == expected


def test_interrupted_rounds_score_what_came_to_its_end(tmp_path):
    """The second stage is stopped; no further one is run, and the routine answers are scored."""
    (case,) = draw_cases(CasePlan(effects=("heave",), sizes=(1.5,)), 1)
    stem = case.file_stem()
    (tmp_path / "logs").mkdir()
    (tmp_path / "labels").mkdir()
    (tmp_path / "logs" / f"{stem}.mcap").write_bytes(b"log")
    label = Label(stem, "single", ("heave",), (("draw_works",),), 1.5, (1.5,), "own", "steady", 1, None, {}, {})
    (tmp_path / "labels" / f"{stem}.json").write_text(json.dumps(asdict(label)))
    stages = []

    def run(stage, jobs, folder):
        stages.append(stage)
        keys, results = [job.key() for job in jobs], ResultFolder(folder)
        if len(stages) == 2:
            return CampaignOutcome(keys, results, stop_code=130)
        for key, job in zip(keys, jobs, strict=True):
            tree = {"gains": {"heave": 20.0}, "needed": {"heave": 14.0}, "calibrated": {}}
            results.write(key, job, JobResult(tree, 1.0, 1.0, 0))
        return CampaignOutcome(keys, results, completed=len(jobs))

    rig = installed_file("config/rig.example.yaml")
    results, outcomes = check_rounds([case], rig, tmp_path, RoundsRequest(2, evidence_only=True), run)
    assert [(each.arm, each.case.truth_named) for each in results] == [("routine", True)]
    assert stages == ["diagnosing after routine", "planning round 1"]
    assert outcomes[-1].exit_code == 130
