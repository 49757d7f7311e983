"""Friction of one rigid asperity: its wear regime and coefficient from attack angle and shear factor."""

from slider_drilling.asperity_friction.wear_regimes import WearMode, friction_coefficient, wear_mode

__all__ = ["WearMode", "friction_coefficient", "wear_mode"]
