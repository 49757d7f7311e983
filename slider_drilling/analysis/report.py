"""An analysis on paper: the findings as plain data, and the page that shows them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling import __version__
from slider_drilling.analysis.along_string import StringHistory
from slider_drilling.analysis.analyse import Analysis
from slider_drilling.log.run_page import log_title
from slider_drilling.pages import Chart, Table
from slider_drilling.paper_studies.study import Study, curve, curve_chart
from slider_drilling.units import SI, Units

SCHEMA = "slider_drilling/analysis/1"


def to_json(found: Analysis) -> dict[str, Any]:
    """What analysis.json holds: SI units, rad; null where the log does not tell, with not_found saying why."""
    return {
        "schema": SCHEMA,
        "version": __version__,
        "log": found.log.source,
        "friction": _friction(found),
        "extra_friction": _bed(found),
        "fit": _fit(found),
        "breakover_torque": _breakover(found),
        "rocking": _rocking(found),
        "axial_friction": _axial(found),
        "weight_transfer": _transfer(found),
        "zones": [
            {"time": t, "rocked_to": z.rocked_to, "reactive_from": z.reactive_from, "static_length": z.static_length}
            for t, z in found.zones
        ],
        "along_the_string": _along(found.rocked),
        "not_found": list(found.undetermined),
        "notes": [*found.log.notes, *(found.fit.inputs.assumptions if found.fit else ())],
    }


def _friction(found: Analysis) -> list[dict[str, Any]] | None:
    if found.fit is None:
        return None
    return [
        {
            "hole": row.kind, "from": row.top, "to": row.bottom, "factor": row.factor,
            "factor_interval": list(row.factor_interval), "factor_in_rig_file": row.in_rig_file,
            "friction_coefficient_along": row.axial, "friction_coefficient_around": row.tangential,
            "determined": row.is_determined,
        }
        for row in found.fit.intervals
    ]  # fmt: skip


def _bed(found: Analysis) -> dict[str, Any] | None:
    if found.fit is None or found.fit.bed is None:
        return None
    bed = found.fit.bed
    return {
        "from": float(bed.top), "to": float(bed.bottom), "factor": bed.factor,
        "factor_interval": list(bed.factor_interval),
    }  # fmt: skip


def _fit(found: Analysis) -> dict[str, Any] | None:
    if found.fit is None:
        return None
    fitted, given = found.fit.rig, found.rig
    assert given is not None
    return {
        "channels": list(found.fit.channels),
        "rms": found.fit.rms,
        "rms_with_rig_file": found.fit.rms_before,
        "start_twist": found.fit.start.twist,
        "slack": fitted.effects.top_drive_backlash.angle,
        "bit_aggressiveness": fitted.bit.aggressiveness,
        "torsional_damping": fitted.string.torsional_damping,
        "extra_torsional_compliance": fitted.effects.torsional_compliance.extra,
    }


def _breakover(found: Analysis) -> dict[str, Any]:
    broke = found.breakover
    return {
        "measured": None if broke is None else {"peak": broke.peak, "steady": broke.steady, "at": broke.at},
        "largest_in_log": float(np.abs(found.torque).max()),
        "to_turn_the_whole_string": None if found.rocked is None else found.rocked.turning_torque,
    }


def _rocking(found: Analysis) -> dict[str, Any] | None:
    if not found.cycles:
        return None
    work = np.array([cycle.work for cycle in found.cycles])
    return {
        "cycles": len(found.cycles),
        "period": float(np.median([c.end - c.start for c in found.cycles])),
        "swing": float(np.median([c.swing for c in found.cycles])),
        "friction_work_per_cycle": {
            "median": float(np.median(work)), "lowest": float(work.min()), "highest": float(work.max()),
        },
        "clockwise_torque": float(np.median([c.clockwise_torque for c in found.cycles])),
        "counter_torque": float(np.median([c.counter_torque for c in found.cycles])),
    }  # fmt: skip


def _second_half(history: StringHistory) -> np.ndarray:
    return history.time > 0.5 * (history.time[0] + history.time[-1])


def _axial(found: Analysis) -> dict[str, Any] | None:
    if found.rocked is None or found.still is None:
        return None
    result = {}
    for name, history in (("with_rocking", found.rocked), ("without_rocking", found.still)):
        half = _second_half(history)
        result[name] = {
            "mean": float(np.mean(history.axial_friction[half])),
            "coulomb": float(np.mean(history.coulomb_friction[half])),
            "over_coulomb": float(np.mean(history.axial_friction[half]) / np.mean(history.coulomb_friction[half])),
        }
    return result


def _transfer(found: Analysis) -> dict[str, Any] | None:
    if found.rocked is None or found.still is None:
        return None
    result = {}
    for name, history in (("with_rocking", found.rocked), ("without_rocking", found.still)):
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


def analysis_study(found: Analysis, units: Units = SI) -> Study:
    """The page of an analysis: tables, figures and what was not found; the tables' texts in these units."""
    return Study(
        name="analysis",
        about="Friction",
        title=log_title(found.log, units),
        settings={
            "log": Path(found.log.source).name,
            "samples": found.time.size,
            "length_s": float(np.ptp(found.time)),
        },
        figures=(*_surface_figures(found), *_string_figures(found)),
        claims=(),
        notes=tuple(f"Not found: {sentence}." for sentence in found.undetermined)
        + tuple(
            f"Note: {sentence}."
            for sentence in (*found.log.notes, *(found.fit.inputs.assumptions if found.fit else ()))
        ),
        tables=_tables(found, units),
    )


