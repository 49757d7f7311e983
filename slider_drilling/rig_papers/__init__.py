"""From a rig's papers to a rig file: tables of pipe, motors, drives and pumps, readers of papers, and defaults."""
