"""diagnosis.json: plain JSON, documented keys, and the keys that gap.md fixes."""

from __future__ import annotations

import json
from dataclasses import replace

from diagnosis_example import inconclusive, shaped, worn_motor

from slider_drilling.diagnosis.to_json import to_json


def test_tree_is_plain_json():
    tree = to_json(replace(worn_motor(), residual_shape=shaped("rest")))
    assert json.loads(json.dumps(tree, allow_nan=False)) == tree
    assert tree["rig"] == {"name": "own.yaml", "source": "given", "path": "b/own.yaml"}
    assert [(row["passed"], row["in_answer"]) for row in tree["ranking"]] == [
        (True, True),
        (True, False),
        (False, False),
    ]
    assert tree["ranking"][0]["parameters"]["torque_loss"] == {
        "value": 0.24, "unit": "-", "nominal": 0.0, "interval": [0.21, 0.27],
    }  # fmt: skip
    assert tree["residual_shape"]["y_label"] == "change of pressure lost, Pa" or tree["residual_shape"]["x"]


def test_every_key_is_documented(repository):
    tree = to_json(worn_motor())
    page = (repository / "docs" / "reference" / "diagnosis.md").read_text()
    for block in (tree, tree["gap"], tree["ranking"][0], tree["rig"], tree["whole_run_errors"]):
        for key in block:
            assert f"`{key}`" in page, key


def test_keys_do_not_depend_on_the_verdict():
    tree, empty = to_json(worn_motor()), to_json(inconclusive())
    assert set(empty) == set(tree)
    assert set(empty["gap"]) == set(tree["gap"])


def test_keys_fixed_by_the_specification_are_there():
    tree = to_json(worn_motor())
    assert tree["schema"] == "slider_drilling/diagnosis/3"
    assert {"log", "verdict", "suspected", "site", "effects", "gap", "where", "ranking", "next_manoeuvre",
            "tuned_parameters", "runtime_s"} <= set(tree)  # fmt: skip
    assert {"nominal", "tuned", "with_effect", "closed", "closed_interval", "noise_floor"} <= set(tree["gap"])
    assert set(tree["where"]) == {"channel", "phase", "band", "time", "depth"}
    assert {"effect", "closed", "interval", "parameters", "group"} <= set(tree["ranking"][0])


def test_masked_effects_and_misfit_channels_are_listed():
    diagnosis = worn_motor()
    gap = replace(diagnosis.gap, misfit_channels=("standpipe_pressure",))
    tree = to_json(replace(diagnosis, gap=gap, masked_effects=("motor_wear",)))
    assert tree["masked_effects"] == ["motor_wear"]
    assert tree["gap"]["misfit_channels"] == ["standpipe_pressure"]
    assert to_json(diagnosis)["masked_effects"] == []
