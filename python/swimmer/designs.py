"""Results of designs: of strokes, sizes and frequencies, sweeps, maps, learning."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ._display import Result, Row, vector, with_error
from .results import ErrorBars, _data_frame, _from_raw, frozen

__all__ = [
    "BestFrequency",
    "BestSizes",
    "BestWave",
    "LearnedStroke",
    "Optimum",
    "Sensitivity",
    "StrokeMap",
    "Sweep",
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
        runs = np.array(raw["runs"], dtype=float).reshape(-1, 3)
        return _from_raw(cls, raw, runs=frozen(runs))

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
        sizes = [raw["sizes"][name] for name in raw["names"]]

        def numbers(key: str) -> np.ndarray:
            return frozen(np.array([size[key] for size in sizes], dtype=float))

        return _from_raw(
            cls,
            raw,
            values=numbers("value"),
            errors=numbers("error"),
            values_before=numbers("scene"),
            before=raw["scene"],
        )

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


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class StrokeMap(Result):
    """Connection, curvature and metric over the shapes of a swimmer, from a table.

    Attributes
    ----------
    model : str
        The model.
    links : tuple of str
        The links that move; shapes have one value for each.
    ranges : numpy.ndarray
        Smallest and largest value, one row per link.
    middle : numpy.ndarray
        The shape in the middle of the limits.
    degrees : tuple of int
        Polynomial degrees of the interpolant, one per link.
    points : int
        Number of shapes that were solved.
    interpolation_error, model_error, position_error : float
        Error bars of velocities for a unit rate of a link: of the table, of the model, and of the
        place in a container.
    stroke : numpy.ndarray
        Shapes along one cycle of the gait, one row each; empty without a gait that closes.
    gait_displacement, gait_rotation : numpy.ndarray or None
        Displacement and rotation vector of that cycle by the table; None where it leaves it.
    gait_period_energy_product : float or None
        Its energy times its period at constant power.
    """

    model: str
    links: tuple[str, ...]
    ranges: np.ndarray
    middle: np.ndarray
    degrees: tuple[int, ...]
    points: int
    interpolation_error: float
    model_error: float
    position_error: float
    stroke: np.ndarray
    gait_displacement: np.ndarray | None
    gait_rotation: np.ndarray | None
    gait_period_energy_product: float | None
    _map: Any = field(repr=False)

    @classmethod
    def _of(cls, found: Any) -> StrokeMap:
        raw = json.loads(found.json())
        gait = raw["gait"] or {}
        vectors = {name: gait.get(name) for name in ("displacement", "rotation")}
        arrays = {
            f"gait_{name}": None if value is None else frozen(np.array(value))
            for name, value in vectors.items()
        }
        bars = raw["error_estimate"]
        return cls(
            model=raw["model"],
            links=tuple(raw["links"]),
            ranges=frozen(np.array(raw["ranges"])),
            middle=frozen(np.array(raw["middle"])),
            degrees=tuple(raw["degrees"]),
            points=raw["points"],
            interpolation_error=bars["interpolation"],
            model_error=bars["model"],
            position_error=bars["position"],
            stroke=frozen(found.stroke()),
            gait_period_energy_product=gait.get("period_energy_product"),
            **arrays,
            _map=found,
        )

    def grid(self, points: int = 41) -> np.ndarray:
        """Shapes on a grid over the limits, `(..., link)` with one axis per link."""
        axes = [np.linspace(low, high, points) for low, high in self.ranges]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)

    def connection(self, shapes: Any = None) -> np.ndarray:
        """Connection at shapes, by default the middle: `(..., 6, link)` as `Connection`."""
        return self._at(shapes)[0]

    def metric(self, shapes: Any = None) -> np.ndarray:
        """Dissipation metric at shapes, by default the middle: `(..., link, link)`."""
        return self._at(shapes)[1]

    def curvature(self, shapes: Any = None, first: int = 0, second: int = 1) -> np.ndarray:
        """Curvature of the connection at shapes, by default the middle: `(..., 6)`.

        It is the displacement and the rotation vector of the frame per area of a small stroke in
        the plane of two links, from the number `first` to the number `second`; its components over
        the shapes are the height functions.
        """
        links = range(len(self.links))
        if first not in links or second not in links:
            raise IndexError(f"links {first} and {second}: there are {len(links)}, from 0")
        return self._at(shapes, first, second)[2]

    def _at(self, shapes: Any, first: int = 0, second: int = 0) -> list[np.ndarray]:
        shapes = np.asarray(self.middle if shapes is None else shapes, dtype=float)
        if shapes.ndim == 0 or shapes.shape[-1] != len(self.links):
            raise ValueError(
                f"the last axis of shapes has one value for each of {', '.join(self.links)}, "
                f"not {shapes.shape}"
            )
        flat = self._map.at(shapes.reshape(-1, len(self.links)), first, second)
        return [array.reshape(*shapes.shape[:-1], *array.shape[1:]) for array in flat]

    def _rows(self) -> list[Row]:
        rows = [("model", self.model)]
        ranges = zip(self.links, self.ranges, strict=True)
        rows += [(link, f"{low:g} to {high:g}") for link, (low, high) in ranges]
        degrees = " x ".join(map(str, self.degrees))
        rows.append(("table", f"{self.points} shapes, degrees {degrees}"))
        error = self.interpolation_error + self.model_error + self.position_error
        rows.append(("error per unit rate", f"{error:.2g}"))
        if self.gait_displacement is not None:
            rows.append(("displacement of the gait", vector(self.gait_displacement)))
        return rows


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class LearnedStroke(Result):
    """A cycle of steps that was learned, beside the best possible one.

    States have one digit per joint, which is 1 if it is contracted; a step changes one joint.

    Attributes
    ----------
    model : str
        The model of the displacements.
    joints : tuple of str
        Names of the joints.
    policy, best_policy : tuple of str
        The states of the learned and of the best cycle, in order.
    actions, best_actions : tuple of str
        The joint that changes in each of them.
    per_step, best_per_step : float
        Mean displacement of a step.
    per_cycle, best_per_cycle : float
        Displacement of a cycle.
    reward_error : float
        Error bar of the displacement of a step.
    is_optimal : bool
        Whether the learned cycle is as good as the best one.
    curve : numpy.ndarray
        Mean displacement of a step in each episode, random actions included.
    values : numpy.ndarray
        Learned value of each action in each state, one row per state.
    """

    model: str
    joints: tuple[str, ...]
    policy: tuple[str, ...]
    actions: tuple[str, ...]
    per_step: float
    per_cycle: float
    best_policy: tuple[str, ...]
    best_actions: tuple[str, ...]
    best_per_step: float
    best_per_cycle: float
    reward_error: float
    is_optimal: bool
    curve: np.ndarray
    values: np.ndarray

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> LearnedStroke:
        best = {f"best_{name}": value for name, value in raw["optimum"].items()}
        arrays = {name: np.array(raw[name]) for name in ("curve", "values")}
        return _from_raw(cls, raw | best | arrays)

    def _rows(self) -> list[Row]:
        cycles = [
            ("learned", self.policy, self.per_step),
            ("best possible", self.best_policy, self.best_per_step),
        ]
        rows = [("model", self.model)]
        for name, policy, per_step in cycles:
            rows.append((name, " -> ".join(policy)))
            rows.append(("  per step", with_error(per_step, self.reward_error)))
        return rows
