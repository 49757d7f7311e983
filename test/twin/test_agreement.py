import pytest

from slider_drilling.twin.agreement import DiagnosedChange, agreed, diagnosed_change

_WASHOUT = DiagnosedChange("effect", ("washout",), site="hydraulics")
_MOTOR = DiagnosedChange("effect_and_unknown", ("motor_wear",), suspected=("heave",), site="motor")
_EITHER = DiagnosedChange("effect", ("motor_wear",), ("washout",), site="motor")
_UNKNOWN = DiagnosedChange("unknown", suspected=("heave",))


@pytest.mark.parametrize(("earlier", "latest", "effects"), [
    ((), _WASHOUT, ("washout",)), ((_UNKNOWN,), _WASHOUT, ("washout",)), ((_WASHOUT,), _UNKNOWN, ()),
    ((_WASHOUT,), _MOTOR, ()), ((_MOTOR, _WASHOUT), _WASHOUT, ("washout",)), ((_WASHOUT,) * 3, _MOTOR, ()),
    ((_WASHOUT,), _EITHER, ("motor_wear",)),
])  # fmt: skip
def test_name_stands_if_most_diagnoses_agree_with_it(earlier, latest, effects):
    assert agreed(earlier, latest).effects == effects


def test_of_what_is_alike_the_name_of_most_diagnoses_is_given():
    assert agreed((_EITHER,), _EITHER) == _EITHER
    most = agreed((_WASHOUT, _WASHOUT), _EITHER)
    assert most == DiagnosedChange("effect", ("washout",), ("motor_wear",), ("motor_wear",), "hydraulics")


def test_contradicted_names_are_suspected_and_their_site_is_unknown():
    change = agreed((_WASHOUT,), _MOTOR)
    assert change == DiagnosedChange("unknown", suspected=("motor_wear", "washout", "heave"))
    pump = DiagnosedChange("effect", ("plugged_nozzle",), site="hydraulics")
    assert agreed((_WASHOUT,), pump).site == "hydraulics"


def test_answer_is_read_as_diagnosis_json_has_it():
    tree = {"verdict": "effect", "effects": ["washout"], "site": "hydraulics", "suspected": [{"effect": "heave"}],
            "ranking": [{"in_answer": False, "group": []}, {"in_answer": True, "group": ["leak"]}]}  # fmt: skip
    assert diagnosed_change(tree) == DiagnosedChange("effect", ("washout",), ("leak",), ("heave",), "hydraulics")
    assert diagnosed_change({}) == DiagnosedChange("")
