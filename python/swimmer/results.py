"""Results of one configuration: frozen records of numbers and arrays, with error bars."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ._display import Result, Row, largest, vector, with_error

__all__ = [
    "Connection",
    "ErrorBars",
    "Metric",
    "Mobility",
    "Resistance",
    "Solution",
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
class MeanFlow(Result):
    """The mean flow through a periodic box and the mean pressure gradient, in the scene's units.

    The scene gives one of both, by default a flow of zero. The forces of the bodies on the fluid
    add up to the pressure gradient times the volume of the box.

    Attributes
    ----------
    velocity : numpy.ndarray
        Mean velocity of fluid and bodies.
    velocity_errors : ErrorBars or None
        Its error bars; None if the scene gives it.
    pressure_gradient : numpy.ndarray
        Mean of the gradient of the pressure.
    pressure_gradient_errors : ErrorBars or None
        Its error bars; None if the scene gives it.
    """

    velocity: np.ndarray
    velocity_errors: ErrorBars | None
    pressure_gradient: np.ndarray
    pressure_gradient_errors: ErrorBars | None

    @classmethod
    def _from_raw(cls, raw: dict[str, Any] | None) -> MeanFlow | None:
        if raw is None:
            return None
        names = ("velocity_errors", "pressure_gradient_errors")
        given = {name: bars for name in names if (bars := raw[name]) is not None}
        bars = {name: ErrorBars(**given[name]) if name in given else None for name in names}
        return _from_raw(cls, raw, **bars)

    def _rows(self) -> list[Row]:
        return [
            ("mean flow", vector(self.velocity)),
            ("pressure gradient", vector(self.pressure_gradient)),
        ]


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
    mean_flow : MeanFlow or None
        Mean flow and pressure gradient of a periodic box; None in other domains.
    model, formulation, solver : str
        How the flow was computed.
    dofs, iterations : int
        Size of the linear system, and iterations for it.
    residual : float
        True relative residual.
    seconds : dict
        Wall-clock seconds of the parts of the work.
    reynolds : float or None
        Reynolds number of a steady state with the inertia of the fluid; None for Stokes flow.
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
    mean_flow: MeanFlow | None
    dofs: int
    formulation: str
    solver: str
    iterations: int
    residual: float
    seconds: dict[str, float]
    reynolds: float | None = None

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> Solution:
        kinds = ("velocity", "angular_velocity", "force", "torque", "power")
        names = [f"{kind}_errors" for kind in kinds]
        flow = MeanFlow._from_raw(raw["mean_flow"])
        bars = {name: ErrorBars(**raw[name]) for name in names}
        return _from_raw(cls, raw, mean_flow=flow, **bars)

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
