"""Scenes, and the calls that compute with them."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import Any, overload

import numpy as np

from . import _swimmer
from ._display import Result, Row, vector
from ._progress import Report, reporter
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
from .fields import Flow, Mesh, PointFlow
from .results import Connection, Metric, Mobility, Resistance, Solution, frozen
from .run import Run

__all__ = ["Scene", "templates"]

Path = str | os.PathLike[str]


def templates() -> dict[str, str]:
    """Names and texts of the example scenes.

    Examples
    --------
    >>> list(templates())[:3]
    ['three-sphere', 'smooth', 'chain']
    """
    return dict(_swimmer.templates())


class Scene(Result):
    """A scene that passed all checks: fluid, bodies, links, gait and options.

    A scene does not change. `with_values` returns another one.

    Examples
    --------
    >>> scene = Scene.from_template("three-sphere", {"model.tolerance": 1e-4})
    >>> scene.bodies
    ('left', 'centre', 'right')
    >>> run = scene.run(progress=False)
    >>> abs(run.net - 0.1598053404) < run.net_error < 1e-4 * run.net
    True
    """

    __slots__ = ("_scene",)
    _scene: _swimmer.Scene

    def __init__(self, scene: _swimmer.Scene) -> None:
        if not isinstance(scene, _swimmer.Scene):
            raise TypeError("use Scene.from_file, from_dict, from_toml or from_template")
        self._scene = scene

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles the scene as its text: a file that it names must exist where it is loaded."""
        return (_scene_of_text, (self.to_toml(), f"{self.name}.toml"))

    @classmethod
    def from_file(cls, path: Path, values: Mapping[str, Any] | None = None) -> Scene:
        """The scene of a TOML file.

        Parameters
        ----------
        path : str or os.PathLike
            The file.
        values : mapping, optional
            Keys with the values that replace those of the file, such as `{"gait.cycles": 3}`.

        Raises
        ------
        SceneError
            The first problem, with file, line, key and remedy.
        OSError
            A file that cannot be read.
        """
        return cls(_swimmer.Scene.read(os.fspath(path), _assignments(values)))

    @classmethod
    def from_toml(
        cls, text: str, values: Mapping[str, Any] | None = None, *, path: Path = "scene.toml"
    ) -> Scene:
        """The scene of a TOML text; files that it names are searched beside `path`.

        Examples
        --------
        >>> ball = 'bodies = [{ name = "ball", radius = 1, position = [0, 0, 0] }]'
        >>> Scene.from_toml(ball).bodies
        ('ball',)
        """
        return cls(_swimmer.Scene.parse(text, os.fspath(path), _assignments(values)))

    @classmethod
    def from_dict(
        cls,
        keys: Mapping[str, Any],
        values: Mapping[str, Any] | None = None,
        *,
        path: Path = "scene.toml",
    ) -> Scene:
        """The scene of a dictionary with the keys of a scene file; arrays may be numpy's.

        A key of a group may be given with a dot, `{"fluid.viscosity": 2}`, unless it is in a
        dictionary of the group too.

        Examples
        --------
        >>> ball = {"name": "ball", "radius": 1, "position": np.zeros(3), "force": [1, 0, 0]}
        >>> solution = Scene.from_dict({"bodies": [ball]}).solve()
        >>> round(float(solution.velocity[0, 0]) * 6 * np.pi, 9)
        1.0
        """
        text = json.dumps(keys, default=_plain, allow_nan=False)
        return cls(_swimmer.Scene.from_json(text, os.fspath(path), _assignments(values)))

    @classmethod
    def from_template(cls, name: str, values: Mapping[str, Any] | None = None) -> Scene:
        """One of the example scenes of `templates`."""
        known = templates()
        if name not in known:
            raise _swimmer.SceneError(
                f"unknown example '{name}'; choose one of {', '.join(known)}"
            )
        return cls.from_toml(known[name], values, path=f"{name}.toml")

    templates = staticmethod(templates)

    def with_values(self, values: Mapping[str, Any]) -> Scene:
        """The scene with other values of some keys."""
        return Scene.from_toml(self.to_toml(), values, path=f"{self.name}.toml")

    def to_toml(self) -> str:
        """The scene as TOML with every key written out."""
        return self._scene.to_toml()

    @property
    def name(self) -> str:
        """Name: that of the file without its extension."""
        return self._scene.name

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies."""
        return tuple(self._scene.bodies)

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links."""
        return tuple(self._scene.links)

    @property
    def shape(self) -> np.ndarray:
        """Values of the links at the start: lengths, or angles in radians."""
        return frozen(np.array(self._scene.shape))

    def model(self) -> tuple[str, tuple[str, ...]]:
        """The model that is used, and the reasons for its choice."""
        name, reasons = self._scene.choose()
        return name, tuple(reasons)

    def run(
        self, out: Path | None = None, *, resume: bool = False, progress: bool | Report = True
    ) -> Run:
        """Simulates the gait.

        Ctrl-C ends it; with `out`, `resume=True` continues from the last completed phase.

        Parameters
        ----------
        out : str or os.PathLike, optional
            Folder for the files that `swim run` writes; no files by default.
        resume : bool
            Whether to continue from the checkpoint in `out`.
        progress : bool or callable
            Whether to show a bar of tqdm, if it is installed; or a function of the numbers of
            completed and of all phases and a text, called ten times per second.

        Raises
        ------
        SceneError
            A scene without a gait, or one that the model does not support.
        ToleranceMissed
            A finished run whose error bar is larger than `model.tolerance` allows; its attribute
            `run` has the result. `model.accept = "best"` accepts it.
        RunStopped
            A run whose motion ended before its end, such as at contact; its attribute `run` has
            the result up to there.
        SolveError
            A method that failed.
        """
        if resume and out is None:
            raise _swimmer.SceneError("resume needs the folder of the earlier run; give out")
        folder = None if out is None else os.fspath(out)
        try:
            with reporter(progress, self.name) as report:
                return Run._from_raw(self._scene.run(folder, resume, report))
        except (_swimmer.ToleranceMissed, _swimmer.RunStopped) as error:
            error.run = Run._from_raw(error.result)
            raise

    def solve(self, *, steady: bool = False) -> Solution:
        """The instantaneous solution at the start of the gait; `Run.solve` has other times.

        Parameters
        ----------
        steady : bool
            Whether to find the steady state with the inertia of the fluid, `fluid.density`, instead
            of Stokes flow.

        Examples
        --------
        Stokes drag on a fixed sphere:

        >>> scene = Scene.from_template("three-sphere")
        >>> bool(abs(scene.solve().force.sum()) < 1e-12)
        True
        """
        return Solution._from_raw(self._scene.solve(steady))

    def resistance(self) -> Resistance:
        """Grand resistance matrix of the bodies at the start, without their links."""
        bodies, matrix, error, model = self._scene.resistance()
        return Resistance(tuple(bodies), frozen(matrix), frozen(error), model)

    def mobility(self) -> Mobility:
        """Grand mobility matrix of the bodies at the start, without their links.

        Examples
        --------
        >>> ball = {"name": "ball", "radius": 1, "position": [0, 0, 0]}
        >>> mobility = Scene.from_dict({"bodies": [ball]}).mobility()
        >>> np.allclose(mobility.matrix[:3, :3] * 6 * np.pi, np.eye(3))
        True
        """
        return Mobility._of(self.resistance())

    def connection(self, shape: Sequence[float] | np.ndarray | None = None) -> Connection:
        """Connection of a free swimmer at a shape, by default that of the start.

        Successive calls share one model with its meshes, so that an answer may depend on earlier
        calls within its error bar. Spheres take some ten to hundred microseconds.

        Parameters
        ----------
        shape : sequence of float, optional
            One value per link: a length, or an angle in radians.

        Examples
        --------
        >>> scene = Scene.from_template("three-sphere")
        >>> connection = scene.connection([10, 10])
        >>> connection.origin
        'left'

        If both arms open, the middle is at rest and the origin goes to the left:

        >>> round(float(connection.matrix[0].sum()), 12)
        -1.0
        """
        return self._connection(shape)[0]

    def metric(self, shape: Sequence[float] | np.ndarray | None = None) -> Metric:
        """Dissipation metric of a free swimmer at a shape, by default that of the start."""
        return self._connection(shape)[1]

    def _connection(self, shape: Any) -> tuple[Connection, Metric]:
        shape = self._scene.shape if shape is None else shape
        arrays, names, origin, seconds = self._scene.connection(shape)
        matrix, error, metric, metric_error = map(frozen, arrays)
        links = tuple(names)
        return (
            Connection(links, frozen(matrix.T), error, origin, seconds),
            Metric(links, metric, metric_error, seconds),
        )

    def optimise(self, out: Path | None = None, *, progress: bool | Report = True) -> Optimum:
        """The best stroke by the group `optimise` of the scene.

        Parameters
        ----------
        out : str or os.PathLike, optional
            Folder for `optimum.toml` and for the table, which a later search reuses.
        progress : bool or callable
            As for `run`.
        """
        folder = None if out is None else os.fspath(out)
        with reporter(progress, f"optimise {self.name}") as report:
            return Optimum._from_raw(self._scene.optimise(folder, report))

    def sweep(
        self,
        vary: Mapping[str, str | Sequence[Any] | np.ndarray],
        *,
        random: int | None = None,
        seed: int = 1,
        jobs: int | None = None,
        out: Path | None = None,
        resume: bool = False,
        progress: bool | Report = True,
    ) -> Sweep:
        """Runs with other values of some keys; a run that fails is a row with its reason.

        Parameters
        ----------
        vary : mapping
            Keys with their values, of which all combinations are run: a sequence, or text as for
            `swim sweep --vary`, such as `"0.5:2:7"` or `"1:100:3:log"`. Also
            `links.NAME.length`, for which bodies are moved and the gait is shifted, and
            `links.NAME.amplitude`.
        random : int, optional
            Number of random points instead; then `"0.5:2"` are the ends of a range.
        seed : int
            Seed of the random points.
        jobs : int, optional
            Number of runs at the same time, by default that of the threads.
        out : str or os.PathLike, optional
            Folder for `sweep.csv`; with `resume=True` an interrupted sweep there continues.
        progress : bool or callable
            As for `run`.

        Examples
        --------
        Stokes drag:

        >>> ball = {"name": "a", "radius": 1, "position": [0, 0, 0], "force": [6 * np.pi, 0, 0]}
        >>> scene = Scene.from_dict({"bodies": [ball], "gait": {"phases": [{"duration": 1}]}})
        >>> found = scene.sweep({"bodies.a.radius": [1, 2, 4]}, progress=False)
        >>> found.displacement[:, 0].round(9).tolist()
        [1.0, 0.5, 0.25]
        """
        keys = [
            (key, values if isinstance(values, str) else [_toml_value(value) for value in values])
            for key, values in vary.items()
        ]
        folder = None if out is None else os.fspath(out)
        with reporter(progress, f"sweep {self.name}") as report:
            raw = self._scene.sweep(keys, random, seed, jobs, folder, resume, report)
        return Sweep._from_raw(json.loads(raw))

    def sensitivities(self, *, progress: bool | Report = True) -> tuple[Sensitivity, ...]:
        """Derivatives of the net displacement by radii, lengths, amplitudes and springs.

        Four runs each. `progress` is as for `run`.
        """
        with reporter(progress, f"sensitivities of {self.name}") as report:
            raw = self._scene.sensitivities(report)
        found = ((entry.pop("parameter"), entry) for entry in json.loads(raw))
        return tuple(Sensitivity(name=name, **entry) for name, entry in found)

    def best_frequency(self, *, progress: bool | Report = True) -> BestFrequency:
        """The frequency of the largest net displacement per cycle; `progress` is as for `run`."""
        with reporter(progress, f"frequency of {self.name}") as report:
            return BestFrequency._from_raw(json.loads(self._scene.best_frequency(report)))

    def best_sizes(self, *, progress: bool | Report = True) -> BestSizes:
        """The best radii and arm lengths, `optimise.radii` and `optimise.arms` of the scene.

        `progress` is as for `run`.
        """
        with reporter(progress, f"sizes of {self.name}") as report:
            return BestSizes._from_raw(json.loads(self._scene.best_sizes(report)))

    def best_wave(self, out: Path | None = None, *, progress: bool | Report = True) -> BestWave:
        """The best wave of a tube that undulates, by a table of runs.

        Its amplitude has the limits `optimise.lower` and `optimise.upper` of the scene, its number
        of waves those of `optimise.waves`.

        Parameters
        ----------
        out : str or os.PathLike, optional
            Folder for `optimum.toml` and for the rows of the table.
        progress : bool or callable
            As for `run`.
        """
        folder = None if out is None else os.fspath(out)
        with reporter(progress, f"best wave of {self.name}") as report:
            return BestWave._from_raw(json.loads(self._scene.best_wave(folder, report)))

    def map(self, out: Path | None = None, *, progress: bool | Report = True) -> StrokeMap:
        """Connection, curvature and metric over the shapes, as `swim map`.

        The values of the joints have the limits `optimise.lower` and `optimise.upper` of the scene,
        by default those of its gait.

        Parameters
        ----------
        out : str or os.PathLike, optional
            Folder for the table, which later calls and `optimise` reuse.
        progress : bool or callable
            As for `run`.

        Examples
        --------
        The curvature of the connection of three spheres on a grid of shapes:

        >>> scene = Scene.from_template("three-sphere")
        >>> heights = scene.map(progress=False)
        >>> heights.links
        ('left-arm', 'right-arm')
        >>> heights.curvature(heights.grid(5)).shape
        (5, 5, 6)
        """
        folder = None if out is None else os.fspath(out)
        with reporter(progress, f"map of {self.name}") as report:
            return StrokeMap._of(self._scene.map(folder, report))

    def learn(self, *, progress: bool | Report = True) -> LearnedStroke:
        """A stroke by reinforcement learning, beside the best possible one, as `swim learn`.

        The group `learn` of the scene has the states and the options. `Swimmer` is an environment
        for other methods. `progress` is as for `run`.

        Examples
        --------
        >>> scene = Scene.from_template("three-sphere", {"learn.contracted": 6})
        >>> scene.learn(progress=False).is_optimal
        True
        """
        with reporter(progress, f"learn {self.name}") as report:
            return LearnedStroke._from_raw(json.loads(self._scene.learn(report)))

    def mesh(self) -> Mesh:
        """The mesh at the start, for finite elements."""
        return Mesh._from_raw(self._scene.mesh())

    @overload
    def flow(self, points: None = None) -> Flow: ...
    @overload
    def flow(self, points: Any) -> PointFlow: ...
    def flow(self, points: Any = None) -> Flow | PointFlow:
        """The flow at the start; `Run.flow` has that at other times.

        Without points it is the flow on the mesh of the model, or on one generated for a picture.

        Parameters
        ----------
        points : array_like, optional
            Coordinates, the last axis of length three. For spheres without a mesh, velocities are
            those of the expansions to a thousandth; for finite elements they are interpolated.

        Returns
        -------
        Flow or PointFlow
            Velocity and pressure on a mesh, or at the points.

        Examples
        --------
        >>> scene = Scene.from_template("three-sphere")
        >>> flow = scene.flow([[0, 0, 1], [0, 0, 0.5]])
        >>> bool(np.allclose(flow.velocity[0], scene.solve().velocity[1], atol=1e-2))
        True
        >>> flow.is_fluid
        array([ True, False])
        """
        if points is None:
            return Flow._from_raw(self._scene.flow())
        return PointFlow._at(points, self._scene.flow_at)

    def _rows(self) -> list[Row]:
        rows = [("name", self.name), ("bodies", ", ".join(self.bodies))]
        if self.links:
            rows += [("links", ", ".join(self.links)), ("shape", vector(self.shape))]
        return rows


def _scene_of_text(text: str, path: str) -> Scene:
    return Scene.from_toml(text, path=path)


def _assignments(values: Mapping[str, Any] | None) -> list[str]:
    return [f"{key}={_toml_value(value)}" for key, value in (values or {}).items()]


def _toml_value(value: Any) -> str:
    if isinstance(value, Mapping):
        entries = (f"{json.dumps(key)} = {_toml_value(entry)}" for key, entry in value.items())
        return f"{{ {', '.join(entries)} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml_value, value))}]"
    # JSON of numbers, texts and truth values is TOML.
    return json.dumps(value, default=_plain, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} is no value of a scene")
