"""Free forms of the sensors: readings that drift, or that are off by a smooth function of something measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.evidence.linear_form import LinearForm
from slider_drilling.gap.model import Array, HasFreeForms
from slider_drilling.gap.problem.problem import Piece, Problem
from slider_drilling.gap.selection.state import FittedModel
from slider_drilling.plain_names import plain_name

# Coefficients of a curve over a sensor's reading.
_KNOTS = 8


@dataclass(frozen=True)
class Drift:
    """An error of a sensor's reading that grows evenly over a run; its values at both ends are fitted."""

    site: str
    description: str
    piece: Piece

    @property
    def rows(self) -> Array:
        """(2, n) change of the reading by its value at the beginning and at the end."""
        time = self.piece.channel.time
        passed = (time - time[0]) / max(float(time[-1] - time[0]), 1e-9)
        return np.stack([1.0 - passed, passed])


def sensor_curves(model: FittedModel) -> list[LinearForm]:
    """Readings that are off by a smooth function of time, of their level, of the excitation, or of its rate."""
    problem, forms = model.problem, []
    for piece in _often_sampled(problem):
        run = problem.model.runs[piece.run]
        command = np.interp(piece.channel.time, run.time, run.excitation)
        rate = np.interp(piece.channel.time, run.time, np.gradient(run.excitation, run.time))
        per_second = "1/s" if run.command_unit == "-" else f"{run.command_unit}/s"
        level = model.fit.simulated[piece.rows] * piece.noise
        site = _sensor_site(problem, piece)
        for over, values, unit in (
            ("time", piece.channel.time, "s"), ("its own level", level, piece.channel.unit),
            (run.command, command, run.command_unit), (f"the rate of {run.command}", rate, per_second),
        ):  # fmt: skip
            forms.append(_sensor_curve(problem, piece, site, over, values, unit))
    return forms


def sensor_drifts(model: FittedModel) -> list[Drift]:
    """Readings that drift. A drift biases the nuisance, so it is fitted with it, not solved for around its values."""
    problem, off = model.problem, "off by an amount that drifts with time"
    return [
        Drift(_sensor_site(problem, piece), f"{_name_of(problem, piece)} {off}", piece)
        for piece in _often_sampled(problem)
    ]


def _often_sampled(problem: Problem) -> list[Piece]:
    """Pieces with enough samples for a curve."""
    return [piece for piece in problem.pieces if piece.channel.time.size >= 4 * _KNOTS]


def _sensor_site(problem: Problem, piece: Piece) -> str:
    model = problem.model
    return model.sensor_site(piece.name) if isinstance(model, HasFreeForms) else "sensor"


def _name_of(problem: Problem, piece: Piece) -> str:
    of_run = f" in run {piece.run + 1}" if len(problem.model.runs) > 1 else ""
    return f"{plain_name(piece.name)}{of_run}"


def _sensor_curve(problem: Problem, piece: Piece, site: str, over: str, values: Array, unit: str) -> LinearForm:
    """A reading that is off by a piecewise linear function of given values (n,)."""
    knots = np.linspace(float(values.min()), max(float(values.max()), float(values.min()) + 1e-9), _KNOTS)
    rows = np.zeros((_KNOTS, problem.size))
    for index in range(_KNOTS):
        rows[index, piece.rows] = np.interp(values, knots, np.eye(_KNOTS)[index])
    description = f"{_name_of(problem, piece)} off by an amount that follows {over}"
    return LinearForm(site, description, None, knots, unit, piece.channel.unit, rows, piece.name)
