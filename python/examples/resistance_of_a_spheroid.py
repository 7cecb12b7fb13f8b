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
# # The resistance of a spheroid
#
# A spheroid of aspect ratio 2 in unbounded fluid, by finite elements, against the exact drag of
# Oberbeck (1876) along and across its axis. Lengths in radii of the equator, viscosity 1.

# %%
import numpy as np

import swimmer

text = """
[[bodies]]
name = "spheroid"
shape = "spheroid"
radius = 1
half_length = 2
axis = [1, 0, 0]
position = [0, 0, 0]
"""
scene = swimmer.Scene.from_toml(text, {"model.kind": "fem", "fem.surface_size": 0.5})
resistance = np.asarray(scene.resistance())
print(np.round(resistance, 4))

# %% [markdown]
# ## Exact values
#
# With the eccentricity `e` and `L = log((1 + e) / (1 - e))`, the drags over `6 pi b` of a prolate
# spheroid with the half length `b`.

# %%
half_length, ratio = 2.0, 2.0
e = np.sqrt(1 - 1 / ratio**2)
log = np.log((1 + e) / (1 - e))
along = 6 * np.pi * half_length * 8 / 3 * e**3 / (-2 * e + (1 + e**2) * log)
across = 6 * np.pi * half_length * 16 / 3 * e**3 / (2 * e + (3 * e**2 - 1) * log)
for name, exact, found in [("along", along, resistance[0, 0]), ("across", across, resistance[1, 1])]:
    print(f"{name:7} exact {exact:.5f}, computed {found:.5f}, relative error {found / exact - 1:+.1e}")
    # Corrected values of elements of half a radius: errors of 1e-4, the order is four or more.
    assert abs(found / exact - 1) < 1e-3

# %% [markdown]
# ## A force across its attitude
#
# The mobility of a spheroid is not isotropic: one that sinks at 45 degrees drifts sideways.

# %%
mobility = np.asarray(scene.mobility())
direction = np.array([1, -1, 0]) / np.sqrt(2)
velocity = mobility[:3, :3] @ direction
drift = np.degrees(np.arccos(velocity @ direction / np.linalg.norm(velocity)))
print(f"angle between force and velocity: {drift:.3f} degrees, exact 3.875")
assert abs(drift - 3.875218) < 0.05
