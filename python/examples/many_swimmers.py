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
# # Many swimmers
#
# Copies of one swimmer at random places. Each swims in the flow of all others, so that the
# displacements differ; where they are far apart, each goes about as far as one alone.

# %%
import time

import numpy as np

import swimmer

alone = swimmer.Scene.from_template("three-sphere").with_values({"model.kind": "rpy"})
single = alone.run(progress=False)
single

# %% [markdown]
# ## Eight of them in a cube
#
# The key `copies` adds them; random places have a seed, so that the scene is the same each time.


# %%
def crowd(copies, edge):
    """The swimmer with this number of copies in a cube."""
    text = alone.to_toml() + f"""
[[copies]]
of = "centre"
count = {copies}
size = [{edge}, {edge}, {edge}]
isotropic = true
gap = 0.5
"""
    return swimmer.Scene.from_toml(text)


eight = crowd(7, 120)
run = eight.run(progress=False)
assert len(run.swimmers) == 8
sizes = [float(np.linalg.norm(one.displacement)) for one in run.swimmers]
for one, size in zip(run.swimmers, sizes, strict=True):
    print(f"{one.name:<12} {size:.4f} +- {one.errors.total:.4f}")

# %% [markdown]
# The others change the displacement of each by about a percent at this distance.

# %%
assert abs(np.mean(sizes) - single.net) < 0.1 * single.net
assert max(sizes) - min(sizes) > 1e-4 * single.net

# %% [markdown]
# ## What one instant of more of them costs
#
# At a constant volume fraction.

# %%
for copies in [7, 31, 127]:
    scene = crowd(copies, 60 * (copies + 1) ** (1 / 3))
    started = time.perf_counter()
    solution = scene.solve()
    seconds = time.perf_counter() - started
    print(f"{copies + 1:4} swimmers: {seconds:.2f} s, error bar {solution.velocity_error:.1e}")
    assert solution.velocity.shape == (3 * (copies + 1), 3)

# %% [markdown]
# ## All of the trajectory as a table

# %%
places = run.at(np.linspace(0, 4, 5)).positions
print(places.shape)
assert places.shape == (5, 24, 3)
