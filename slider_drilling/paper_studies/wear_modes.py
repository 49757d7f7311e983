"""Study: the asperity wear-mode diagram (paper Fig. 8) and the effective attack angle (eq. 6)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from slider_drilling.contact import (
    PAPER,
    WearMode,
    effective_attack_angle,
    friction_coefficient,
    friction_coefficient_of_direction,
    wear_mode,
)
from slider_drilling.pages import Chart, HeatMap
from slider_drilling.paper_studies.study import Claim, Study, curve, curve_chart

MODES = ("ploughing", "wedge formation", "cutting", "no steady solution")


def study() -> Study:
    """Regimes and friction over shear factor and attack angle; friction of the paper's asperity by direction."""
    shear = np.linspace(0.0, 0.99, 199, dtype=np.float64)
    angle = np.radians(np.linspace(0.5, 89.5, 179, dtype=np.float64))
    mode = wear_mode(shear[None, :], angle[:, None])
    solved = np.where(mode == WearMode.NO_STEADY_SOLUTION, 0.0, shear[None, :])
    friction = friction_coefficient(solved, angle[:, None])
    friction = np.where((mode == WearMode.NO_STEADY_SOLUTION) | (friction > 2.0), math.nan, friction)
    beta_v = np.radians(np.linspace(0.0, 90.0, 181, dtype=np.float64))
    return Study(
        name="wear_modes",
        title="Wear modes of an asperity",
        settings={
            "contact": "paper section 4, f = 0.1, chi = pi",
            "shear_factor": "0 to 0.99",
            "attack_angle_deg": "0.5 to 89.5",
        },
        figures=_figures(friction, shear, angle, mode, beta_v),
        claims=(_three_regimes(mode), _meeting(), _direction(beta_v)),
        notes=(
            "The paper gives neither f nor chi. f = 0.1 and chi = pi put the friction coefficient in the "
            "field's range.",
        ),
    )


def _figures(
    friction: np.ndarray, shear: np.ndarray, angle: np.ndarray, mode: np.ndarray, beta_v: np.ndarray
) -> tuple[Chart | HeatMap, ...]:
    axes = ("shear factor f", "attack angle, deg")
    grid = (shear, np.degrees(angle))
    slip = np.degrees(beta_v)
    attack_angles = [
        curve(f"chi = {label}", slip, np.degrees(effective_attack_angle(replace(PAPER.asperity, shape_factor=chi),
                                                                        beta_v)))
        for label, chi in (("1", 1.0), ("pi", math.pi))
    ]  # fmt: skip
    coefficients = [
        curve(f"f = {f:g}", slip, friction_coefficient_of_direction(replace(PAPER, shear_factor=f), beta_v))
        for f in (0.0, 0.1, 0.2, 0.3)
    ]
    return (
        HeatMap("Regime (Fig. 8)", *axes, "regime", *grid, mode.astype(float), MODES),
        HeatMap("Friction coefficient, up to 2", *axes, "mu", *grid, friction),
        curve_chart("Attack angle of the paper's asperity (eq. 6)", "angle of slip, deg", "effective attack angle, deg",
                    attack_angles),
        curve_chart("Friction of the paper's asperity (chi = pi)", "angle of slip, deg", "friction coefficient",
                    coefficients),
    )  # fmt: skip


def _three_regimes(mode: np.ndarray) -> Claim:
    shares = {name: round(float(np.mean(mode == k)), 4) for k, name in enumerate(MODES)}
    return Claim(
        "Shear factor and attack angle divide into three regimes: ploughing, wedge formation, cutting.",
        "section 3.3.1, Fig. 8",
        {"share_of_the_diagram": shares},
        all(shares[name] > 0.0 for name in MODES[:3]),
        ""
        if shares[MODES[3]] == 0.0
        else "All three exist; they do not fill the diagram: between ploughing and cutting eq. 4 has no positive "
        "denominator at high f, where no steady wedge exists.",
    )


def _meeting() -> Claim:
    gaps = {}
    for f in (0.1, 0.3, 0.5):
        low, high = 0.01, 1.5
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if wear_mode(f, middle) == WearMode.PLOUGHING else (low, middle)
        gaps[f"f={f:g}"] = abs(float(friction_coefficient(f, high) - friction_coefficient(f, low)))
    return Claim(
        "Ploughing and wedge formation meet with the same friction coefficient.",
        "eq. 2-5, as corrected",
        {"jump": gaps},
        max(gaps.values()) < 1e-9,
    )


def _direction(beta_v: np.ndarray) -> Claim:
    angle, friction = effective_attack_angle(PAPER.asperity, beta_v), friction_coefficient_of_direction(PAPER, beta_v)
    return Claim(
        "The angle between slip and the asperity's axis sets the attack angle, and so the friction coefficient.",
        "eq. 6, section 5.2.3",
        {
            "attack_angle_deg": [round(float(np.degrees(angle[k])), 3) for k in (0, -1)],
            "friction_coefficient": [round(float(friction[k]), 4) for k in (0, -1)],
            "beta_v_deg": [0, 90],
        },
        bool(np.all(np.diff(angle) < 0.0) and np.all(np.diff(friction) < 0.0)),
    )
