"""Which rig file a diagnosis used, and what a reader must know about it."""

from __future__ import annotations

import dataclasses
from dataclasses import replace

from slider_drilling.diagnosis.rig_source import RigSource, find_rig_source, rig_remarks
from slider_drilling.effects import CuttingsBed, Effects
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import RigLog
from slider_drilling.rig import dump_rig, load_rig

RIG = load_rig(installed_file("config/rig.example.yaml"))
BED = replace(RIG, effects=dataclasses.replace(Effects(), cuttings_bed=CuttingsBed(2.0, 2400.0, 2600.0)))
ATTACHED = RigLog("d/run.mcap", 0, dump_rig(BED), "d/run.mcap: rig.yaml", {"recorded_by": "slider-drilling run"})


def test_attached_rig_file_is_named_with_its_recorder():
    source = find_rig_source([ATTACHED], BED)
    assert source == RigSource("rig.yaml in run.mcap", "attached", "d/run.mcap")
    attached, switched_on = rig_remarks(source, [ATTACHED], BED)
    assert "(slider-drilling run)" in attached
    assert "cuttings_bed" in switched_on
    assert "--rig" in switched_on


def test_given_rig_file_has_its_path():
    given = replace(ATTACHED, rig_source="e/own.yaml")
    assert find_rig_source([given], BED) == RigSource("own.yaml", "given", "e/own.yaml")
    assert find_rig_source([given], RIG) == RigSource("the rig given", "given", None)
    assert rig_remarks(find_rig_source([given], RIG), [given], RIG) == []
