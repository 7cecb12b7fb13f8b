"""Results: frozen records of numbers and arrays, with error bars beside the numbers."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ._display import Result, Row, largest, vector, with_error

__all__ = [
    "BestFrequency",
    "BestSizes",
    "Connection",
    "ErrorBars",
    "Metric",
    "Mobility",
    "Optimum",
    "Phase",
    "Resistance",
    "Run",
    "Sensitivity",
    "Solution",
    "Sweep",
    "SwimmerResult",
]


def _data_frame(columns: dict[str, Any]) -> Any:
    """A frame of pandas, which is imported for it only."""
    try:
        import pandas
    except ImportError as error:
        raise ImportError("to_dataframe needs pandas: pip install pandas") from error
    return pandas.DataFrame(columns)


def frozen(value: Any) -> Any:
    """The value; arrays in it cannot be written to any more, lists become tuples."""
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    elif isinstance(value, list):
        return tuple(value)
    return value


def _from_raw(kind: Any, raw: dict[str, Any], **changes: Any) -> Any:
    names = (entry.name for entry in fields(kind))
    values = {name: frozen(raw[name]) for name in names if name in raw}
    return kind(**(values | changes))


@dataclass(frozen=True, slots=True, repr=False)
class ErrorBars(Result):
    """Error bars of a quantity by source, in its units; None for a source that was not estimated.

    Attributes
    ----------
    mesh : float or None
        Discretisation on a mesh.
    container : float or None
        A finite container instead of unbounded fluid.
    model : float or None
        Deviation of the model from Stokes flow.
    algebraic : float or None
        Tolerance of the linear solver.
    integration : float or None
        Time integration along the gait.

    Examples
    --------
    >>> bars = ErrorBars(mesh=0.5, integration=0.25)
    >>> bars.total
    0.75
    >>> bars.not_estimated
    ('container', 'model', 'algebraic')
    """

    mesh: float | None = None
    container: float | None = None
    model: float | None = None
    algebraic: float | None = None
    integration: float | None = None

    @property
    def total(self) -> float:
        """Sum of the estimated error bars."""
        return sum(self.by_source.values())

    @property
    def by_source(self) -> dict[str, float]:
        """The estimated error bars by the name of their source."""
        values = ((entry.name, getattr(self, entry.name)) for entry in fields(self))
        return {name: value for name, value in values if value is not None}

    @property
    def not_estimated(self) -> tuple[str, ...]:
        """Names of the sources without an estimate."""
        return tuple(entry.name for entry in fields(self) if getattr(self, entry.name) is None)

    def _rows(self) -> list[Row]:
        rows = [(name, f"{value:.2g}") for name, value in self.by_source.items()]
        missing = [(name, "not estimated") for name in self.not_estimated]
        return [*rows, ("total", f"{self.total:.2g}"), *missing]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Solution(Result):
    """Velocities and forces of one instant, in the scene's units.

    Attributes
    ----------
    bodies, links : tuple of str
        Names, in the order of the rows of the arrays.
    velocity, angular_velocity, force, torque : numpy.ndarray
        One row per body. Forces and torques are those that the bodies exert on the fluid.
    link_force : numpy.ndarray
        One row per link: the force of the link on the body named by its key `body`.
    link_torque : numpy.ndarray
        One row per link: its torque on this body about the pivot; zero for links without one.
    link_drive : numpy.ndarray
        One number per link: the force of its drive, or the torque if its value is an angle. Its
        power on the bodies is this number times the rate of the link.
    stresslet : numpy.ndarray or None
        One symmetric 3 x 3 matrix without trace per body, with the sign of Batchelor (1970): the
        first moment of the traction of the fluid on the body, positive along the axis of a puller.
        None for the models `oseen` and `rpy`.
    stresslet_error : float or None
        Error bar of the Frobenius norms of the stresslets; None if it was not estimated.
    velocity_errors, angular_velocity_errors, force_errors, torque_errors : ErrorBars
        Error bars of the largest velocity, angular velocity, force and torque by source.
    power : float
        Power of the bodies on the fluid.
    power_errors : ErrorBars
        Error bars of the power by source.
    model, formulation, solver : str
        How the flow was computed.
    dofs, iterations : int
        Size of the linear system, and iterations for it.
    residual : float
        True relative residual.
    seconds : dict
        Wall-clock seconds of the parts of the work.
    """

    model: str
    bodies: tuple[str, ...]
    links: tuple[str, ...]
    velocity: np.ndarray
    angular_velocity: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    link_force: np.ndarray
    link_torque: np.ndarray
    link_drive: np.ndarray
    stresslet: np.ndarray | None
    stresslet_error: float | None
    velocity_errors: ErrorBars
    angular_velocity_errors: ErrorBars
    force_errors: ErrorBars
    torque_errors: ErrorBars
    power: float
    power_errors: ErrorBars
    dofs: int
    formulation: str
    solver: str
    iterations: int
    residual: float
    seconds: dict[str, float]

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> Solution:
        kinds = ("velocity", "angular_velocity", "force", "torque", "power")
        names = [f"{kind}_errors" for kind in kinds]
        return _from_raw(cls, raw, **{name: ErrorBars(**raw[name]) for name in names})

    @property
    def velocity_error(self) -> float:
        """Error bar of the velocities, the sum over the sources."""
        return self.velocity_errors.total

    @property
    def angular_velocity_error(self) -> float:
        """Error bar of the angular velocities, the sum over the sources."""
        return self.angular_velocity_errors.total

    @property
    def force_error(self) -> float:
        """Error bar of the forces, the sum over the sources."""
        return self.force_errors.total

    @property
    def torque_error(self) -> float:
        """Error bar of the torques, the sum over the sources."""
        return self.torque_errors.total

    @property
    def power_error(self) -> float:
        """Error bar of the power, the sum over the sources."""
        return self.power_errors.total

    def _rows(self) -> list[Row]:
        rows = [("model", self.model)]
        for number, body in enumerate(self.bodies):
            rows.append((f"velocity of {body}", vector(self.velocity[number])))
            rows.append((f"force of {body}", vector(self.force[number])))
        speed = with_error(largest(self.velocity), self.velocity_error)
        rows.append(("largest velocity", speed))
        rows.append(("largest force", with_error(largest(self.force), self.force_error)))
        if self.stresslet is not None and self.stresslet_error is not None:
            norm = float(np.linalg.norm(self.stresslet, axis=(1, 2)).max())
            rows.append(("largest stresslet", with_error(norm, self.stresslet_error)))
        rows.append(("power", with_error(self.power, self.power_error)))
        work = f"{self.dofs} degrees of freedom, {self.seconds['total']:.3g} s"
        return [*rows, ("cost", work)]


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
    work : float or None
        Work of its bodies on the fluid; None where it is known for all together only: with slip or
        inertia.
    """

    name: str
    bodies: tuple[str, ...]
    displacement: np.ndarray
    errors: ErrorBars
    rotation: np.ndarray
    work: float | None

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> SwimmerResult:
        return _from_raw(cls, raw, errors=ErrorBars(**raw["errors"]))

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
        return rows if self.work is None else [*rows, ("work", f"{self.work:.6g}")]


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
    phases : tuple of Phase
        Displacement of each phase.
    swimmers : tuple of SwimmerResult
        Results of each connected set of bodies that can move itself; empty for a single one.
    times, lengths, positions, quaternions : numpy.ndarray
        The trajectory at the solves and the ends of the phases: values of the links, centres
        `(time, body, xyz)`, attitudes `(time, body, xyzw)`.
    velocities, angular_velocities, forces, torques : numpy.ndarray
        Those of the bodies at these times, `(time, body, xyz)`; NaN at the ends of phases, where
        they are not computed.
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
    curve_times: np.ndarray
    curve_positions: np.ndarray
    solves: int
    seconds: dict[str, float]

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
        return _from_raw(cls, raw, phases=phases, swimmers=swimmers, **bars)

    def to_dataframe(self) -> Any:
        """The trajectory as a `pandas.DataFrame`.

        One row per time; columns `time`, the names of the links, and for each body `NAME.x` to
        `.z`, `.qx` to `.qw`, `.vx`, `.wx` (velocity, angular velocity), `.fx`, `.tx` (force and
        torque on the fluid) and so on.
        """
        columns: dict[str, Any] = {"time": self.times}
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


