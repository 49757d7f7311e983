"""The string as lumped elements (`model.md` section 3): masses at element middles, springs between them, the wall."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np

from slider_drilling.rig import Rig, StringSection
from slider_drilling.rig.parts import GRAVITY
from slider_drilling.wellbore.side_force import side_force_geometry
from slider_drilling.wellbore.well_path import Array, WellPath

_STEEL_DENSITY = 7850.0  # kg/m3


@dataclass(frozen=True)
class Mesh:
    """Geometry and section properties of the elements, each (n,), surface first.

    Attributes:
        top, bottom, middle: Measured depth, m.
        area, second_moment, polar_moment: m2 and m4, that give the stiffness in tension, bending and torsion.
        steel_area, steel_polar_moment: m2 and m4, that give mass and inertia with the string's density.
        given_weight: In air, N/m; 0 where `steel_area` gives it.
        outer_radius, clearance: m, where the string touches the wall; clearance is radial.
        cosine: Of the inclination, averaged so that the hanging weight is exact.
        sine: Of the inclination.
        vertical_curvature: d inclination / ds, rad/m.
        lateral_curvature: sin(inclination) d azimuth / ds, rad/m. These three give the side force of the element as a
            whole (see `side_force`).
    """

    top: Array
    bottom: Array
    area: Array
    second_moment: Array
    polar_moment: Array
    steel_area: Array
    steel_polar_moment: Array
    given_weight: Array
    outer_radius: Array
    clearance: Array
    cosine: Array
    sine: Array
    vertical_curvature: Array
    lateral_curvature: Array

    @property
    def length(self) -> Array:
        return self.bottom - self.top

    @property
    def middle(self) -> Array:
        return 0.5 * (self.top + self.bottom)

    @property
    def count(self) -> int:
        return len(self.top)


def build_mesh(rig: Rig, elements: int) -> Mesh:
    """A mesh of about ``elements`` elements of near-equal length, none of which straddles two sections."""
    # In a rig made in Python rows may be lists, which cannot be a cache's key.
    survey = tuple((depth, inclination, azimuth) for depth, inclination, azimuth in rig.well.survey)
    return _mesh(survey, tuple(rig.string.sections), rig.well.hole_diameter, elements)


@lru_cache(maxsize=16)
def _mesh(
    survey: tuple[tuple[float, float, float], ...],
    sections: tuple[StringSection, ...],
    hole_diameter: float,
    elements: int,
) -> Mesh:
    """The mesh shared by all rigs of a well and string; its arrays are read-only."""
    counts = _elements_per_section([section.length for section in sections], elements)
    edges = [0.0]
    for section, count in zip(sections, counts, strict=True):
        edges.extend(edges[-1] + section.length * (np.arange(count) + 1) / count)
    boundaries = np.asarray(edges)

    def of_section(values: Iterable[float]) -> Array:
        return np.repeat(list(values), counts)

    outer = of_section(section.outer_diameter for section in sections)
    inner = of_section(section.inner_diameter for section in sections)
    contact = of_section(section.contact_diameter for section in sections)
    quartic, area = math.pi / 64.0 * (outer**4 - inner**4), math.pi / 4.0 * (outer**2 - inner**2)
    bending = quartic * of_section(section.stiffness_over_body(4) for section in sections)
    steel_area = area * of_section(section.steel_over_body(2) for section in sections)
    given = of_section(section.weight_per_length or 0.0 for section in sections)
    hanging = np.where(given > 0.0, given / (GRAVITY * _STEEL_DENSITY), steel_area)
    course = WellPath.from_survey(survey)
    falls = np.diff(course.interpolate(boundaries)[1][:, 2])
    geometry = side_force_geometry(course, boundaries, hanging, falls)
    mesh = Mesh(
        top=boundaries[:-1],
        bottom=boundaries[1:],
        area=area * of_section(section.stiffness_over_body(2) for section in sections),
        second_moment=bending,
        polar_moment=2.0 * bending,
        steel_area=steel_area,
        steel_polar_moment=2.0 * quartic * of_section(section.steel_over_body(4) for section in sections),
        given_weight=given,
        outer_radius=0.5 * contact,
        clearance=0.5 * (hole_diameter - contact),
        cosine=falls / np.diff(boundaries),
        sine=geometry.sine,
        vertical_curvature=geometry.vertical_curvature,
        lateral_curvature=geometry.lateral_curvature,
    )
    for column in fields(mesh):
        getattr(mesh, column.name).setflags(write=False)
    return mesh


def contact_radius(rig: Rig, mesh: Mesh) -> Array:
    """Lever (n,) of friction around the hole, m."""
    return mesh.outer_radius * rig.string.contact_radius_factor


def steel_area(rig: Rig, mesh: Mesh) -> Array:
    """Area (n,) of steel, m2, that gives each element its weight."""
    area = mesh.steel_area
    if mesh.given_weight.any():
        area = np.where(mesh.given_weight > 0.0, mesh.given_weight / (GRAVITY * rig.string.density), area)
    return area * rig.string.weight_factor


def steel_polar_moment(rig: Rig, mesh: Mesh) -> Array:
    """Polar moment (n,) of the steel, m4, that gives each element its inertia; a given weight scales it."""
    return mesh.steel_polar_moment * (steel_area(rig, mesh) / mesh.steel_area)


def buoyed_weight(rig: Rig, mesh: Mesh) -> Array:
    """Weight (n,) of each element in the mud, N."""
    return GRAVITY * (rig.string.density - rig.mud.density) * steel_area(rig, mesh) * mesh.length


def torsional_impedance(rig: Rig, mesh: Mesh) -> float:
    """Torque per speed of a torsional wave at the top of the string, N m s."""
    moments = float(mesh.polar_moment[0] * steel_polar_moment(rig, mesh)[0])
    return math.sqrt(rig.string.shear_modulus * rig.string.density) * math.sqrt(moments)


def covered_fraction(mesh: Mesh, top: float, bottom: float) -> Array:
    """Fraction (n,) of each element's length between two measured depths (m)."""
    overlap = np.minimum(mesh.bottom, bottom) - np.maximum(mesh.top, top)
    return np.clip(overlap, 0.0, None) / mesh.length


