"""Trains a rocking policy on many drawn rigs at once: PPO (Schulman et al., arXiv:1707.06347) in NumPy.

    python docs/examples/train_rocking_policy.py --minutes 10

goes on from `rocking_policy.npz` beside it, where there is one, and writes it every minute. One update takes 256 slides
of 128 s; a tenth of the rigs have a plant of foreign structure. `--fresh` begins anew.
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rocking_policy import ACTIONS, FEATURES, INTERVAL, WEIGHTS, Policy, RockingMemory

import slider_drilling as sd

Array = NDArray[Any]

SLOTS, STEPS = 256, 128
ELEMENTS = 20  # of each string: scores are taken on more, and on other rigs
FOREIGN = 0.1  # share of rigs whose plant is of foreign structure
DISCOUNT, TRACE = 0.985, 0.95  # per second, and lambda of the advantage estimate
EPOCHS, MINIBATCHES = 4, 8
CLIP, ENTROPY, VALUE_WEIGHT, MAX_GRADIENT = 0.2, 1e-3, 0.5, 0.5
LEARNING_RATE = 4e-4


@dataclass
class Rollout:
    """What one update learns from, each (STEPS, SLOTS, ...); `live` is 0 where an episode was only restarted."""

    features: Array
    actions: Array
    log_probability: Array
    rewards: Array
    values: Array
    over: Array
    live: Array


class Adam:
    """Kingma and Ba, arXiv:1412.6980."""

    def __init__(self, parameters: dict[str, Array]) -> None:
        self.first = {name: np.zeros_like(value) for name, value in parameters.items()}
        self.second = {name: np.zeros_like(value) for name, value in parameters.items()}
        self.steps = 0

    def apply(self, parameters: dict[str, Array], gradient: dict[str, Array], rate: float) -> None:
        """One step down the gradient, its norm limited."""
        norm = math.sqrt(sum(float(np.sum(value**2)) for value in gradient.values()))
        scale = min(1.0, MAX_GRADIENT / (norm + 1e-8))
        self.steps += 1
        for name, value in gradient.items():
            g = scale * value
            self.first[name] += 0.1 * (g - self.first[name])
            self.second[name] += 0.001 * (g * g - self.second[name])
            mean = self.first[name] / (1.0 - 0.9**self.steps)
            size = self.second[name] / (1.0 - 0.999**self.steps)
            parameters[name] -= np.float32(rate) * mean / (np.sqrt(size) + 1e-8)


def log_density(actions: Array, mean: Array, log_std: Array) -> Array:
    """Log density of a normal distribution, summed over the last axis."""
    z = (actions - mean) / np.exp(log_std)
    return np.sum(-0.5 * z * z - log_std - 0.5 * math.log(2.0 * math.pi), axis=-1)


def backward(policy: Policy, net: str, features: Array, outputs: list[Array], slope: Array) -> dict[str, Array]:
    """Gradient of a loss by a network's parameters; slope: (m, outputs) of the loss by its output."""
    gradient, inputs = {}, [features, *outputs[:-1]]
    for layer in (2, 1, 0):
        gradient[f"{net}_w{layer}"] = inputs[layer].T @ slope
        gradient[f"{net}_b{layer}"] = slope.sum(axis=0)
        if layer:
            slope = (slope @ policy.parameters[f"{net}_w{layer}"].T) * (1.0 - inputs[layer] ** 2)
    return gradient


