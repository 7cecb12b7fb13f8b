"""Results of a gait."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, overload

import numpy as np

from ._display import Result, Row, largest, vector, with_error
from .fields import Flow, PointFlow
from .results import ErrorBars, MeanFlow, Solution, _data_frame, _from_raw, frozen

__all__ = [
    "Phase",
    "Run",
    "SwimmerResult",
    "Trajectory",
]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Phase(Result):
    """One phase of a run: the link that moves, displacements of the bodies, error bars."""

    link: str
    displacement: np.ndarray
    errors: ErrorBars
    solves: int

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> Phase:
        return _from_raw(cls, raw, errors=ErrorBars(**raw["errors"]))

    def _rows(self) -> list[Row]:
        moved = with_error(largest(self.displacement), self.errors.total)
        return [("link", self.link), ("largest displacement", moved), ("solves", str(self.solves))]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class SwimmerResult(Result):
    """One swimmer of a run with several, in the scene's units.

    Attributes
    ----------
    name : str
        Name of its first body.
    bodies : tuple of str
        Its bodies.
    displacement : numpy.ndarray
        Mean displacement of its moving bodies.
    errors : ErrorBars
        Error bars of the displacements of its bodies; `error` is their sum.
    rotation : numpy.ndarray
        Rotation vector of its root, with full turns: of its first body, or of the first one whose
        velocity is given.
    rotation_errors : ErrorBars
        Error bars of the rotation, in radians.
    work : float or None
        Work of its bodies on the fluid; None where it is known for all together only: with slip or
        inertia.
    work_errors : ErrorBars or None
        Error bars of the work, where it is known.
    """

    name: str
    bodies: tuple[str, ...]
    displacement: np.ndarray
    errors: ErrorBars
    rotation: np.ndarray
    rotation_errors: ErrorBars
    work: float | None
    work_errors: ErrorBars | None

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> SwimmerResult:
        bars = {name: ErrorBars(**raw[name]) for name in ("errors", "rotation_errors")}
        of_work = raw["work_errors"]
        work_errors = None if of_work is None else ErrorBars(**of_work)
        return _from_raw(cls, raw, **bars, work_errors=work_errors)

    @property
    def error(self) -> float:
        """Error bar of the displacement, the sum over the sources."""
        return self.errors.total

    def _rows(self) -> list[Row]:
        rows = [
            ("swimmer", self.name),
            ("displacement", vector(self.displacement)),
            ("error bar", f"{self.error:.2g}"),
            ("rotation vector", vector(self.rotation)),
        ]
        if self.work is None or self.work_errors is None:
            return rows
        return [*rows, ("work", with_error(self.work, self.work_errors.total))]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Trajectory(Result):
    """Positions and rates at times of a run.

    Attributes
    ----------
    times : numpy.ndarray
        The times.
    lengths, rates : numpy.ndarray
        Values of the links `(time, link)`, and the rates that the gait prescribes; zero for links
        that it does not.
    positions, quaternions : numpy.ndarray
        Centres of the bodies `(time, body, xyz)`, attitudes `(time, body, xyzw)`.
    """

    bodies: tuple[str, ...]
    links: tuple[str, ...]
    times: np.ndarray
    lengths: np.ndarray
    rates: np.ndarray
    positions: np.ndarray
    quaternions: np.ndarray

    def _rows(self) -> list[Row]:
        times = f"{len(self.times)}"
        if len(self.times):
            times += f", from {self.times.min():g} to {self.times.max():g}"
        return [("bodies", ", ".join(self.bodies)), ("times", times)]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Run(Result):
    """A finished gait, in the scene's units.

    Attributes
    ----------
    displacement : numpy.ndarray
        Displacement of each body, one row each.
    net : float
        Net displacement: the distance that the mean of the centres of the moving bodies covers.
    errors : ErrorBars
        Error bars of the displacements by source; `net_error` is their sum.
    rotation : numpy.ndarray
        Rotation vector of the frame of the first linkage, with `rotation_error` in radians.
    work : float
        Work of the bodies on the fluid, with `work_error`.
    efficiency : float or None
        Lighthill's efficiency of a free swimmer that returned to its shape, with the error bar
        `efficiency_error`; None for other runs.
    held : tuple of str
        The bodies whose velocity is given.
    mean_force, mean_torque : numpy.ndarray
        Mean force and torque over the run that hold or drive these bodies, one row each, with
        `mean_force_error` and `mean_torque_error`. The mean thrust of a tethered swimmer is
        opposite.
    mean_flow : MeanFlow or None
        Mean flow and pressure gradient of a periodic box over the run; None in other domains.
    phases : tuple of Phase
        Displacement of each phase.
    swimmers : tuple of SwimmerResult
        Results of each connected set of bodies that can move itself; empty for a single one.
    times, lengths, positions, quaternions : numpy.ndarray
        The trajectory at the solves and the ends of the phases, or at equal intervals of time with
        `output.samples`: values of the links, centres `(time, body, xyz)`, attitudes
        `(time, body, xyzw)`. `at` has other times.
    velocities, angular_velocities, forces, torques : numpy.ndarray
        Those of the bodies at these times, `(time, body, xyz)`. Where nothing was solved they are
        interpolated between solves, with more error; at the ends of phases they are those before
        it. `solve` has them at any time with error bars.
    solved : numpy.ndarray
        Whether they were solved for at each of these times.
    curve_times, curve_positions : numpy.ndarray
        Centres on a finer grid, for plots.
    model : str
        The model, and in `reasons` why it was chosen.
    solves : int
        Number of instantaneous solutions.
    seconds : dict
        Wall-clock seconds.
    """

    scene: str
    model: str
    reasons: tuple[str, ...]
    bodies: tuple[str, ...]
    links: tuple[str, ...]
    displacement: np.ndarray
    net: float
    errors: ErrorBars
    rotation: np.ndarray
    rotation_errors: ErrorBars
    work: float
    work_errors: ErrorBars
    efficiency: float | None
    efficiency_error: float | None
    held: tuple[str, ...]
    mean_force: np.ndarray
    mean_force_errors: ErrorBars
    mean_torque: np.ndarray
    mean_torque_errors: ErrorBars
    mean_flow: MeanFlow | None
    tolerance: float
    tolerance_met: bool
    phases: tuple[Phase, ...]
    swimmers: tuple[SwimmerResult, ...]
    times: np.ndarray
    lengths: np.ndarray
    positions: np.ndarray
    quaternions: np.ndarray
    velocities: np.ndarray
    angular_velocities: np.ndarray
    forces: np.ndarray
    torques: np.ndarray
    solved: np.ndarray
    curve_times: np.ndarray
    curve_positions: np.ndarray
    solves: int
    seconds: dict[str, float]
    _motion: Any = field(repr=False)

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> Run:
        names = (
            "errors",
            "rotation_errors",
            "work_errors",
            "mean_force_errors",
            "mean_torque_errors",
        )
        bars = {name: ErrorBars(**raw[name]) for name in names}
        phases = tuple(Phase._from_raw(phase) for phase in raw["phases"])
        swimmers = tuple(SwimmerResult._from_raw(swimmer) for swimmer in raw["swimmers"])
        flow = MeanFlow._from_raw(raw["mean_flow"])
        return _from_raw(cls, raw, phases=phases, swimmers=swimmers, mean_flow=flow, **bars)

    def to_dataframe(self) -> Any:
        """The trajectory as a `pandas.DataFrame`.

        One row per time; columns `time`, `solved`, the names of the links, and for each body
        `NAME.x` to `.z`, `.qx` to `.qw`, `.vx`, `.wx` (velocity, angular velocity), `.fx`, `.tx` (force and
        torque on the fluid) and so on.
        """
        columns: dict[str, Any] = {"time": self.times, "solved": self.solved}
        columns |= {link: self.lengths[:, number] for number, link in enumerate(self.links)}
        for number, body in enumerate(self.bodies):
            for prefix, array in [
                ("", self.positions),
                ("q", self.quaternions),
                ("v", self.velocities),
                ("w", self.angular_velocities),
                ("f", self.forces),
                ("t", self.torques),
            ]:
                names = "xyzw"[: array.shape[-1]]
                parts = zip(names, array[:, number].T, strict=True)
                columns |= {f"{body}.{prefix}{name}": part for name, part in parts}
        return _data_frame(columns)

    def at(self, times: float | Sequence[float] | np.ndarray) -> Trajectory:
        """Positions of the bodies and rates of the links at any times of the run.

        They are those of the path that was integrated, without further solves. A run that continued
        an earlier one knows the phases since then.

        Examples
        --------
        >>> from swimmer import Scene
        >>> run = Scene.from_template("three-sphere").run(progress=False)
        >>> path = run.at(np.linspace(0, 4, 9))
        >>> bool(abs(path.positions[-1, 1, 0] - run.positions[-1, 1, 0]) < 1e-12)
        True
        """
        times = np.atleast_1d(np.asarray(times, dtype=float))
        if times.ndim != 1:
            raise ValueError(f"times are a number or a list of them, not of shape {times.shape}")
        arrays = map(frozen, self._motion.at(times))
        return Trajectory(self.bodies, self.links, frozen(times.copy()), *arrays)

    def solve(self, time: float) -> Solution:
        """The instantaneous solution at a time: velocities, forces and their error bars.

        Where two phases meet it is that of the later one.

        Raises
        ------
        SceneError
            A time outside the run, or a run with inertia or thermal noise, whose velocities depend
            on more than positions and rates.
        """
        return Solution._from_raw(self._motion.solve(float(time)))

    @overload
    def flow(self, time: float, points: None = None) -> Flow: ...
    @overload
    def flow(self, time: float, points: Any) -> PointFlow: ...
    def flow(self, time: float, points: Any = None) -> Flow | PointFlow:
        """The flow at a time: on a mesh, or at points as for `Scene.flow`.

        Examples
        --------
        The fluid at the surface of the middle sphere has the velocity of that sphere:

        >>> from swimmer import Scene
        >>> run = Scene.from_template("three-sphere").run(progress=False)
        >>> centre = run.at(2.5).positions[0, 1]
        >>> flow = run.flow(2.5, centre + [0, 0, 1])
        >>> bool(np.allclose(flow.velocity, run.solve(2.5).velocity[1], atol=1e-2))
        True
        """
        time = float(time)
        if points is None:
            return Flow._from_raw(self._motion.flow(time))
        return PointFlow._at(points, lambda points: self._motion.flow_at(time, points))

    @property
    def net_error(self) -> float:
        """Error bar of the net displacement and of all displacements, summed over the sources."""
        return self.errors.total

    @property
    def rotation_error(self) -> float:
        """Error bar of the rotation, the sum over the sources."""
        return self.rotation_errors.total

    @property
    def work_error(self) -> float:
        """Error bar of the work, the sum over the sources."""
        return self.work_errors.total

    @property
    def mean_force_error(self) -> float:
        """Error bar of the mean forces that hold bodies, the sum over the sources."""
        return self.mean_force_errors.total

    @property
    def mean_torque_error(self) -> float:
        """Error bar of the mean torques that hold bodies, the sum over the sources."""
        return self.mean_torque_errors.total

    def _rows(self) -> list[Row]:
        rows = [
            ("scene", self.scene),
            ("model", self.model),
            ("net displacement", with_error(self.net, self.net_error)),
        ]
        for number, body in enumerate(self.bodies):
            rows.append((f"displacement of {body}", vector(self.displacement[number])))
        if self.efficiency is not None:
            value = with_error(self.efficiency, self.efficiency_error)
            rows.append(("Lighthill efficiency", value))
        return [
            *rows,
            ("rotation vector", vector(self.rotation)),
            ("work on the fluid", with_error(self.work, self.work_error)),
            ("tolerance", f"{self.tolerance:g}, {'met' if self.tolerance_met else 'missed'}"),
            ("cost", f"{self.solves} solves, {self.seconds['total']:.3g} s"),
        ]
