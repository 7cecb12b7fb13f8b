# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # The best stroke, and a learned one
#
# The velocity of a swimmer without inertia is linear in the rates of its joints, so that all
# strokes follow from one table over the shapes.

# %%
import numpy as np

import swimmer

scene = swimmer.Scene.from_template("three-sphere")

# %% [markdown]
# ## The most efficient stroke
#
# Beside the square stroke of the scene, arms between six and ten radii.

# %%
square = scene.run(progress=False)
best = scene.optimise(progress=False)
best

# %% [markdown]
# ## A small circle in shape space
#
# Its displacement is the curvature of the connection times its area.

# %%
def connection(shape):
    """Velocity of the swimmer along the line for unit rates of the two arms."""
    return scene.connection(shape).matrix[0]


centre, radius, step = np.array([8.0, 8.0]), 0.5, 1e-3
rates = [np.array([step, 0]), np.array([0, step])]
curvature = (connection(centre + rates[0])[1] - connection(centre - rates[0])[1]) / (2 * step) - (
    connection(centre + rates[1])[0] - connection(centre - rates[1])[0]
) / (2 * step)
angles = np.arange(16) * np.pi / 8
circle = sum(
    connection(centre + radius * np.array([np.cos(a), np.sin(a)]))
    @ (radius * np.array([-np.sin(a), np.cos(a)]))
    for a in angles
) * (np.pi / 8)
print(f"circle {circle:.6f}, curvature times area {curvature * np.pi * radius**2:.6f}")
# The next term is of fourth order in the radius over the length of the arms.
assert abs(circle / (curvature * np.pi * radius**2) - 1) < (radius / 4) ** 2

# %% [markdown]
# ## Learning
#
# Tabular Q-learning (Tsang, Tong, Nallan & Pak 2020): arms are contracted or extended, the reward
# is the displacement. The interface is that of gymnasium.

# %%
swimmer_that_learns = swimmer.Swimmer(
    scene.with_values({"learn.contracted": 6}), steps=200, progress=False
)
generator = np.random.default_rng(1)
values = np.zeros_like(swimmer_that_learns.rewards)
state, _ = swimmer_that_learns.reset(seed=1)
for step in range(2000):
    greedy = generator.random() > 0.2
    action = int(np.argmax(values[state]) if greedy else generator.integers(len(values[state])))
    following, reward, _, truncated, _ = swimmer_that_learns.step(action)
    values[state, action] += 0.5 * (reward + 0.9 * values[following].max() - values[state, action])
    state = swimmer_that_learns.reset()[0] if truncated else following

# %% [markdown]
# The learned policy is the stroke of Najafi & Golestanian: a quarter of its displacement per step.

# %%
total = 0.0
state, _ = swimmer_that_learns.reset()
for _ in range(100):
    state, reward, *_ = swimmer_that_learns.step(int(np.argmax(values[state])))
    total += reward
print(f"per step: learned {abs(total) / 100:.6f}, square stroke {square.net / 4:.6f}")
assert abs(abs(total) / 100 - square.net / 4) < 1e-3
