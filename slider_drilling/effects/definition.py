"""What the project knows about one effect: its law, its site, its parameters, its sizes and its search."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from slider_drilling.plain_names import plain_name
from slider_drilling.units import Text, format_number

Values = Mapping[str, float]
"""Parameters of one effect by their keys in the rig file."""


@dataclass(frozen=True)
class FitParameter:
    """One parameter that a fit of the effect frees.

    Attributes:
        key: Key in the effect's section of the rig file. `EffectDefinition.to_rig_file` converts any other key.
        lower: Lower bound of the fit.
        upper: Upper bound of the fit.
        step: Typical change, the unit of the optimiser's steps.
        neutral: Value without the effect; None for the default of the rig file.
        unit: None for the unit of the rig file.
        equivalents: Values that the log cannot distinguish, such as the aliases of a frequency above half the sampling
            rate.
    """

    key: str
    lower: float
    upper: float
    step: float
    neutral: float | None = None
    unit: str | None = None
    equivalents: tuple[float, ...] = ()


@dataclass(frozen=True)
class SearchInputs:
    """What the search for an effect takes from the logs and the rig.

    Attributes:
        length: Length of the string, m.
        duration: Duration of the longest log, s.
        wave_periods: Periods in s at which the search for heave starts, the peaks of the log's spectrum: over 400 s a
            period that is wrong by one per cent loses the phase of the wave.
        tool_frequencies: Frequencies in Hz that a tool in the string can have by the log's spectrum; empty where the
            spectrum shows none.
        torque_interval: Time in s between two samples of torque.
    """

    length: float
    duration: float
    wave_periods: Sequence[float] = ()
    tool_frequencies: Sequence[float] = ()
    torque_interval: float = 0.0


@dataclass(frozen=True)
class Search:
    """How a diagnosis looks for the effect, see `slider_drilling.gap.model.Effect`.

    Attributes:
        parameters: The amplitude first, then the parameters of its shape.
        scan: Values of all parameters at which the score test probes the effect and from which fits start.
        physical: Range of the amplitude that the effect's name stands for.
        fidelity: The cheapest simulation that shows the effect, 0 for the coarsest mesh.
    """

    parameters: tuple[FitParameter, ...]
    scan: tuple[tuple[float, ...], ...]
    physical: tuple[float, float] = (-np.inf, np.inf)
    fidelity: int = 0


@dataclass(frozen=True)
class Sizes:
    """Parameters of the effect at three sizes.

    Attributes:
        usual: A usual amount; the amplitude is the first key.
        small: What a rig has on a good day.
        large: What a rig has on a bad day.
        material: Smallest change from neutral that an engineer acts on, by key; one key that reaches it is enough. What
            a fit finds below it is not named.
        length_shares: Keys whose values are shares of the string's length instead of m.
    """

    usual: Values
    small: Values
    large: Values
    material: Values
    length_shares: tuple[str, ...] = ()

    def values(self, size: str, length: float) -> dict[str, float]:
        """Returns the parameters for the rig file.

        Args:
            size: ``usual``, ``small`` or ``large``.
            length: Length of the string, m.
        """
        values: Values = getattr(self, size)
        return {key: value * length if key in self.length_shares else value for key, value in values.items()}


Draw = Callable[[np.random.Generator, float, float], dict[str, float]]
"""(generator, length of the string in m, duration of the run in s) -> parameters of a random rig."""


def _visible_in_any_log(channels: Sequence[str], off_bottom: bool) -> bool:
    return True


@dataclass(frozen=True)
class EffectDefinition:
    """One effect of the catalogue. The plant reads its section of the rig file (`slider_drilling.drillstring`).

    Attributes:
        name: Key of the effect in the rig file's ``effects`` section.
        site: Where it acts: contact, string, top_drive, draw_works, motor, bit or sensor.
        section: Dataclass of its parameters with unit, default and range. The defaults are neutral.
        law: Formula, with the parameters under their keys.
        search: Returns how a diagnosis looks for it.
        sizes: Parameters at usual sizes.
        phrase: What the effect means with these parameters: one clause that begins with a capital. The amplitude must
            be there; other parameters are mentioned if given.
        draw: Draws its parameters for a random rig.
        nonphysical: What an amplitude outside `Search.physical` would mean.
        visible: Whether logs with these channels, on or off bottom, can show it at all.
        per_run: Keys of the fit of which each of several runs has its own value, such as when something happened in it;
            and what the search adds to it in later runs.
        during_run: Whether it begins or grows with the time since the run began: another run does not share it.
        to_rig_file: Converts fitted values to those of the rig file, given the string's length in m; None where they
            are the same.
        reported: Returns the parameters whose intervals are reported where `search` frees other ones.
    """

    name: str
    site: str
    section: type
    law: str
    search: Callable[[SearchInputs], Search]
    sizes: Sizes
    phrase: Callable[[Values], Text]
    draw: Draw
    nonphysical: str = "its opposite"
    visible: Callable[[Sequence[str], bool], bool] = _visible_in_any_log
    per_run: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    during_run: bool = False
    to_rig_file: Callable[[Values, float], Values] | None = None
    reported: Callable[[float], tuple[FitParameter, ...]] = field(default=lambda length: ())

    @property
    def title(self) -> str:
        """The name in words, such as "top drive backlash"."""
        return plain_name(self.name)

    def neutral(self, parameter: FitParameter) -> float:
        """Returns the value of a fit parameter without the effect."""
        if parameter.neutral is not None:
            return parameter.neutral
        default: float = self._field(parameter.key).default
        return default

    def unit(self, parameter: FitParameter) -> str:
        """Returns the unit of a fit parameter."""
        if parameter.unit is not None:
            return parameter.unit
        unit: str = self._field(parameter.key).metadata["range"].unit
        return unit

    def _field(self, key: str) -> Any:
        return next(field for field in fields(self.section) if field.name == key)


def percent(share: float) -> str:
    """Returns the magnitude of a share for a phrase, such as "12 %"."""
    return f"{format_number(100.0 * abs(share), 2)} %"
