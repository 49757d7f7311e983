"""An investigation stops for a log, goes on where its files end, and ends for a reason."""

import json
import signal
import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest
from click.testing import CliRunner
from short_well import short_rig

from slider_drilling import commands
from slider_drilling.commands.investigate import command, run_on_ros
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.gap.experiment_design.plan import PlannedRun, TestPlan
from slider_drilling.investigation import loop
from slider_drilling.investigation.belief_page import belief_page, investigation_json
from slider_drilling.investigation.loop import Investigation, InvestigationOptions, investigate
from slider_drilling.investigation.round import PlannedTest, Round, read_round_answer, round_answer
from slider_drilling.investigation.sealed_source import folder_recorder, sealed_recorder, sealed_rig
from slider_drilling.investigation.setup import FILE, InvestigationSetup, check_setup, keep_setup
from slider_drilling.log import read_log
from slider_drilling.pages import page_html
from slider_drilling.process import own_path
from slider_drilling.process.shutdown import TerminationSignal
from slider_drilling.programmes import Programme, Rest, Step, load_programme, open_loop_commands
from slider_drilling.programmes.open_loop import SETTLING
from slider_drilling.rig import dump_rig, load_rig
from slider_drilling.test_planning.drilling_plan import DrillingPlan
from slider_drilling.units import SI


def installed_rig():
    return load_rig(installed_file("config/rig.example.yaml"))


ASKED = {"reason": "no known effect explains the gap"}


def explanation(effects, weight):
    return {"effects": list(effects), "weight": weight, "parameters": {}, "fidelity": 0}


def answer(verdict="unknown", effects=(), asked=ASKED):
    explanations = [explanation(effects, 0.7), explanation((), 0.3)]
    return {"schema": "slider_drilling/diagnosis/3", "log": "log", "verdict": verdict, "effects": list(effects),
            "summary": "So it is.", "next_manoeuvre": asked, "explanations": explanations, "ranking": []}  # fmt: skip


@pytest.fixture
def scripted(monkeypatch):
    """Diagnoses and plans by script: (verdict tree, loss before, loss after) of each round."""

    def script(*rounds):
        def plan_of(folder, number, rig, options, progress):
            before, after = rounds[number - 1][1:]
            prospects = [SimpleNamespace(loss=loss) for loss in (before, after)]
            plan = SimpleNamespace(baseline=prospects[0], planned=SimpleNamespace(prospect=prospects[1]))
            return SimpleNamespace(plan=plan, programme=Programme((Step(Rest(5.0)),)))

        monkeypatch.setattr(loop, "_answer", lambda folder, number, *rest: round_answer(rounds[number - 1][0], "so"))
        monkeypatch.setattr(loop, "_plan", plan_of)
        monkeypatch.setattr(loop, "planned_test", lambda plan: PlannedTest(5.0, ()))
        monkeypatch.setattr(loop, "plan_page", lambda plan: None)
        monkeypatch.setattr(loop, "write_page", lambda path, page, units: path.write_text(""))

    return script


def run(folder, rounds=3):
    return investigate(folder, short_rig(), folder_recorder, InvestigationOptions(rounds), SI)


def test_folder_waits_for_each_log_and_goes_on(tmp_path, scripted):
    scripted((answer(), 3.0, 1.0), (answer("effect", ["stribeck"], None), 0.0, 0.0))
    found = run(tmp_path)
    assert found.waits_for == tmp_path / "log1.mcap"
    assert "programme0.yaml" in found.ending
    routine = load_programme(tmp_path / "programme0.yaml")
    assert open_loop_commands(routine, short_rig()).time[-1] <= loop.ROUTINE_S
    (tmp_path / "log1.mcap").touch()
    found = run(tmp_path)
    assert found.waits_for == tmp_path / "log2.mcap"
    assert load_programme(tmp_path / "programme1.yaml").steps == (Step(Rest(5.0)),)
    (tmp_path / "log2.mcap").touch()
    found = run(tmp_path)
    assert (found.waits_for, found.ending) == (None, "the answer stands")
    assert [each.answer.verdict for each in found.rounds] == ["unknown", "effect"]


def test_open_answer_ends_where_no_test_helps(tmp_path, scripted):
    scripted((answer(), 3.0, 2.9))
    (tmp_path / "log1.mcap").touch()
    assert run(tmp_path).ending == "nothing more can be learnt within the limits"


def test_clean_answer_goes_on_while_much_is_hidden(tmp_path, scripted):
    scripted((answer("none", asked=None), 3.0, 1.0))
    (tmp_path / "log1.mcap").touch()
    assert run(tmp_path).waits_for == tmp_path / "log2.mcap"