def gradients(policy: Policy, f: Array, a: Array, old: Array, advantage: Array, returns: Array) -> dict[str, Array]:
    """Gradient of PPO's clipped loss over a minibatch of m steps."""
    count, log_std = len(f), policy.parameters["log_std"]
    actor, critic = policy.layers("actor", f), policy.layers("critic", f)
    ratio = np.exp(np.clip(log_density(a, actor[-1], log_std) - old, -10.0, 10.0))
    inside = np.where(advantage > 0.0, ratio < 1.0 + CLIP, ratio > 1.0 - CLIP)
    by_log = -(inside * ratio * advantage)[:, None] / count
    off = (a - actor[-1]) / np.exp(2.0 * log_std)
    gradient = backward(policy, "actor", f, actor, by_log * off)
    gradient["log_std"] = np.sum(by_log * ((a - actor[-1]) * off - 1.0), axis=0) - ENTROPY
    value = critic[-1][:, 0]
    gradient |= backward(policy, "critic", f, critic, VALUE_WEIGHT * 2.0 * (value - returns)[:, None] / count)
    return gradient


def advantages(r: Rollout, last_value: Array) -> Array:
    """Generalised advantage estimates (Schulman et al., arXiv:1506.02438), (STEPS, SLOTS)."""
    estimate, after = np.zeros_like(r.rewards), np.zeros(SLOTS)
    following = last_value
    for k in range(STEPS - 1, -1, -1):
        # A slide is cut off, it does not end: its last state is worth what it would be worth a second later.
        ahead = np.where(r.over[k], r.values[k], following)
        error = r.rewards[k] + DISCOUNT * ahead - r.values[k]
        after = error + DISCOUNT * TRACE * np.where(r.over[k], 0.0, after)
        estimate[k] = after
        following = r.values[k]
    return estimate


class Trainer:
    """Slides, their memory, and the policy that learns from them.

    Args:
        policy: It is changed.
        optimiser: Likewise.
        seed: Of rigs, noise and actions.
    """

    def __init__(self, policy: Policy, optimiser: Adam, seed: int) -> None:
        self.policy, self.optimiser = policy, optimiser
        self._slides = sd.vector_env(SLOTS, seed=1000 + seed, foreign=FOREIGN, elements=ELEMENTS)
        self._random = np.random.default_rng(seed)
        self._observation, _ = self._slides.reset(seed=seed)
        self._memory = RockingMemory(self._slides.rig_files, self._slides.rig_index)
        self._features = self._memory.features(self._observation)
        self._over = np.zeros(SLOTS, dtype=bool)
        self.error = np.zeros(0)
        self._staggered = 0

    def rollout(self) -> Rollout:
        """Slide on for STEPS seconds."""
        self._stagger()
        rows: list[list[Array]] = [[] for _ in range(7)]
        errors = []
        for _ in range(STEPS):
            mean = self.policy.mean_action(self._features)
            log_std = self.policy.parameters["log_std"]
            actions = mean + np.exp(log_std) * self._random.normal(size=mean.shape)
            values = self.policy.layers("critic", self._features)[-1][:, 0]
            commands = self._memory.commands(self._observation[:, 0].astype(float), actions)
            restarted, features = self._over, self._features
            self._observation, reward, ended, cut, info = self._slides.step(commands.astype(np.float32))
            if restarted.any():
                self._memory.restart(restarted, self._slides.rig_index)
            self._features, self._over = self._memory.features(self._observation), ended | cut
            errors.append(np.abs(info["error"][self._observation[:, 0] > 240.0]))
            log_probability = log_density(actions, mean, log_std)
            for column, value in zip(rows, (features, actions, log_probability, 0.1 * np.clip(reward, -3.0, 3.0),
                                            values, self._over, ~restarted), strict=True):  # fmt: skip
                column.append(value)
        self.error = np.concatenate(errors)
        return Rollout(*(np.array(column) for column in rows))

    def _stagger(self) -> None:
        """Start a seventh of the slides again, so that not all of them are at their beginning at once."""
        if self._staggered < 7:
            mask = np.arange(SLOTS) % 7 == self._staggered
            self._observation, _ = self._slides.reset(options={"reset_mask": mask})
            self._memory.restart(mask, self._slides.rig_index)
            self._features, self._over = self._memory.features(self._observation), self._over & ~mask
            self._staggered += 1

    def update(self, rate: float) -> Rollout:
        """One update of PPO; returns what it learnt from."""
        r = self.rollout()
        estimate = advantages(r, self.policy.layers("critic", self._features)[-1][:, 0])
        live = r.live.ravel()
        f, a = r.features.reshape(-1, FEATURES)[live], r.actions.reshape(-1, ACTIONS)[live].astype(np.float32)
        old, gain, returns = (x.ravel()[live] for x in (r.log_probability, estimate, estimate + r.values))
        gain = (gain - gain.mean()) / (gain.std() + 1e-8)
        old, gain, returns = (x.astype(np.float32) for x in (old, gain, returns))
        for _ in range(EPOCHS):
            for part in np.array_split(self._random.permutation(len(f)), MINIBATCHES):
                gradient = gradients(self.policy, f[part], a[part], old[part], gain[part], returns[part])
                self.optimiser.apply(self.policy.parameters, gradient, rate)
                np.clip(self.policy.parameters["log_std"], -2.5, 0.0, out=self.policy.parameters["log_std"])
        return r


