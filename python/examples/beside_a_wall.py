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
# # Beside a wall
#
# The plane z = 0 has no slip. A sphere that moves towards it feels more drag the closer it is, and
# the displacement of a swimmer along it depends on its height.

# %%
import numpy as np

import swimmer

# %% [markdown]
# ## The drag of a sphere that moves towards the wall
#
# Brenner (1961) gives it as a series in the angle `alpha` with `cosh(alpha) = height / radius`.


# %%
def brenner(height, terms=400):
    """Drag of a sphere of radius 1 towards a wall, in units of Stokes' 6 pi mu a U."""
    alpha = np.arccosh(height)
    n = np.arange(1, terms)
    upper = 2 * np.sinh((2 * n + 1) * alpha) + (2 * n + 1) * np.sinh(2 * alpha)
    lower = (2 * np.sinh((n + 0.5) * alpha)) ** 2 - ((2 * n + 1) * np.sinh(alpha)) ** 2
    series = n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (upper / lower - 1)
    return 4 / 3 * np.sinh(alpha) * series.sum()


def sphere_above_wall(height):
    """The scene of a sphere of radius 1 with its centre at this height, which is pulled down."""
    ball = {
        "name": "ball",
        "radius": 1,
        "position": [0, 0, height],
        "force": [0, 0, -6 * np.pi],
    }
    return swimmer.Scene.from_dict({"domain": {"kind": "wall"}, "bodies": [ball]})


heights = [1.1, 1.5, 2.0, 4.0]
for height in heights:
    solution = sphere_above_wall(height).solve()
    speed, bar = -solution.velocity[0, 2], solution.velocity_error
    exact = 1 / brenner(height, terms=60)
    print(f"height {height}: speed {speed:.6f} +- {bar:.1e}, exact {exact:.6f}")
    assert abs(speed - exact) <= bar

# %% [markdown]
# ## A swimmer along the wall
#
# The same stroke at several heights, against the net displacement far from the wall.

# %%
free = swimmer.Scene.from_template("three-sphere")


def along_wall(height):
    """The swimmer at this height."""
    places = {"left": -10, "centre": 0, "right": 10}
    values = {f"bodies.{name}.position": [x, 0, height] for name, x in places.items()}
    return free.with_values({"domain.kind": "wall"} | values)


runs = {height: along_wall(height).run(progress=False) for height in [4, 8, 16, 64]}
far = free.run(progress=False)
for height, run in runs.items():
    along = np.mean(run.displacement[:, 0])
    print(f"height {height}: {along:.4f} along the wall, error bar {run.net_error:.1e}")
print(f"without a wall: {far.net:.4f}")

# %% [markdown]
# The effect decays with the distance. Within a few lengths of the swimmer it is not monotonic: the
# wall slows the swimmer down, and makes the two ends of the stroke differ.

# %%
changes = {height: abs(run.net - far.net) for height, run in runs.items()}
assert changes[8] > changes[16] > changes[64]
assert changes[64] < 1e-3 * far.net

# %% [markdown]
# ## As a sweep
#
# Several runs at the same time, as a table that pandas can read.

# %%
found = along_wall(6).sweep({"bodies.centre.radius": [0.5, 1, 1.5]}, progress=False)
assert all(status == "met" for status in found.status)
found
