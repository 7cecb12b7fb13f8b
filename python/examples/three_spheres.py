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
# # Three spheres swim
#
# Two arms of ten radii close to six and open again, one after the other (Najafi & Golestanian
# 2004). In unbounded fluid the displacement of a cycle is 0.1598053404 radii.

# %%
import numpy as np

import swimmer

scene = swimmer.Scene.from_template("three-sphere")
scene

# %% [markdown]
# ## The stroke, with its error bar

# %%
run = scene.run(progress=False)
assert abs(run.net - 0.1598053404) <= run.net_error
run

# %% [markdown]
# ## A resistance matrix
#
# `(F, T) = R (U, omega)`, six rows per sphere, with the error bar of each entry.

# %%
resistance = scene.resistance()
eigenvalues = np.linalg.eigvalsh(resistance)
assert eigenvalues.min() > 0
print(resistance)
print("an isolated sphere:", 6 * np.pi, "eigenvalues from", eigenvalues[0], "to", eigenvalues[-1])

# %% [markdown]
# ## The stroke as a line integral
#
# The velocity of a swimmer without inertia is linear in the rates of its arms. The integral of the
# connection around the square of shapes is the displacement.

# %%
nodes, weights = np.polynomial.legendre.leggauss(8)
lengths = 8 + 2 * nodes
closing = sum(
    2 * w * (scene.connection([6, x]).matrix[0, 1] - scene.connection([10, x]).matrix[0, 1])
    for x, w in zip(lengths, weights)
)
opening = sum(
    2 * w * (scene.connection([x, 6]).matrix[0, 0] - scene.connection([x, 10]).matrix[0, 0])
    for x, w in zip(lengths, weights)
)
print("line integral:", opening - closing, "run:", run.net)
assert abs(opening - closing - run.net) <= 2 * run.net_error

# %% [markdown]
# ## Any time of the run
#
# Positions, the forces, and the flow where it is asked for.

# %%
path = run.at(np.linspace(0, 4, 101))              # positions, attitudes, values and rates of links
solution = run.solve(0.4)                          # .force, and its bar .force_error
flow = run.flow(0.4, [[0, 0, 2], [0, 0, 4]])       # velocities at points
assert path.positions.shape == (101, 3, 3)
assert np.abs(solution.force.sum(axis=0)).max() < 1e-6
assert np.linalg.norm(flow.velocity[0]) > np.linalg.norm(flow.velocity[1]) > 0

# %% [markdown]
# ## All small strokes
#
# The curvature of the connection over both arms: where it has one sign, larger strokes go farther.

# %%
heights = scene.map(progress=False)
shapes = heights.grid(41)
curvature = heights.curvature(shapes)[..., 0]      # displacement along x per area of a small stroke
assert curvature.shape == (41, 41) and np.all(curvature * curvature[20, 20] > 0)

# %% [markdown]
# ## A picture
#
# The flow in the plane of the swimmer while the left arm closes.

# %%
x, z = np.meshgrid(np.linspace(-15, 15, 121), np.linspace(-8, 8, 65))
flow = scene.flow(np.stack([x, np.zeros_like(x), z], axis=-1))
speed = np.linalg.norm(flow.velocity, axis=-1)
assert flow.is_fluid.mean() > 0.9 and np.nanmax(speed) < 3
for centre, velocity in zip(run.positions[0], scene.solve().velocity):
    speed[np.hypot(x - centre[0], z - centre[2]) <= 1] = np.linalg.norm(velocity)

try:
    import matplotlib.pyplot as plt
except ImportError:
    print("pip install matplotlib for the picture")
else:
    figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
    image = axes.pcolormesh(x, z, speed, cmap="cividis", shading="gouraud")
    axes.streamplot(x, z, flow.velocity[..., 0], flow.velocity[..., 2], color="w", linewidth=0.6)
    for centre in run.positions[0]:
        axes.add_patch(plt.Circle(centre[[0, 2]], 1, color="0.2"))
    axes.set(aspect="equal", xlabel="x / radius", ylabel="z / radius")
    figure.colorbar(image, label="speed", shrink=0.8)
    figure.savefig("three_spheres.png", dpi=150)