def save(path: Path, policy: Policy, optimiser: Adam, updates: int) -> None:
    """Write policy, optimiser and the number of updates; training goes on from them."""
    moments = {f"adam{order}_{name}": value for order, moment in ((1, optimiser.first), (2, optimiser.second))
               for name, value in moment.items()}  # fmt: skip
    stored = {name: value.astype(np.float32) for name, value in (policy.parameters | moments).items()}
    partial = path.with_suffix(".part.npz")
    np.savez_compressed(partial, **stored, adam_steps=np.array(optimiser.steps), adam_updates=np.array(updates))
    partial.replace(path)


def load(path: Path) -> tuple[Policy, Adam, int]:
    """Policy, optimiser and number of updates of a file; one without the optimiser's moments starts it anew."""
    policy = Policy.load(path)
    optimiser = Adam(policy.parameters)
    with np.load(path) as stored:
        if "adam1_log_std" in stored.files:
            optimiser.steps = int(stored["adam_steps"])
            for order, moment in ((1, optimiser.first), (2, optimiser.second)):
                moment.update({name: stored[f"adam{order}_{name}"] for name in moment})
        steps = int(stored["adam_steps"]) if "adam_steps" in stored.files else 0
        updates = int(stored["adam_updates"]) if "adam_updates" in stored.files else steps // (EPOCHS * MINIBATCHES)
    return policy, optimiser, updates


def main() -> None:
    """Train for some minutes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0, help="of training")
    parser.add_argument("--weights", type=Path, default=WEIGHTS, help="file to go on from and to write")
    parser.add_argument("--fresh", action="store_true", help="begin anew")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rate", type=float, default=LEARNING_RATE, help="learning rate")
    options = parser.parse_args()
    if options.fresh or not options.weights.exists():
        policy = Policy.random(options.seed)
        optimiser, updates = Adam(policy.parameters), 0
    else:
        policy, optimiser, updates = load(options.weights)
    trainer = Trainer(policy, optimiser, options.seed + updates)
    start = saved = time.monotonic()
    while time.monotonic() - start < 60.0 * options.minutes:
        r = trainer.update(options.rate)
        updates += 1
        error = math.degrees(float(trainer.error.mean())) if trainer.error.size else math.nan
        slid = updates * STEPS * SLOTS * INTERVAL / 3600.0
        spread = np.exp(policy.parameters["log_std"]).round(2)
        print(
            f"{updates:5d} updates, {slid:7.0f} h slid: reward {10.0 * r.rewards[r.live].mean():+.3f} a second, "
            f"mean error after 240 s {error:5.1f} deg, spread {spread}",
            flush=True,
        )
        if time.monotonic() - saved > 60.0:
            save(options.weights, policy, optimiser, updates)
            saved = time.monotonic()
    save(options.weights, policy, optimiser, updates)


if __name__ == "__main__":
    main()