class _Array(Result):
    """A result that numpy takes as its array `matrix`."""

    __slots__ = ()
    matrix: np.ndarray

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        array = self.matrix if dtype is None else self.matrix.astype(dtype)
        return array.copy() if copy else array


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class _BodyMatrix(_Array):
    """A symmetric matrix with six rows and columns per body."""

    bodies: tuple[str, ...]
    matrix: np.ndarray
    error: np.ndarray | None
    model: str

    def block(self, first: str, second: str) -> np.ndarray:
        """The 6 x 6 block of the rows of one body and the columns of another."""
        rows, columns = (6 * self.bodies.index(name) for name in (first, second))
        return self.matrix[rows : rows + 6, columns : columns + 6]

    def _rows(self) -> list[Row]:
        size = f"{len(self.matrix)} x {len(self.matrix)}, six rows per body"
        rows = [("model", self.model), ("bodies", ", ".join(self.bodies)), ("matrix", size)]
        for number, body in enumerate(self.bodies):
            at = 6 * number
            bar = None if self.error is None else float(self.error[at, at])
            rows.append((f"{body}, x to x", with_error(float(self.matrix[at, at]), bar)))
        return rows


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Resistance(_BodyMatrix):
    """Grand resistance matrix `R` of the bodies without their links: `(F, T) = R (U, omega)`.

    Forces are those on the fluid. `numpy` functions take the result as its `matrix`.

    Attributes
    ----------
    bodies : tuple of str
        Bodies with a surface, six rows and columns each: velocity, then angular velocity.
    matrix : numpy.ndarray
        The matrix.
    error : numpy.ndarray or None
        Error bars of its entries; None if the model does not estimate them (finite elements).
    model : str
        The model.
    """


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Mobility(_BodyMatrix):
    """Grand mobility matrix: the inverse of `Resistance`, `(U, omega) = M (F, T)`.

    Attributes
    ----------
    bodies, matrix, error, model
        As those of `Resistance`. To first order an error `dR` changes the inverse by `-M dR M`,
        so the error bars are `abs(M) error(R) abs(M)`.
    """

    @classmethod
    def _of(cls, resistance: Resistance) -> Mobility:
        inverse = np.linalg.inv(resistance.matrix)
        inverse = 0.5 * (inverse + inverse.T)
        error = None
        if resistance.error is not None:
            error = frozen(np.abs(inverse) @ resistance.error @ np.abs(inverse))
        return cls(resistance.bodies, frozen(inverse), error, resistance.model)


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Connection(_Array):
    """Connection `A(s)` at one shape: `(v, omega) = A ds/dt` for the frame of the swimmer.

    The origin of the frame is the centre of the body `origin`, its attitude that of the scene.

    `numpy` functions take the result as its `matrix`.

    Attributes
    ----------
    links : tuple of str
        The links whose values are the shape, one column each.
    origin : str
        The body whose velocity the first three rows are.
    matrix : numpy.ndarray
        Six rows: velocity of the frame and its angular velocity for a unit rate of each link.
    error : numpy.ndarray
        Error bar of the velocities for a unit rate of each link.
    seconds : float
        Seconds that the library took.
    """

    links: tuple[str, ...]
    matrix: np.ndarray
    error: np.ndarray
    origin: str
    seconds: float

    def _rows(self) -> list[Row]:
        rows = [("origin", self.origin)]
        for number, link in enumerate(self.links):
            column = self.matrix[:, number]
            speed = with_error(float(np.linalg.norm(column[:3])), float(self.error[number]))
            rows.append((f"velocity by {link}", vector(column[:3])))
            rows.append(("  its size", speed))
            rows.append(("  angular velocity", vector(column[3:])))
        return rows


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Metric(_Array):
    """Dissipation metric `G(s)` at one shape: the power on the fluid is `ds/dt . G ds/dt`.

    `numpy` functions take the result as its `matrix`.

    Attributes
    ----------
    links : tuple of str
        The links whose values are the shape, one row and column each.
    matrix, error : numpy.ndarray
        The metric, and the error bars of its entries.
    seconds : float
        Seconds that the library took.
    """

    links: tuple[str, ...]
    matrix: np.ndarray
    error: np.ndarray
    seconds: float

    def _rows(self) -> list[Row]:
        pairs = [(i, j) for i in range(len(self.links)) for j in range(i + 1)]
        return [
            (
                f"{self.links[i]}, {self.links[j]}",
                with_error(float(self.matrix[i, j]), float(self.error[i, j])),
            )
            for i, j in pairs
        ]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Optimum(Result):
    """The best stroke of a scene, in the scene's units.

    Attributes
    ----------
    objective : str
        What was optimised.
    displacement : float
        Displacement by the table of the search, with `displacement_error`.
    run_displacement : float
        Displacement of the frame in a run of the stroke by the full model, with `run_errors`.
    energy : float
        Work of that run, with `energy_errors`.
    efficiency : float
        Lighthill efficiency.
    period, period_energy_product : float
        Period, and period times energy at constant power.
    refinement_error : float
        Change of the objective by the last increase of the number of terms.
    at_limits : bool
        Whether the stroke touches the limits of the joints.
    links : tuple of str
        Names of the links.
    lengths : numpy.ndarray
        Values of all links at equal steps of time, one row each, from the start to the end.
    toml : str
        The scene of the stroke; `Scene.from_toml(optimum.toml)` runs it.
    """

    objective: str
    model: str
    links: tuple[str, ...]
    displacement: float
    displacement_error: float
    displacement_vector: np.ndarray
    rotation: np.ndarray
    run_displacement: float
    run_errors: ErrorBars
    energy: float
    energy_errors: ErrorBars
    period: float
    period_energy_product: float
    efficiency: float
    refinement_error: float
    at_limits: bool
    lengths: np.ndarray
    toml: str

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> Optimum:
        bars = {name: ErrorBars(**raw[name]) for name in ("run_errors", "energy_errors")}
        return _from_raw(cls, raw, **bars)

    def _rows(self) -> list[Row]:
        return [
            ("objective", self.objective),
            ("model", self.model),
            ("displacement by table", with_error(self.displacement, self.displacement_error)),
            ("  by the model", with_error(self.run_displacement, self.run_errors.total)),
            ("energy by the model", with_error(self.energy, self.energy_errors.total)),
            ("energy times period", f"{self.period_energy_product:.6f} at constant power"),
            ("Lighthill efficiency", f"{self.efficiency:.4e}"),
            ("last refinement", f"{self.refinement_error:.2g}"),
            ("at the limits", "yes" if self.at_limits else "no"),
        ]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Sweep(Result):
    """Runs of a scene with other values of some keys, one row each.

    Attributes
    ----------
    keys : tuple of str
        The keys that vary.
    values : tuple of tuple
        Their values in each row: numbers, or text as it is written in a scene.
    status : tuple of str
        `"met"`, `"tolerance missed"`, or why the run stopped or failed.
    model : tuple of str
        The model of each run.
    displacement, rotation : numpy.ndarray
        Net displacement and rotation vector, one row each; NaN for a run that failed.
    displacement_error, rotation_error, work, work_error, seconds : numpy.ndarray
        Error bars, work on the fluid, and wall-clock time.
    """

    keys: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...]
    status: tuple[str, ...]
    model: tuple[str, ...]
    displacement: np.ndarray
    displacement_error: np.ndarray
    rotation: np.ndarray
    rotation_error: np.ndarray
    work: np.ndarray
    work_error: np.ndarray
    seconds: np.ndarray

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> Sweep:
        rows = raw["rows"]
        results = [row["result"] or {} for row in rows]

        def numbers(name: str, missing: Any = np.nan) -> np.ndarray:
            found = [result.get(name) for result in results]
            shape = (-1, *np.shape(missing))
            values = [missing if value is None else value for value in found]
            return frozen(np.array(values, dtype=float).reshape(shape))

        vectors, scalars = ("displacement", "rotation"), ("work", "seconds")
        arrays = {name: numbers(name, [np.nan] * 3) for name in vectors}
        arrays |= {name: numbers(name) for name in scalars}
        arrays |= {f"{name}_error": numbers(f"{name}_error") for name in (*vectors, "work")}
        return cls(
            keys=tuple(raw["keys"]),
            values=tuple(tuple(map(_number_or_text, row["values"])) for row in rows),
            status=tuple(row["status"] for row in rows),
            model=tuple(result.get("model", "") for result in results),
            **arrays,
        )

    def to_dataframe(self) -> Any:
        """The rows as a `pandas.DataFrame`."""
        columns: dict[str, Any] = {
            key: [row[number] for row in self.values] for number, key in enumerate(self.keys)
        }
        columns |= {"model": self.model, "status": self.status}
        for name in ("displacement", "rotation"):
            parts = zip("xyz", getattr(self, name).T, strict=True)
            columns |= {f"{name}_{axis}": part for axis, part in parts}
            columns[f"{name}_error"] = getattr(self, f"{name}_error")
        columns |= {name: getattr(self, name) for name in ("work", "work_error", "seconds")}
        return _data_frame(columns)

    def _rows(self) -> list[Row]:
        rows = [("keys", ", ".join(self.keys)), ("points", str(len(self.values)))]
        for number, values in enumerate(self.values[:20]):
            size = float(np.linalg.norm(self.displacement[number]))
            found = with_error(size, float(self.displacement_error[number]))
            is_met = self.status[number] == "met"
            rows.append((", ".join(map(str, values)), found if is_met else self.status[number]))
        return rows


