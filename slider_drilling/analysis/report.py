"""The report of an analysis: its result as JSON, and the page that shows it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling import __version__
from slider_drilling.analysis.along_string import StringHistory
from slider_drilling.analysis.analyse import Analysis
from slider_drilling.analysis.friction_tables import (
    calibration_json,
    calibration_tables,
    friction_json,
    friction_table,
)
from slider_drilling.log.run_page import log_title
from slider_drilling.pages import Chart, Table
from slider_drilling.paper_studies.study import Study, curve, curve_chart
from slider_drilling.plain_names import plain_name
from slider_drilling.units import SI, Text, Units, sentence

SCHEMA = "slider_drilling/analysis/1"


def to_json(analysis: Analysis) -> dict[str, Any]:
    """Content of analysis.json, in SI units: null where the log does not determine a value; not_found says why."""
    return {
        "schema": SCHEMA,
        "version": __version__,
        "log": analysis.log.source,
        "friction": None if analysis.fit is None else friction_json(analysis.fit.intervals),
        "driller_weights": calibration_json(analysis.calibration),
        "extra_friction": _bed(analysis),
        "fit": _fit(analysis),
        "breakover_torque": _breakover(analysis),
        "rocking": _rocking(analysis),
        "axial_friction": _axial(analysis),
        "weight_transfer": _transfer(analysis),
        "zones": [
            {"time": t, "rocked_to": z.rocked_to, "reactive_from": z.reactive_from, "static_length": z.static_length}
            for t, z in analysis.zones
        ],
        "along_the_string": _along(analysis.rocked),
        "not_found": [str(text) for text in analysis.undetermined],
        "notes": [str(text) for text in _notes(analysis)],
    }


def _bed(analysis: Analysis) -> dict[str, Any] | None:
    if analysis.fit is None or analysis.fit.bed is None:
        return None
    bed = analysis.fit.bed
    return {
        "from": float(bed.top), "to": float(bed.bottom), "factor": bed.factor,
        "factor_interval": list(bed.factor_interval),
    }  # fmt: skip


def _fit(analysis: Analysis) -> dict[str, Any] | None:
    if analysis.fit is None:
        return None
    fitted, given = analysis.fit.rig, analysis.rig
    assert given is not None
    return {
        "channels": list(analysis.fit.channels),
        "rms": analysis.fit.rms,
        "rms_with_rig_file": analysis.fit.rms_before,
        "start_twist": analysis.fit.start.twist,
        "slack": fitted.effects.top_drive_backlash.angle,
        "bit_aggressiveness": fitted.bit.aggressiveness,
        "torsional_damping": fitted.string.torsional_damping,
        "extra_torsional_compliance": fitted.effects.torsional_compliance.extra,
    }


def _breakover(analysis: Analysis) -> dict[str, Any]:
    broke = analysis.breakover
    return {
        "measured": None if broke is None else {"peak": broke.peak, "steady": broke.steady, "at": broke.at},
        "largest_in_log": float(np.abs(analysis.torque).max()),
        "to_turn_the_whole_string": None if analysis.rocked is None else analysis.rocked.turning_torque,
    }


def _rocking(analysis: Analysis) -> dict[str, Any] | None:
    if not analysis.cycles:
        return None
    work = np.array([cycle.work for cycle in analysis.cycles])
    return {
        "cycles": len(analysis.cycles),
        "period": float(np.median([c.end - c.start for c in analysis.cycles])),
        "swing": float(np.median([c.swing for c in analysis.cycles])),
        "friction_work_per_cycle": {
            "median": float(np.median(work)), "lowest": float(work.min()), "highest": float(work.max()),
        },
        "clockwise_torque": float(np.median([c.clockwise_torque for c in analysis.cycles])),
        "counter_torque": float(np.median([c.counter_torque for c in analysis.cycles])),
    }  # fmt: skip


def _second_half(history: StringHistory) -> np.ndarray:
    return history.time > 0.5 * (history.time[0] + history.time[-1])


def _axial(analysis: Analysis) -> dict[str, Any] | None:
    if analysis.rocked is None or analysis.still is None:
        return None
    result = {}
    for name, history in (("with_rocking", analysis.rocked), ("without_rocking", analysis.still)):
        half = _second_half(history)
        result[name] = {
            "mean": float(np.mean(history.axial_friction[half])),
            "coulomb": float(np.mean(history.coulomb_friction[half])),
            "over_coulomb": float(np.mean(history.axial_friction[half]) / np.mean(history.coulomb_friction[half])),
        }
    return result


def _transfer(analysis: Analysis) -> dict[str, Any] | None:
    if analysis.rocked is None or analysis.still is None:
        return None
    result = {}
    for name, history in (("with_rocking", analysis.rocked), ("without_rocking", analysis.still)):
        half = _second_half(history)
        share = history.weight_transfer[half]
        result[name] = {
            "weight_on_bit_mean": float(np.mean(history.weight_on_bit[half])),
            "weight_on_bit_spread": float(np.std(history.weight_on_bit[half])),
            "share_reaching_the_bit": float(np.nanmean(share)) if np.any(np.isfinite(share)) else None,
        }
    return result


def _along(history: StringHistory | None) -> dict[str, list[float]] | None:
    if history is None:
        return None
    half = _second_half(history)
    return {
        "measured_depth": history.measured_depth.tolist(),
        "friction_coefficient": np.mean(history.friction_coefficient[half], axis=0).round(6).tolist(),
        "beta_v": np.mean(history.beta_v[half], axis=0).round(6).tolist(),
        "rotation_swing": np.ptp(history.rotation[half], axis=0).tolist(),
    }


def analysis_study(analysis: Analysis, units: Units = SI) -> Study:
    """The page of an analysis: tables (in these units), figures, and what the log does not determine."""
    return Study(
        name="analysis",
        about="Friction",
        title=log_title(analysis.log),
        settings={
            "log": Path(analysis.log.source).name,
            "samples": analysis.time.size,
            "length_s": float(np.ptp(analysis.time)),
        },
        figures=(*_surface_figures(analysis), *_string_figures(analysis)),
        claims=(),
        notes=tuple(sentence("Not found: ", reason, ".") for reason in analysis.undetermined)
        + tuple(sentence("Note: ", text, ".") for text in _notes(analysis)),
        tables=_tables(analysis, units),
    )


def _notes(analysis: Analysis) -> tuple[Text, ...]:
    """What the reader of the log, and the reconstruction of its inputs, say."""
    fit, calibration = analysis.fit, analysis.calibration
    return (*analysis.log.notes, *(fit.inputs.assumptions if fit else ()), *(calibration.notes if calibration else ()))


def _tables(analysis: Analysis, units: Units) -> tuple[Table, ...]:
    tables = []
    if analysis.fit is not None:
        tables.append(friction_table(analysis.fit.intervals, "Apparent friction", units))
    if analysis.calibration is not None:
        tables += calibration_tables(analysis.calibration, units)
    results = (*_torque_rows(analysis, units), *_axial_rows(analysis, units), *_bed_rows(analysis, units))
    tables.append(Table(("", ""), results, "Results"))
    return tuple(tables)


def _torque_rows(analysis: Analysis, units: Units) -> list[tuple[str, str]]:
    rows = [("largest surface torque in the log", units.format(np.abs(analysis.torque).max() / 1e3, "kN m"))]
    if analysis.breakover is not None:
        peak, steady = (
            units.format(value / 1e3, "kN m") for value in (analysis.breakover.peak, analysis.breakover.steady)
        )
        value = f"{peak}, then {steady}"
        rows.append(("breakover torque, measured", value))
    if analysis.rocked is not None:
        rows.append(("torque that turns the whole string", units.format(analysis.rocked.turning_torque / 1e3, "kN m")))
    rocking = _rocking(analysis)
    if rocking is not None:
        low, middle, high = (rocking["friction_work_per_cycle"][key] / 1e3 for key in ("lowest", "median", "highest"))
        value = f"{units.format(middle, 'kJ')} ({units.format_range(low, high, 'kJ')})"
        value += f" in {rocking['cycles']} cycles of {rocking['period']:.1f} s"
        rows.append(("friction work per rocking cycle", value))
    return rows


def _axial_rows(analysis: Analysis, units: Units) -> list[tuple[str, str]]:
    axial, transfer = _axial(analysis), _transfer(analysis)
    if axial is None or transfer is None:
        return []
    rows = []
    for name in ("with_rocking", "without_rocking"):
        words, share = plain_name(name), transfer[name]["share_reaching_the_bit"]
        friction = f"{units.format(axial[name]['mean'] / 1e3, 'kN')}, {axial[name]['over_coulomb']:.3f} of Coulomb"
        reaches = "no weight let down" if share is None else f"{100 * share:.0f} % of the weight let down"
        rows.append((f"axial friction {words}", friction))
        weight = units.format(transfer[name]["weight_on_bit_mean"] / 1e3, "kN")
        rows.append((f"weight on bit {words}", f"{weight}, {reaches}"))
    return rows


def _bed_rows(analysis: Analysis, units: Units) -> list[tuple[str, str]]:
    bed = _bed(analysis)
    if bed is None:
        return []
    low, high = bed["factor_interval"]
    place = f"extra friction from {units.format_range(bed['from'], bed['to'], 'm', 4)}"
    return [(place, f"times {bed['factor']:.2f} ({low:.2f} to {high:.2f})")]


def _surface_figures(analysis: Analysis) -> tuple[Chart, ...]:
    figures = [curve_chart("Torque-angle loop", "top-drive angle, rad", "surface torque, kN m",
                     (curve("loop", analysis.angle, analysis.torque / 1e3),))]  # fmt: skip
    if analysis.cycles:
        middle = [0.5 * (c.start + c.end) for c in analysis.cycles]
        figures.append(curve_chart("Friction work per rocking cycle", "time, s", "work, kJ",
                             (curve("work", middle, [c.work / 1e3 for c in analysis.cycles]),)))  # fmt: skip
    return tuple(figures)


def _string_figures(analysis: Analysis) -> tuple[Chart, ...]:
    history = analysis.rocked
    if history is None:
        return ()
    along = _along(history)
    assert along is not None
    depth = along["measured_depth"]
    figures = [
        curve_chart("Friction coefficient along the string (second half of the log)", "friction coefficient",
              "measured depth, m", (curve("mean", along["friction_coefficient"], depth),), depth_down=True),
        curve_chart("Direction of slip along the string: 0 along the hole, 90 around it", "direction of slip, deg",
              "measured depth, m", (curve("mean", np.degrees(along["beta_v"]), depth),), depth_down=True),
    ]  # fmt: skip
    if analysis.zones:
        time = [t for t, _ in analysis.zones]
        figures.append(curve_chart("Three zones: rocked above, turned by the reactive torque below, static between",
                             "time, s",
                             "measured depth, m", (curve("rocked to", time, [z.rocked_to for _, z in analysis.zones]),
                                                   curve("reactive from", time,
                                                        [z.reactive_from for _, z in analysis.zones])),
                             depth_down=True))  # fmt: skip
    if analysis.still is not None:
        figures += [
            curve_chart("Axial friction", "time, s", "axial friction, kN", (
                curve("with rocking", history.time, history.axial_friction / 1e3),
                curve("without rocking", analysis.still.time, analysis.still.axial_friction / 1e3),
                curve("Coulomb", history.time, history.coulomb_friction / 1e3, True))),
            curve_chart("Weight on bit", "time, s", "weight on bit, kN", (
                curve("with rocking", history.time, history.weight_on_bit / 1e3),
                curve("without rocking", analysis.still.time, analysis.still.weight_on_bit / 1e3))),
        ]  # fmt: skip
    return tuple(figures)
