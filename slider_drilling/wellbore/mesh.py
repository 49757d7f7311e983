"""The string as lumped elements (`model.md` section 3): masses at element middles, springs between them, the wall."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np

from slider_drilling.rig import Rig, StringSection
from slider_drilling.wellbore.side_force import side_force_geometry
from slider_drilling.wellbore.well_path import Array, WellPath

GRAVITY = 9.81  # m/s2, not 9.80665: the hanging weight of the reference logs shows the difference


@dataclass(frozen=True)
class Mesh:
    """Geometry and section properties of the elements, each (n,), surface first.

    Attributes:
        top, bottom, middle: Measured depth, m.
        area: Of steel, m2.
        second_moment, polar_moment: m4, of bending and torsion.
        outer_radius, clearance: m; clearance is radial.
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
    outer = np.repeat([section.outer_diameter for section in sections], counts)
    inner = np.repeat([section.inner_diameter for section in sections], counts)
    quartic, area = math.pi / 64.0 * (outer**4 - inner**4), math.pi / 4.0 * (outer**2 - inner**2)
    course = WellPath.from_survey(survey)
    falls = np.diff(course.interpolate(boundaries)[1][:, 2])
    geometry = side_force_geometry(course, boundaries, area, falls)
    mesh = Mesh(
        top=boundaries[:-1],
        bottom=boundaries[1:],
        area=area,
        second_moment=quartic,
        polar_moment=2.0 * quartic,
        outer_radius=0.5 * outer,
        clearance=0.5 * (hole_diameter - outer),
        cosine=falls / np.diff(boundaries),
        sine=geometry.sine,
        vertical_curvature=geometry.vertical_curvature,
        lateral_curvature=geometry.lateral_curvature,
    )
    for column in fields(mesh):
        getattr(mesh, column.name).setflags(write=False)
    return mesh


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