def _number_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text.strip('"')


@dataclass(frozen=True, slots=True, repr=False)
class Sensitivity(Result):
    """Derivative of the net displacement along its direction by one number of the scene.

    Attributes
    ----------
    name : str
        The parameter, in words.
    value : float
        Its value in the scene.
    derivative, error : float
        The derivative and its error bar.
    """

    name: str
    value: float
    derivative: float
    error: float

    def _rows(self) -> list[Row]:
        return [(f"by {self.name}", with_error(self.derivative, self.error))]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class BestFrequency(Result):
    """The frequency at which a gait moves farthest per cycle.

    Attributes
    ----------
    frequency, frequency_error : float
        Cycles per time.
    displacement, displacement_error : float
        Net displacement per cycle there.
    runs : numpy.ndarray
        Frequency, displacement and error bar of all runs, one row each.
    """

    frequency: float
    frequency_error: float
    displacement: float
    displacement_error: float
    runs: np.ndarray

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> BestFrequency:
        return cls(**(raw | {"runs": frozen(np.array(raw["runs"]))}))

    def _rows(self) -> list[Row]:
        return [
            ("frequency", with_error(self.frequency, self.frequency_error)),
            ("net displacement", with_error(self.displacement, self.displacement_error)),
            ("runs", str(len(self.runs))),
        ]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class BestSizes(Result):
    """The best radii and arm lengths for the gait of a scene.

    Attributes
    ----------
    names : tuple of str
        The sizes, in words.
    values, errors, values_before : numpy.ndarray
        Best values with error bars (zero at a limit), and the values of the scene.
    at_limits : tuple of str
        Limits that are active.
    best, before : dict
        Displacement, work and efficiency with error bars, at the best sizes and in the scene.
    toml : str
        The scene with the best sizes.
    """

    names: tuple[str, ...]
    values: np.ndarray
    errors: np.ndarray
    values_before: np.ndarray
    at_limits: tuple[str, ...]
    best: dict[str, float]
    before: dict[str, float]
    toml: str

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> BestSizes:
        arrays = ("values", "errors", "values_before")
        return _from_raw(cls, raw, **{name: frozen(np.array(raw[name])) for name in arrays})

    def _rows(self) -> list[Row]:
        sizes = zip(self.names, self.values, self.errors, strict=True)
        return [(name, with_error(float(value), float(error))) for name, value, error in sizes]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class BestWave(Result):
    """The best wave of a tube that undulates.

    Attributes
    ----------
    keys : tuple of str
        The keys of the scene that varied.
    values, errors : numpy.ndarray
        Their best values with error bars; NaN at the end of a range, and without a bar.
    ranges : numpy.ndarray
        Smallest and largest values, one row per key.
    objective : str
        What is largest: the efficiency, the displacement or the speed.
    value, error : float
        The objective of the run of the best wave, with its error bar; NaN without one.
    by_table : float
        The objective by the interpolant of the table.
    toml : str
        The scene with the best wave.
    """

    keys: tuple[str, ...]
    values: np.ndarray
    errors: np.ndarray
    ranges: np.ndarray
    objective: str
    value: float
    error: float
    by_table: float
    toml: str

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> BestWave:
        def of_all(name: str) -> np.ndarray:
            return frozen(np.array([_number(variable[name]) for variable in raw["variables"]]))

        return cls(
            keys=tuple(variable["key"] for variable in raw["variables"]),
            values=of_all("value"),
            errors=of_all("error"),
            ranges=frozen(np.array([variable["range"] for variable in raw["variables"]])),
            error=_number(raw["error"]),
            **{name: raw[name] for name in ("objective", "value", "by_table", "toml")},
        )

    def _rows(self) -> list[Row]:
        rows = [
            (key, with_error(float(value), float(error)))
            for key, value, error in zip(self.keys, self.values, self.errors, strict=True)
        ]
        return [*rows, (self.objective, with_error(self.value, self.error))]


def _number(value: float | None) -> float:
    """A number of JSON, which has null for those that are not."""
    return float("nan") if value is None else value