def _tables(found: Analysis, units: Units) -> tuple[Table, ...]:
    tables = []
    if found.fit is not None:
        header = ("hole", "friction factor (95 %)", "in the rig file", "coefficient along", "coefficient around")
        rows = []
        for row in found.fit.intervals:
            low, high = row.factor_interval
            factor = f"{row.factor:.3f} ({low:.3f} to {high:.3f})" + ("" if row.is_determined else ", not determined")
            hole = f"{row.kind}, {units.format_range(row.top, row.bottom, 'm', 4)}"
            rows.append((hole, factor, f"{row.in_rig_file:.3f}", f"{row.axial:.3f}", f"{row.tangential:.3f}"))
        tables.append(Table(header, tuple(rows), "Apparent friction"))
    said = (*_torque_rows(found, units), *_axial_rows(found, units), *_bed_rows(found, units))
    tables.append(Table(("", ""), said, "Results"))
    return tuple(tables)


def _torque_rows(found: Analysis, units: Units) -> list[tuple[str, str]]:
    rows = [("largest surface torque in the log", units.format(np.abs(found.torque).max() / 1e3, "kN m"))]
    if found.breakover is not None:
        peak, steady = (units.format(one / 1e3, "kN m") for one in (found.breakover.peak, found.breakover.steady))
        value = f"{peak}, then {steady}"
        rows.append(("breakover torque, measured", value))
    if found.rocked is not None:
        rows.append(("torque that turns the whole string", units.format(found.rocked.turning_torque / 1e3, "kN m")))
    rocking = _rocking(found)
    if rocking is not None:
        low, middle, high = (rocking["friction_work_per_cycle"][key] / 1e3 for key in ("lowest", "median", "highest"))
        value = f"{units.format(middle, 'kJ')} ({units.format_range(low, high, 'kJ')})"
        value += f" in {rocking['cycles']} cycles of {rocking['period']:.1f} s"
        rows.append(("friction work per rocking cycle", value))
    return rows


def _axial_rows(found: Analysis, units: Units) -> list[tuple[str, str]]:
    axial, transfer = _axial(found), _transfer(found)
    if axial is None or transfer is None:
        return []
    rows = []
    for name in ("with_rocking", "without_rocking"):
        words, share = name.replace("_", " "), transfer[name]["share_reaching_the_bit"]
        friction = f"{units.format(axial[name]['mean'] / 1e3, 'kN')}, {axial[name]['over_coulomb']:.3f} of Coulomb"
        reaches = "no weight let down" if share is None else f"{100 * share:.0f} % of the weight let down"
        rows.append((f"axial friction {words}", friction))
        weight = units.format(transfer[name]["weight_on_bit_mean"] / 1e3, "kN")
        rows.append((f"weight on bit {words}", f"{weight}, {reaches}"))
    return rows


def _bed_rows(found: Analysis, units: Units) -> list[tuple[str, str]]:
    bed = _bed(found)
    if bed is None:
        return []
    low, high = bed["factor_interval"]
    place = f"extra friction from {units.format_range(bed['from'], bed['to'], 'm', 4)}"
    return [(place, f"times {bed['factor']:.2f} ({low:.2f} to {high:.2f})")]


def _surface_figures(found: Analysis) -> tuple[Chart, ...]:
    figures = [curve_chart("Torque-angle loop", "top-drive angle, rad", "surface torque, kN m",
                     (curve("loop", found.angle, found.torque / 1e3),))]  # fmt: skip
    if found.cycles:
        middle = [0.5 * (c.start + c.end) for c in found.cycles]
        figures.append(curve_chart("Friction work per rocking cycle", "time, s", "work, kJ",
                             (curve("work", middle, [c.work / 1e3 for c in found.cycles]),)))  # fmt: skip
    return tuple(figures)


def _string_figures(found: Analysis) -> tuple[Chart, ...]:
    history = found.rocked
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
    if found.zones:
        time = [t for t, _ in found.zones]
        figures.append(curve_chart("Three zones: rocked above, turned by the reactive torque below, static between",
                             "time, s",
                             "measured depth, m", (curve("rocked to", time, [z.rocked_to for _, z in found.zones]),
                                                   curve("reactive from", time,
                                                        [z.reactive_from for _, z in found.zones])),
                             depth_down=True))  # fmt: skip
    if found.still is not None:
        figures += [
            curve_chart("Axial friction", "time, s", "axial friction, kN", (
                curve("with rocking", history.time, history.axial_friction / 1e3),
                curve("without rocking", found.still.time, found.still.axial_friction / 1e3),
                curve("Coulomb", history.time, history.coulomb_friction / 1e3, True))),
            curve_chart("Weight on bit", "time, s", "weight on bit, kN", (
                curve("with rocking", history.time, history.weight_on_bit / 1e3),
                curve("without rocking", found.still.time, found.still.weight_on_bit / 1e3))),
        ]  # fmt: skip
    return tuple(figures)
