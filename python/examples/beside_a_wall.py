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
# # A squirmer beside a wall
#
# A puller swims towards the wall `z = 0`, which turns it. The run has its positions and the flow at
# any time.

# %%
import numpy as np

from swimmer import Scene

scene = Scene.from_template("squirmer")
run = scene.run(progress=False)
run

# %% [markdown]
# ## The path
#
# `at` evaluates the path that was integrated. The squirmer is a sphere of radius one, so its height
# stays above one.

# %%
path = run.at(np.linspace(0, run.times[-1], 101))
height = path.positions[:, 0, 2]
assert height.min() > 1 and np.allclose(path.positions[-1], run.positions[-1])
axis = 2 * np.arccos(np.clip(abs(path.quaternions[:, 0, 3]), 0, 1))
print(f"height from {height[0]:.3f} to {height[-1]:.3f}, turned by {np.degrees(axis[-1]):.1f} degrees")

# %% [markdown]
# ## The flow at two times
#
# At the wall the fluid is at rest.

# %%
x, z = np.meshgrid(np.linspace(-3, 6, 121), np.linspace(0, 6, 81))
points = np.stack([x, np.zeros_like(x), z], axis=-1)
times = [0.0, run.times[-1]]
flows = [run.flow(time, points) for time in times]
for time, flow in zip(times, flows):
    at_wall = np.linalg.norm(flow.velocity[0], axis=-1)
    largest = np.nanmax(np.linalg.norm(flow.velocity, axis=-1))
    print(f"time {time:.3f}: largest speed {largest:.3f}, at the wall {np.nanmax(at_wall):.1e}")
    # Expansions represent velocities to a thousandth of those at the surface.
    assert np.nanmax(at_wall) < 1e-2 * largest

# %% [markdown]
# ## A table for other programs
#
# Positions, velocities and forces of all rows, for pandas.

# %%
try:
    import pandas
except ImportError:
    print("pip install pandas for the table")
else:
    print(run.to_dataframe()[["time", "squirmer.x", "squirmer.z", "squirmer.vx", "squirmer.vz"]])

try:
    import matplotlib.pyplot as plt
except ImportError:
    print("pip install matplotlib for the picture")
else:
    figure, panels = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for panel, time, flow in zip(panels, times, flows):
        speed = np.linalg.norm(flow.velocity, axis=-1)
        panel.pcolormesh(x, z, speed, cmap="cividis", shading="gouraud")
        panel.streamplot(x, z, flow.velocity[..., 0], flow.velocity[..., 2], color="w")
        panel.set(aspect="equal", title=f"time {time:.2f}", xlabel="x", ylabel="z")
    figure.savefig("beside_a_wall.png", dpi=150)
