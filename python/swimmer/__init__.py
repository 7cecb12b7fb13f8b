"""Micro-swimmers and rigid bodies in Stokes flow, with an error bar beside every number.

Examples
--------
>>> import swimmer
>>> scene = swimmer.Scene.from_template("three-sphere")
>>> run = scene.run(progress=False)
>>> print(f"{run.net:.4f}, error below {1e-3:.0e}: {run.net_error < 1e-3 * run.net}")
0.1598, error below 1e-03: True
"""

from ._swimmer import (
    InternalError,
    RunStopped,
    SceneError,
    SolveError,
    ToleranceMissed,
    __version__,
)
from .environment import Swimmer
from .fields import Flow, Mesh, PointFlow
from .results import (
    BestFrequency,
    BestSizes,
    BestWave,
    Connection,
    ErrorBars,
    Metric,
    Mobility,
    Optimum,
    Phase,
    Resistance,
    Run,
    Sensitivity,
    Solution,
    Sweep,
    SwimmerResult,
)
from .scene import Scene, templates

__all__ = [
    "BestFrequency",
    "BestSizes",
    "BestWave",
    "Connection",
    "ErrorBars",
    "Flow",
    "InternalError",
    "Mesh",
    "Metric",
    "Mobility",
    "Optimum",
    "Phase",
    "PointFlow",
    "Resistance",
    "Run",
    "RunStopped",
    "Scene",
    "SceneError",
    "Sensitivity",
    "Solution",
    "SolveError",
    "Sweep",
    "Swimmer",
    "SwimmerResult",
    "ToleranceMissed",
    "__version__",
    "templates",
]
