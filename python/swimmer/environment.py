"""An environment for reinforcement learning: a swimmer whose joints contract and extend."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._progress import Report, reporter
from .results import frozen
from .scene import Scene

try:
    from gymnasium import Env, spaces
except ImportError:
    Env, spaces = object, None  # type: ignore[misc, assignment]

__all__ = ["Swimmer"]


class Swimmer(Env):  # type: ignore[misc, valid-type]
    """A swimmer with the interface of `gymnasium.Env`; gymnasium may be absent.

    Bit `k` of the state is set if joint `k` is contracted; an action changes one joint. The reward
    is the displacement of the mean of the bodies along `learn.direction`. Without inertia it
    depends on state and action alone, so all rewards are computed at the start (Tsang, Tong,
    Nallan & Pak 2020).

    Parameters
    ----------
    scene : Scene
        A free swimmer with `learn.contracted` or `learn.extended`.
    steps : int
        Number of steps of an episode, after which it is truncated.
    progress : bool or callable
        As for `Scene.run`, for the rewards.

    Attributes
    ----------
    rewards : numpy.ndarray
        Rewards by state and action.
    reward_error : float
        Error bar of every reward.
    joints : tuple of str
        Names of the joints.

    Examples
    --------
    The cycle of Najafi & Golestanian, one step for each arm in turn:

    >>> scene = Scene.from_template("three-sphere", {"learn.contracted": 6})
    >>> swimmer = Swimmer(scene, progress=False)
    >>> swimmer.reset(seed=1)
    (0, {})
    >>> sum(swimmer.step(action)[1] for action in [0, 1, 0, 1]) - 0.1598053404 < 1e-4
    True
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self, scene: Scene, steps: int = 100, *, progress: bool | Report = True
    ) -> None:
        if steps < 1:
            raise ValueError(f"an episode has at least one step, not {steps}")
        with reporter(progress, f"rewards of {scene.name}") as report:
            table, names, error, model = scene._scene.rewards(report)
        self.rewards: np.ndarray = frozen(table)
        self.joints = tuple(names)
        self.reward_error: float = error
        self.model: str = model
        self.steps = steps
        self._state = 0
        self._step = 0
        if spaces is not None:
            states, actions = self.rewards.shape
            self.observation_space = spaces.Discrete(states)
            self.action_space = spaces.Discrete(actions)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[int, dict[str, Any]]:
        """Starts an episode with all joints extended; returns the state and a dictionary."""
        if spaces is not None:
            super().reset(seed=seed)
        self._state = self._step = 0
        return 0, {}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict[str, Any]]:
        """Changes a joint; returns state, reward, `False`, whether the episode is over, and a
        dictionary with the error bar of the reward.
        """
        action = int(action)
        if not 0 <= action < len(self.joints):
            raise ValueError(f"action {action}: there are {len(self.joints)} joints, from 0")
        reward = float(self.rewards[self._state, action])
        self._state ^= 1 << action
        self._step += 1
        is_over = self._step >= self.steps
        return self._state, reward, False, is_over, {"reward_error": self.reward_error}
