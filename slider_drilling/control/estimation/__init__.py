"""Estimators: toolface, string compliance, friction, drag, motor pressure and torque-sensor errors."""
