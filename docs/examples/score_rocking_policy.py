"""Scores the trained policy beside fixed rocking, shifted rocking and `SlideController`: same rigs, noise and scores.

    python docs/examples/score_rocking_policy.py --slides 12 --seed 501 --foreign 0.5

The slides are those of ``slider-drilling closed-loop --campaign`` with this seed; a share of the plants is of foreign
structure. No rig of the training has such a seed.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
from pathlib import Path

import numpy as np
from rocking_policy import WEIGHTS, TrainedRocking

import slider_drilling as sd
from slider_drilling.control import FixedRocking, SlideController
from slider_drilling.control.fixed_rocking import settings_for
from slider_drilling.rig import Rig
from slider_drilling.training.draw import draw_rigs
from slider_drilling.training.scoring import score_controller


def fixed_rocking(rig: Rig) -> FixedRocking:
    """Constant rocking, without toolface control."""
    return FixedRocking(rig, dataclasses.replace(settings_for(rig), shift_gain=0.0))


def main() -> None:
    """Print a line for each controller."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--slides", type=int, default=12)
    parser.add_argument("--seed", type=int, default=501, help="of the campaign")
    parser.add_argument("--foreign", type=float, default=0.0, help="share of plants of foreign structure")
    parser.add_argument("--elements", type=int, default=60, help="of each string")
    parser.add_argument("--only", nargs="*", default=(), help="some of trained, fixed, shifted, slide_controller")
    parser.add_argument("--weights", type=Path, default=WEIGHTS)
    options = parser.parse_args()
    controllers = {"trained": lambda rig: TrainedRocking(rig, options.weights), "fixed": fixed_rocking,
                   "shifted": FixedRocking, "slide_controller": SlideController}  # fmt: skip
    slides = draw_rigs(options.slides, sd.load_rig(), options.seed, 900.0, True, options.foreign)
    print("| controller | mean error, median of slides deg | mean deg | within 15 deg % | set in 240 s | m/h |\n"
          "|---|---|---|---|---|---|", flush=True)  # fmt: skip
    for name, build in controllers.items():
        if options.only and name not in options.only:
            continue
        scores = score_controller(build, slides, options.seed, options.elements)
        errors = [180.0 if math.isnan(score.mean_abs_error_deg) else score.mean_abs_error_deg for score in scores]
        in_time = sum(score.time_to_set_s is not None and score.time_to_set_s <= 240.0 for score in scores)
        held = np.nanmean([score.within_15_deg for score in scores])
        print(f"| {name} | {np.median(errors):.1f} | {np.mean(errors):.1f} | {100.0 * held:.0f} | {in_time} of "
              f"{len(scores)} | {np.nanmean([score.rop_m_h for score in scores]):.1f} |", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