def test_test_that_was_run_keeps_its_programme(tmp_path, scripted):
    """Another --minutes or --programmes would plan another one, or none; the log is that of the first."""
    scripted((answer(), 3.0, 2.9), (answer("effect", ["stribeck"], None), 0.0, 0.0))
    (tmp_path / "programme1.yaml").write_text("what was run")
    for number in (1, 2):
        (tmp_path / f"log{number}.mcap").touch()
    found = run(tmp_path)
    assert [each.number for each in found.rounds] == [1, 2]
    assert (tmp_path / "programme1.yaml").read_text() == "what was run"


def test_interrupted_diagnosis_is_no_answer(tmp_path, monkeypatch):
    """An answer before every effect was tried is not kept: the same command diagnoses the log again."""
    monkeypatch.setattr(loop, "diagnose", lambda *logs, **options: SimpleNamespace(interrupted=True))
    monkeypatch.setattr(loop, "read_log", lambda path: None)
    monkeypatch.setattr(loop, "write_diagnosis", lambda answer, folder, units: pytest.fail("written"))
    (tmp_path / "log1.mcap").touch()
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path)


def test_rounds_are_not_exceeded(tmp_path, scripted):
    scripted((answer(), 3.0, 1.0), (answer(), 2.0, 1.0))
    for number in (1, 2):
        (tmp_path / f"log{number}.mcap").touch()
    assert run(tmp_path, rounds=1).ending == "1 test was made"


def test_page_shows_the_probability_of_each_explanation(tmp_path, scripted):
    scripted((answer(), 3.0, 1.0), (answer("effect", ["stribeck"], None), 0.0, 0.0))
    for number in (1, 2):
        (tmp_path / f"log{number}.mcap").touch()
    found = run(tmp_path)
    page = page_html(belief_page(found, short_rig()), SI)
    assert "The answer stands" in page
    assert "stribeck" in page
    tree = json.loads(json.dumps(investigation_json(found), allow_nan=False))
    assert [each["open_before"] for each in tree["rounds"]] == [3.0, 0.0]


def test_rare_explanations_share_the_last_colour():
    """A page has eight colours."""
    names = "abcdefghij"
    weights = dict.fromkeys(names, 0.02) | {"a": 0.82}
    tree = answer() | {"explanations": [explanation([name], weights[name]) for name in names]}
    page = belief_page(Investigation((Round(1, round_answer(tree, "so")),), "so"), short_rig())
    chart = next(item for section in page.sections for item in section.items if hasattr(item, "panels"))
    bars = {bar.name: bar.y[0] for bar in chart.panels[0].marks}
    assert list(bars) == [*names[:7], "others"]
    assert bars["others"] == pytest.approx(0.06)


def test_likeliest_explanation_that_is_not_named_says_why():
    tree = answer() | {
        "effects": [], "explanations": [explanation(["static_aging"], 0.9), explanation([], 0.1)],
        "ranking": [{"effect": "static_aging", "why_not": ["too small"]}],
    }  # fmt: skip
    assert "not named: static aging (too small)." in page_of_one_round(tree)
    named = tree | {"effects": ["static_aging"]}
    assert "not named" not in page_of_one_round(named)


def page_of_one_round(tree):
    return page_text(Investigation((Round(1, round_answer(tree, "so")),), "so"))


def page_text(investigation):
    return page_html(belief_page(investigation, short_rig()), SI)


def test_seal_is_opened_at_the_end():
    done = Investigation((Round(1, round_answer(answer(), "so")),), "so", sealed=(("cuttings_bed", 1.52),))
    assert "with its size in the first log: cuttings bed (1.5 noise floors)." in page_text(done)
    assert investigation_json(done)["sealed"] == [{"effect": "cuttings_bed", "size": 1.52}]
    assert investigation_json(replace(done, sealed=None))["sealed"] is None


def planned_run(seconds, loss, used):
    times = SimpleNamespace(time=[0.0, seconds])
    manoeuvre = SimpleNamespace(model=SimpleNamespace(runs=(times,)))
    return PlannedRun(manoeuvre, SimpleNamespace(loss=loss), used)


@pytest.mark.parametrize(
    ("seconds", "loss", "used", "taken"),
    [(237.0, 1.5, 0.8, True), (300.0, 1.5, 0.8, False), (237.0, 1.5, 0.95, False), (237.0, 1.9, 0.8, False)],
)
def test_first_test_is_commissioning_where_it_fits(seconds, loss, used, taken):
    fixed = planned_run(seconds, loss, used)
    plan = TestPlan(None, SimpleNamespace(loss=2.0), planned_run(240.0, 1.0, 0.8), {"commissioning": fixed}, 10)
    drilling = DrillingPlan(short_rig(), InvestigationOptions().plan, plan, None)
    assert (loop.with_fixed_test(drilling).plan.planned is fixed) is taken


