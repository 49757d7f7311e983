"""A blind check small enough for every change: ten cheap cases, and the accuracy that must not be lost.

Cheap: logs of 40 s on the shortest of the rig files, effects that only touch what a sensor reads or a motor gives, two
candidates, coarse meshes, and nothing recommended after the answer.
"""

from __future__ import annotations

import importlib

import pytest

from slider_drilling.blind import check
from slider_drilling.blind.cases import Case
from slider_drilling.blind.totals import count_totals
from slider_drilling.campaign.results import ResultFolder
from slider_drilling.campaign.run import CampaignOutcome
from slider_drilling.campaign.worker import run_job
from slider_drilling.diagnosis import build_model
from slider_drilling.files.installed_files import installed_file

CANDIDATES = ("torque_sensor_bias", "motor_wear")
SIZE = 4.0
# Of five effects at four noise floors, and of five logs without any.
LEAST_NAMED, MOST_ALARMS = 4, 1


def run_here(what, jobs, folder):
    """The jobs of a campaign in this process, whose meshes are coarse."""
    outcome = CampaignOutcome([job.key() for job in jobs], ResultFolder(folder))
    folder.mkdir(exist_ok=True)
    for key, job in zip(outcome.keys, jobs, strict=True):
        outcome.results.write(key, job, run_job(job))
    outcome.completed = len(jobs)
    return outcome


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_large_effects_are_named_without_false_alarms(tmp_path, monkeypatch):
    monkeypatch.setattr(build_model, "MESHES", (16, 24, 30))
    search = importlib.import_module("slider_drilling.gap.explain")  # the package's name is its function
    monkeypatch.setattr(search, "recommend_manoeuvre", lambda *arguments: None)
    sealed = [Case((name,), SIZE, "own", "steady", seed, 40.0)
              for seed, name in enumerate((*CANDIDATES, *CANDIDATES, CANDIDATES[0]))]  # fmt: skip
    empty = [Case(("none",), 0.0, "own", "steady", seed, 40.0) for seed in range(10, 15)]

    assert check.seal([*sealed, *empty], installed_file("config/rig.short.yaml"), tmp_path, run_here).exit_code == 0
    checked = check.check(tmp_path, tmp_path, None, check.DiagnosisRequest(CANDIDATES, oracle=False), run_here)
    assert checked.exit_code == 0 and len(checked.cases) == 10
    found = count_totals(checked.cases)
    said = [(case.true_effects, case.outcome, case.named_effects) for case in checked.cases]
    assert found.named.count >= LEAST_NAMED, said
    assert found.false_alarms.count <= MOST_ALARMS, said
