"""A blind check small enough for every change: ten cheap cases, and the accuracy that must not be lost.

Cheap: logs of 40 s on the shortest of the rig files, effects that only touch what a sensor reads or a motor gives, two
candidates; a minute of processor time.
"""

from __future__ import annotations

import pytest

from slider_drilling.blind import check
from slider_drilling.blind.cases import Case
from slider_drilling.blind.totals import count_totals
from slider_drilling.campaign.run import WorkerSettings, run_jobs
from slider_drilling.files.installed_files import installed_file

CANDIDATES = ("torque_sensor_bias", "motor_wear")
SIZE = 4.0
# Of five effects at four noise floors, and of five logs without any.
LEAST_NAMED, MOST_ALARMS = 4, 1


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_large_effects_are_named_without_false_alarms(tmp_path):
    sealed = [Case((name,), SIZE, "own", "steady", seed, 40.0)
              for seed, name in enumerate((*CANDIDATES, *CANDIDATES, CANDIDATES[0]))]  # fmt: skip
    empty = [Case(("none",), 0.0, "own", "steady", seed, 40.0) for seed in range(10, 15)]

    def run(what, jobs, folder):
        return run_jobs(jobs, folder, WorkerSettings(1))

    assert check.seal([*sealed, *empty], installed_file("config/rig.short.yaml"), tmp_path, run).exit_code == 0
    checked = check.check(tmp_path, tmp_path, None, check.DiagnosisRequest(CANDIDATES, oracle=False), run)
    assert checked.exit_code == 0 and len(checked.cases) == 10
    found = count_totals(checked.cases)
    said = [(case.true_effects, case.outcome, case.named_effects) for case in checked.cases]
    assert found.named.count >= LEAST_NAMED, said
    assert found.false_alarms.count <= MOST_ALARMS, said