def test_sealed_rig_runs_programmes_and_hides_the_truth(tmp_path):
    sealed = sealed_rig(short_rig(), ("torque_sensor_bias",), 2.0, 3)
    short = replace(sealed, routine=sealed.routine.samples(slice(0, 100)))
    record = sealed_recorder(short)
    programme = tmp_path / "programme1.yaml"
    programme.write_text("schema: slider_drilling/programme/1\nsteps: [{rest: {time: 12 s}}]\n")
    for number in (1, 2):
        assert record(number, programme, tmp_path / f"log{number}.mcap")
    first, second = (read_log(tmp_path / f"log{number}.mcap") for number in (1, 2))
    assert second.top_drive.time[-1] == pytest.approx(SETTLING + 12.0, abs=0.2)
    assert first.rig() == second.rig() == short_rig()
    assert b"torque_sensor_bias" not in (tmp_path / "log2.mcap").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--on", "ROS"], "--on ROS: write ros; give a folder of that name as ./ROS"),
        (["--on", "sealed", "--drive-rig"], "--drive-rig: only with --on ros"),
        (["--on", "sealed", "--sealed-effect", "gremlins"], "gremlins: unknown; use stribeck"),
        (["--on", "sealed", "--size", "0"], "--size 0: must be 0.05 to 50"),
        (["--on", "sealed", *["--sealed-effect", "heave"] * 2], "sealed effect heave: given twice"),
        (["--on", "sealed", "--sealed-effect", "heave", "--sealed-effect", "stribeck", "--size", "0.5"],
         "size 0.5: two sealed effects need at least 1.5 noise floors each"),
        (["--on", "ros", "--effect", "gremlins"], "'gremlins': no such effect"),
        (["--on", "ros", "--drive-rig", "--effect", "heave"], "--effect: only with --on ros, of the simulated rig"),
        (["--on", "ros", "--sealed-effect", "heave"], "--sealed-effect: only with --on sealed"),
        (["--on", "ros", "--size", "2"], "--size: only with --on sealed"),
        (["--on", "sealed", "--wait", "5"], "--wait: only with --on FOLDER"),
        (["--on", "sealed", "--effect", "heave"], "--effect: only with --on ros"),
        (["--on", "sealed", "--minutes", "0"], "minutes 0: must be 1 to 30 min"),
    ],
)
def test_wrong_options_are_refused(tmp_path, arguments, words):
    rig = str(installed_file("config/rig.example.yaml"))
    result = CliRunner().invoke(command, ["--rig", rig, *arguments, "-o", str(tmp_path / "out")])
    assert isinstance(result.exception, InputError)
    assert words in str(result.exception)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--sealed-effect", "heave"], "--sealed-effect: only with --on sealed"),
        (["--size", "1.5"], "--size: only with --on sealed"),
        (["--effect", "heave"], "--effect: only with --on ros"),
        (["--drive-rig"], "--drive-rig: only with --on ros"),
        (["-o", "elsewhere"], "--output: leave it out; with --on "),
        (["--wait", "-1"], "--wait -1: must be 0 min or more"),
        (["--wait", "nan"], "--wait nan: must be 0 min or more"),
    ],
)
def test_folder_refuses_what_it_would_ignore(tmp_path, arguments, words):
    rig = str(installed_file("config/rig.example.yaml"))
    result = CliRunner().invoke(command, ["--rig", rig, "--on", str(tmp_path / "well"), *arguments])
    assert isinstance(result.exception, InputError)
    assert str(result.exception).startswith(words)
    assert not (tmp_path / "well").exists()


def test_runs_on_the_simulator_have_noise_of_their_own(tmp_path, monkeypatch):
    """Two logs with the same noise are no two witnesses."""
    seeds = []
    monkeypatch.setattr(commands.investigate, "run_on_ros", lambda *call: seeds.append(call[-1]) or True)
    record = commands.investigate._recorder("ros", tmp_path, (), None, 0.0, 2**31 - 2)
    assert all(record(number, tmp_path, tmp_path) for number in (1, 2, 3))
    assert len(set(seeds)) == 3 and max(seeds) < 2**31