def friction_factors(rig: Rig, mesh: Mesh) -> Array:
    """Factors (n,) of the contact's friction: friction intervals times a cuttings bed, averaged over each element."""
    bed = rig.effects.cuttings_bed
    covered = 1.0 + (bed.factor - 1.0) * covered_fraction(mesh, bed.top, bed.bottom)
    if not rig.well.friction_intervals:
        return covered
    factors = np.zeros(mesh.count)
    above = 0.0
    for interval in rig.well.friction_intervals:
        factors += interval.factor * covered_fraction(mesh, above, interval.to)
        above = interval.to
    return factors * covered


def torsional_compliances(rig: Rig, mesh: Mesh) -> Array:
    """Twist of each element per torque (n,), rad/(N m)."""
    stiffness = rig.string.shear_modulus * mesh.polar_moment / mesh.length
    return (1.0 + rig.effects.torsional_compliance.extra) / stiffness


def open_hole_fraction(rig: Rig, mesh: Mesh) -> Array:
    """Fraction (n,) of each element that lies in the last friction interval, the open hole."""
    intervals = rig.well.friction_intervals
    cased_to = intervals[-2].to if len(intervals) > 1 else 0.0
    return covered_fraction(mesh, cased_to, math.inf)


def _elements_per_section(lengths: list[float], elements: int) -> list[int]:
    """Elements of each section: in proportion to length, at least one; the longest takes the rounding."""
    total = math.fsum(lengths)
    counts = [max(1, round(elements * length / total)) for length in lengths]
    longest = lengths.index(max(lengths))
    counts[longest] = max(1, counts[longest] + elements - sum(counts))
    return counts
