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
from .designs import (
    BestFrequency,
    BestSizes,
    BestWave,
    LearnedStroke,
    Optimum,
    Sensitivity,
    StrokeMap,
    Sweep,
)
from .environment import Swimmer
from .fields import Flow, Mesh, PointFlow
from .results import Connection, ErrorBars, MeanFlow, Metric, Mobility, Resistance, Solution
from .run import Phase, Run, SwimmerResult, Trajectory
from .scene import Scene, templates

__all__ = [
    "BestFrequency",
    "BestSizes",
    "BestWave",
    "Connection",
    "ErrorBars",
    "Flow",
    "InternalError",
    "LearnedStroke",
    "MeanFlow",
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
    "StrokeMap",
    "Sweep",
    "Swimmer",
    "SwimmerResult",
    "ToleranceMissed",
    "Trajectory",
    "__version__",
    "templates",
]
