"""The blind check: seal logs, diagnose them from the logs alone, open the seals and score."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.blind.laws import CATALOGUE, OUTSIDE, no_effect
from slider_drilling.blind.sealed import (
    Law,
    random_commands,
    random_nuisance,
    random_rig,
    run_sealed,
    size_in_noise,
    write_sealed,
)
from slider_drilling.diagnosis.diagnose import Diagnosis, diagnose
from slider_drilling.gap.attribute import attribute
from slider_drilling.gap.findings import start_findings, total_closed
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.residuals import build_problem
from slider_drilling.log import read_log
from slider_drilling.rig import Rig

LEAST_SIZE = 1.5
_GROWTH = 1.6


@dataclass(frozen=True)
class Scored:
    """One sealed log, what was said of it, and whether that was right.

    size: RMS of the effect in the most moved channel, noise floors; oracle: gap closed when only the true effect is
    fitted (NaN outside the catalogue); covered: the reported interval holds it; ends: errors m at the top and
    bottom of a cuttings bed, None for anything else.
    """

    truth: str
    in_catalogue: bool
    site: str | None
    size: float
    verdict: str
    named: tuple[str, ...]
    first: str | None
    group: tuple[str, ...]
    named_site: str | None
    closed: float
    interval: tuple[float, float]
    oracle: float
    covered: bool | None
    ends: tuple[float, float] | None
    right: bool
    runtime: float


def seal(name: str, seed: int, base: Rig, folder: Path) -> tuple[Path, Law, float]:
    """Make one sealed log at a size of at least `LEAST_SIZE` noise floors; its path, law and size."""
    generator = np.random.default_rng([seed, sum(name.encode())])
    rig = random_rig(generator, base)
    nuisance, commands = random_nuisance(generator), random_commands(generator, rig)
    plain = run_sealed(rig, nuisance, no_effect(generator, rig, 1.0), commands)
    make = {**CATALOGUE, **OUTSIDE, "none": no_effect}[name]
    law, response, size, reached = no_effect(generator, rig, 1.0), plain, 1.0, 0.0
    state = generator.bit_generator.state
    while name != "none" and reached < LEAST_SIZE:
        generator.bit_generator.state = state
        law = make(generator, rig, size)
        response = run_sealed(rig, nuisance, law, commands)
        reached, size = size_in_noise(rig, plain, response), size * _GROWTH
    folder.mkdir(parents=True, exist_ok=True)
    # A number, not the name: the file is all that the diagnosis sees.
    path = folder / f"sealed_{seed}_{sum(name.encode()):04d}.mcap"
    write_sealed(path, rig, commands, response, generator)
    return path, law, reached


def score(diagnosis: Diagnosis, law: Law, size: float) -> Scored:
    """Open the seal."""
    answer = diagnosis.answer
    assert answer is not None, "the first look stopped at a sealed log"
    first = answer.ranking[0] if answer.ranking and answer.effects else None
    group = first.group if first is not None else ()
    named_right = first is not None and law.name in (first.effect, *group)
    cautious = diagnosis.verdict in ("unknown", "effect_and_unknown", "inconclusive")
    if law.name == "none":
        right = diagnosis.verdict in ("none", "parameters")
    elif law.in_catalogue:
        right = named_right
    else:
        right = cautious or answer.site == law.site
    oracle = _oracle(diagnosis, law) if law.in_catalogue and law.name != "none" else float("nan")
    low, high = answer.closed_interval
    covered = bool(low <= oracle <= high) if np.isfinite(oracle) and np.isfinite(low) else None
    ends = None
    if law.interval is not None and first is not None and first.effect == "cuttings_bed":
        ends = (first.parameters["cuttings_bed.top"] - law.interval[0],
                first.parameters["cuttings_bed.bottom"] - law.interval[1])  # fmt: skip
    return Scored(
        law.name, law.in_catalogue, law.site, size, diagnosis.verdict, answer.effects,
        first.effect if first else None, group, answer.site, answer.closed, (low, high), oracle, covered, ends,
        right, answer.runtime,
    )  # fmt: skip


def _oracle(diagnosis: Diagnosis, law: Law) -> float:
    """Gap closed when the true effect, alone, is fitted to the same log."""
    answer = diagnosis.answer
    assert answer is not None, "the first look stopped at a sealed log"
    if answer.effects == (law.name,):
        return answer.closed
    assert diagnosis.prepared is not None
    model = diagnosis.prepared.model
    true = [effect for effect in model.effects if effect.name == law.name]
    findings = start_findings(build_problem(model, answer.floors), 0)
    tuned = answer.findings.tuned
    attribute(findings, starts=[tuned.fit.values] if tuned is not None else [{}], effects=true)
    closed, _ = total_closed(findings)
    if np.isnan(closed) and findings.rounds and findings.rounds[0]:
        return findings.rounds[0][0].closed
    return closed


def blind_check(
    names: Sequence[str],
    seeds: Sequence[int],
    base: Rig,
    folder: Path,
    said: Callable[[Scored], None] = lambda scored: None,
    progress: Progress = lambda stage, share: None,
) -> list[Scored]:
    """Seal, diagnose and score every name at every seed. Logs are kept in the folder, opened seals in seals.json."""
    results: list[Scored] = []
    cases = [(name, seed) for seed in seeds for name in names]
    for index, (name, seed) in enumerate(cases):
        progress(f"sealing {index + 1} of {len(cases)}", index / len(cases))
        path, law, size = seal(name, seed, base, folder)
        log = read_log(path)
        progress(f"diagnosing {index + 1} of {len(cases)}", (index + 0.1) / len(cases))
        results.append(score(diagnose([log], log.rig()), law, size))
        said(results[-1])
        text = json.dumps([_plain(asdict(scored)) for scored in results], indent=1)
        temporary = folder / ".seals.json"
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(folder / "seals.json")
    return results


def totals(results: Sequence[Scored]) -> dict[str, Any]:
    """Counts of right and of all, by kind; nothing is turned into a percentage that few cases cannot carry."""
    known = [r for r in results if r.in_catalogue and r.truth != "none"]
    free = [r for r in results if r.truth == "none"]
    outside = [r for r in results if not r.in_catalogue]
    covered = [r.covered for r in known if r.covered is not None]
    return {
        "named_right": [sum(r.right for r in known), len(known)],
        "false_alarms": [sum(not r.right for r in free), len(free)],
        "outside_not_misnamed": [sum(r.right for r in outside), len(outside)],
        "site_right": [sum(r.named_site == r.site for r in known), len(known)],
        "interval_covers_oracle": [sum(covered), len(covered)],
        "confusion": {r.truth: [o.first or o.verdict for o in results if o.truth == r.truth] for r in results},
    }


def _plain(tree: dict[str, Any]) -> dict[str, Any]:
    return {k: None if isinstance(v, float) and not np.isfinite(v) else v for k, v in tree.items()}