def test_interrupt_ends_the_run_in_order(tmp_path, monkeypatch):
    """Whatever signal ends the command, the process that moves the rig is interrupted and comes to its end."""
    ended = tmp_path / "ended"
    moving = (
        "import sys, time\n"
        "try:\n"
        "    print('waiting for the rig', file=sys.stderr, flush=True)\n"
        "    time.sleep(60.0)\n"
        "except KeyboardInterrupt:\n"
        f"    open({str(ended)!r}, 'w').close()\n"
    )

    def interrupted(line, **options):
        raise TerminationSignal(signal.SIGTERM)

    monkeypatch.setattr("slider_drilling.commands.investigate.click.echo", interrupted)
    monkeypatch.setattr(own_path, "worker_command", lambda *arguments: [sys.executable, "-c", moving])
    with pytest.raises(TerminationSignal):
        run_on_ros(tmp_path / "rig", tmp_path / "programme", tmp_path / "log1.mcap", effects=(), driven="/rig")
    assert ended.exists()


SETUP = InvestigationSetup("sealed", short_rig(), 3, ("heave",), 1.5)


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (replace(SETUP, effects=("stribeck",)), "--sealed-effect heave, not stribeck; "),
        (replace(SETUP, effects=()), "--sealed-effect heave, not none"),
        (replace(SETUP, size=4.0), "--size 1.5, not 4.0"),
        (replace(SETUP, seed=4), "--seed 3, not 4"),
        (replace(SETUP, rig=installed_rig()), "another rig file"),
        (InvestigationSetup("ros", short_rig(), 3, ("heave",)), "--on sealed, not ros"),
        (InvestigationSetup("FOLDER", short_rig(), 3), "--on sealed, not FOLDER"),
        (replace(SETUP, seed=4, size=2.0), "--size 1.5, not 2.0; --seed 3, not 4"),
    ],
)
def test_logs_of_another_setup_are_refused(tmp_path, other, words):
    keep_setup(tmp_path, SETUP)
    (tmp_path / "log1.mcap").touch()
    check_setup(tmp_path, SETUP)
    keep_setup(tmp_path, SETUP)
    kept = (tmp_path / FILE).read_bytes()
    for refuse in (check_setup, keep_setup):
        with pytest.raises(InputError, match="holds an investigation with another setup: ") as refused:
            refuse(tmp_path, other)
        assert words in str(refused.value)
    assert (tmp_path / FILE).read_bytes() == kept


def test_setup_without_a_log_is_replaced(tmp_path):
    keep_setup(tmp_path, SETUP)
    (tmp_path / "programme0.yaml").touch()
    other = InvestigationSetup("FOLDER", installed_rig(), 1)
    keep_setup(tmp_path, other)
    assert not (tmp_path / "programme0.yaml").exists()
    (tmp_path / "log1.mcap").touch()
    check_setup(tmp_path, other)


def test_logs_without_a_setup_are_those_of_a_folder(tmp_path):
    (tmp_path / "log1.mcap").touch()
    for source in ("sealed", "ros"):
        with pytest.raises(InputError, match=r"holds log1\.mcap, but no investigation_setup\.json"):
            check_setup(tmp_path, replace(SETUP, source=source))
    keep_setup(tmp_path, InvestigationSetup("FOLDER", short_rig(), 3))


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"schema": "slider_drilling/investigation_setup/9"}'])
def test_damaged_setup_is_refused(tmp_path, text):
    (tmp_path / FILE).write_text(text)
    (tmp_path / "log1.mcap").touch()
    with pytest.raises(InputError, match="damaged, or of another version"):
        check_setup(tmp_path, SETUP)


def test_damaged_diagnosis_is_refused(tmp_path):
    path = tmp_path / "diagnosis.json"
    whole = answer()
    for text in ("{", json.dumps({key: whole[key] for key in whole if key != "ranking"}),
                 json.dumps(whole | {"next_manoeuvre": {}})):  # fmt: skip
        path.write_text(text)
        with pytest.raises(InputError, match=r"diagnosis\.json: damaged; delete its folder"):
            read_round_answer(path)


def test_command_refuses_the_logs_of_another_rig(tmp_path):
    path = tmp_path / "rig.yaml"
    path.write_text(dump_rig(short_rig()))
    keep_setup(tmp_path / "out", SETUP)
    (tmp_path / "out" / "log1.mcap").touch()
    given = ["--rig", str(path), "--on", "sealed", "--sealed-effect", "stribeck", "--seed", "3"]
    result = CliRunner().invoke(command, [*given, "-o", str(tmp_path / "out")])
    assert isinstance(result.exception, InputError)
    assert "--sealed-effect heave, not stribeck" in str(result.exception)
