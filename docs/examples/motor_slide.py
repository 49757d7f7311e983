"""The gap engine on a machine that has nothing to do with drilling: a motor pulls a carriage over a slide way.

The motor's position is the command, a spring joins it to the carriage, and the way rubs. The model that is
diagnosed knows Coulomb friction; the "real" slide also has friction that falls with speed, which is withheld. It also
says which test the slide would be asked for, before any log (`SlideProgrammes`).

    python docs/examples/motor_slide.py
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from slider_drilling.gap import Channel, Effect, LoggedRun, Manoeuvre, Parameter, SimulationOptions
from slider_drilling.gap.model import Array, Values

NOMINAL = {
    "stiffness": 20000.0,
    "friction": 30.0,
    "damping": 200.0,
    "stribeck_drop": 0.0,
    "stribeck_speed": 0.03,
    "backlash": 0.0,
    "viscous": 0.0,
    "force_bias": 0.0,
    "force_lag": 0.0,
}
MASS = 10.0
_STEP = 0.002
_BRISTLE = 0.0005

NUISANCE = (
    Parameter("stiffness", 20000.0, 8000.0, 50000.0, 1000.0, "N/m", spread=4000.0),
    Parameter("friction", 30.0, 5.0, 90.0, 2.0, "N", spread=10.0),
    Parameter("damping", 200.0, 0.0, 600.0, 20.0, "N s/m", spread=60.0),
)
EFFECTS = (
    Effect(
        "stribeck", "contact",
        (Parameter("stribeck_drop", 0.0, -0.9, 3.0, 0.1), Parameter("stribeck_speed", 0.03, 0.002, 0.5, 0.01, "m/s")),
        scan=((0.5, 0.01), (0.5, 0.03), (0.5, 0.1)), physical=(0.0, np.inf),
        nonphysical="friction that rises with speed",
    ),
    Effect(
        "backlash", "drive", (Parameter("backlash", 0.0, 0.0, 0.02, 0.001, "m"),),
        scan=((0.001,), (0.003,), (0.008,)),
    ),
    Effect(
        "viscous", "contact", (Parameter("viscous", 0.0, 0.0, 9000.0, 300.0, "N s2/m2"),),
        scan=((500.0,), (1500.0,), (5000.0,)),
    ),
    Effect(
        "force_bias", "sensor", (Parameter("force_bias", 0.0, -30.0, 30.0, 1.0, "N"),),
        scan=((-3.0,), (3.0,), (10.0,)),
    ),
    Effect(
        "force_lag", "sensor", (Parameter("force_lag", 0.0, 0.0, 2.0, 0.05, "s"),),
        scan=((0.05,), (0.15,), (0.5,)),
    ),
)  # fmt: skip


@njit(cache=False)
def _integrate(command, parameters, force_out, position_out):  # type: ignore[no-untyped-def]
    for k in range(parameters.shape[0]):
        stiffness, friction, damping, drop, falling, backlash, viscous, bias, lag = parameters[k]
        position, speed, bristle, reading = command[0], 0.0, 0.0, 0.0
        for index in range(command.size):
            stretch = command[index] - position
            free = min(max(stretch, -0.5 * backlash), 0.5 * backlash)
            force = stiffness * (stretch - free)
            level = friction * (1.0 + drop * np.exp(-abs(speed) / falling))
            bristle = min(max(bristle + speed * _STEP, -_BRISTLE), _BRISTLE)
            drag = level * bristle / _BRISTLE + (damping + viscous * abs(speed)) * speed
            speed += _STEP * (force - drag) / MASS
            position += _STEP * speed
            reading += (force - reading) * _STEP / max(lag, _STEP)
            force_out[k, index], position_out[k, index] = reading + bias, position


def slide(time: Array, motor: Array, sets: Sequence[Values]) -> dict[str, Array]:
    """Motor force (K, n) N and carriage position (K, n) m at the times, for K parameter sets at once."""
    parameters = np.array([[values.get(name, default) for name, default in NOMINAL.items()] for values in sets])
    fine = np.arange(time[0], time[-1] + 0.5 * _STEP, _STEP)
    force, position = np.empty((2, len(sets), fine.size))
    _integrate(np.interp(fine, time, motor), parameters, force, position)
    rows = np.clip(np.round((time - time[0]) / _STEP).astype(int), 0, fine.size - 1)
    return {"force": force[:, rows], "position": position[:, rows]}


@dataclass(frozen=True)
class MotorSlide:
    """The model the engine sees."""

    runs: tuple[LoggedRun, ...]
    nuisance: tuple[Parameter, ...] = NUISANCE
    effects: tuple[Effect, ...] = EFFECTS

    def simulate(self, run: int, sets: Sequence[Values], options: SimulationOptions) -> Mapping[str, Array]:
        """See `slider_drilling.gap.model.Model`."""
        return slide(self.runs[run].time, self.runs[run].excitation, sets)

    @property
    def programme_duration(self) -> float:
        """See `slider_drilling.gap.model.HasProgrammes`."""
        return 60.0

    def programmes(self, duration: float) -> SlideProgrammes:
        """See `slider_drilling.gap.model.HasProgrammes`."""
        return SlideProgrammes(self, duration)


@dataclass(frozen=True)
class SlideProgrammes:
    """What the slide may be asked to do: two kinds of strokes with rests, within a force (`gap.model.Programmes`)."""

    model: MotorSlide
    duration: float
    largest_force: float = 250.0  # N, of the spring
    variables: tuple[Parameter, ...] = (
        Parameter("stroke_1", 0.05, 0.002, 0.1, 0.01, "m"), Parameter("speed_1", 0.025, 0.002, 0.4, 0.02, "m/s"),
        Parameter("rest_1", 0.0, 0.0, 5.0, 0.5, "s"), Parameter("stroke_2", 0.05, 0.002, 0.1, 0.01, "m"),
        Parameter("speed_2", 0.025, 0.002, 0.4, 0.02, "m/s"), Parameter("rest_2", 0.0, 0.0, 5.0, 0.5, "s"),
    )  # fmt: skip
    starts: tuple[Mapping[str, float], ...] = ({}, {"stroke_2": 0.02, "speed_2": 0.005, "rest_2": 1.0})

    @property
    def fixed(self) -> Mapping[str, Manoeuvre]:
        """Routine strokes."""
        return {"routine": self.programme({})}

    def programme(self, values: Values) -> Manoeuvre:
        """The first strokes in the first half, the second ones in the second."""
        number = {each.name: values.get(each.name, each.nominal) for each in self.variables}
        time = np.arange(int(self.duration * 20.0)) / 20.0
        half = time < 0.5 * self.duration
        first, second = (
            _strokes(time, number[f"stroke_{k}"], number[f"speed_{k}"], number[f"rest_{k}"]) for k in (1, 2)
        )
        # The second strokes begin where the first ones end: strokes start at 0, so wait there.
        motor = np.where(
            half, first * (time < _last_return(first, time, 0.5 * self.duration)), np.roll(second, half.sum())
        )
        channels = tuple(
            Channel(name, time, np.zeros_like(time), unit, declared_noise=noise)
            for name, unit, noise in (("force", "N", 1.0), ("position", "m", 2e-4))
        )
        run = LoggedRun("planned", time, motor, channels, command="the motor's position", command_unit="m")
        what = "; ".join(
            f"strokes of {1e3 * number[f'stroke_{k}']:.0f} mm at {1e3 * number[f'speed_{k}']:.0f} mm/s with rests of "
            f"{number[f'rest_{k}']:.1f} s" for k in (1, 2)
        )  # fmt: skip
        return Manoeuvre(what, number, MotorSlide((run,), self.model.nuisance, self.model.effects))

    def limit_use(self, manoeuvre: Manoeuvre, sets: Sequence[Values]) -> Array:
        """Largest force over the one allowed."""
        force = manoeuvre.model.simulate(0, sets, SimulationOptions())["force"]
        return np.asarray(np.max(np.abs(force), axis=1) / self.largest_force)


def _strokes(time: Array, stroke: float, speed: float, rest: float) -> Array:
    """Out and back, with a rest at each end."""
    phase = time % (2.0 * (stroke / speed + rest))
    back = stroke / speed + rest
    return np.clip(np.where(phase < back, speed * phase, stroke - speed * (phase - back)), 0.0, stroke)


def _last_return(motion: Array, time: Array, end: float) -> float:
    """The last time before the end at which the motion is at 0."""
    home = time[(time < end) & (motion < 1e-9)]
    return float(home[-1])


def motor_motion(duration: float = 60.0, rate: float = 20.0) -> tuple[Array, Array]:
    """Times s and motor position m: strokes of three speeds, with rests between."""
    time = np.arange(int(duration * rate)) / rate
    position = np.zeros_like(time)
    for share, period, stroke in ((0.0, 4.0, 0.05), (0.35, 2.0, 0.05), (0.7, 6.0, 0.03)):
        here = (time >= share * duration) & (time < (share + 0.3) * duration)
        phase = (time[here] - share * duration) / period
        position[here] = stroke * (1.0 - np.abs(2.0 * (phase % 1.0) - 1.0))
    return time, position


def record(truth: Values, seed: int = 0, duration: float = 60.0) -> LoggedRun:
    """A log of the "real" slide with these parameters, with sensor noise."""
    generator = np.random.default_rng(seed)
    time, motor = motor_motion(duration)
    real = slide(time, motor, [truth])
    return LoggedRun(
        "slide", time, motor,
        (
            Channel("force", time, real["force"][0] + generator.normal(0.0, 1.0, time.size), "N"),
            Channel("position", time, real["position"][0] + generator.normal(0.0, 2e-4, time.size), "m"),
        ),
        command="the motor's position", command_unit="m",
    )  # fmt: skip


if __name__ == "__main__":
    from slider_drilling.gap import explain
    from slider_drilling.gap.experiment_design.knowledge import before_any_log
    from slider_drilling.gap.experiment_design.plan import plan_run

    unlogged = MotorSlide(())
    plan = plan_run(before_any_log(unlogged), unlogged.programmes(60.0), evaluations=60)
    print(f"test: {plan.planned.manoeuvre.description}")
    routine = {each.name: each.size.amplitude for each in plan.baseline.effects}
    for power in plan.planned.prospect.effects:
        unit, size = power.shape.effect.parameters[0].unit, power.size.amplitude
        print(f"  {power.name:12s} shows from {size:.3g} {unit}, by routine from {routine[power.name]:.3g}")
    withheld = {"stiffness": 21500.0, "friction": 27.0, "damping": 220.0, "stribeck_drop": 0.5, "stribeck_speed": 0.04}
    answer = explain(MotorSlide((record(withheld),)))
    gap = f"E {answer.gap_calibrated:.2f} calibrated, {answer.gap_with_effects:.2f} with it"
    print(f"{answer.verdict}: {' and '.join(answer.effects)}, {gap}")
    for entry in answer.candidates:
        values = {p.name: round(entry.fitted.fit.values[p.name], 4) for p in entry.effect.parameters}
        print(f"  {entry.effect.name:12s} closes {entry.closed:6.2f} {'; '.join(entry.failures) or 'passed'}  {values}")
