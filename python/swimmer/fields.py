"""Meshes and flows, and their ways to pyvista, meshio and pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._display import Result, Row, largest
from . import _swimmer
from .results import _from_raw, frozen

__all__ = ["Flow", "Mesh", "PointFlow"]

#: Cell type of VTK for quadratic tetrahedra, whose nodes are in the order of ours.
_VTK_QUADRATIC_TETRA = 24


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Mesh(Result):
    """A mesh of 10-node tetrahedra with named boundary parts.

    Attributes
    ----------
    points : numpy.ndarray
        Coordinates of the nodes; the first `n_vertices` are vertices.
    cells : numpy.ndarray
        Ten nodes per cell: four vertices, then the midside nodes of the edges 01, 12, 02, 03, 13,
        23, as VTK has them.
    facets, facet_tags, tags
        Six nodes per boundary face, the number of its boundary part, and the names of the parts.
    min_dihedral, max_dihedral : float
        Dihedral angles in degrees.
    min_quality, mean_quality : float
        Mean ratios; 1 for a regular tetrahedron.
    min_jacobian : float
        Smallest scaled Jacobian.
    """

    points: np.ndarray
    cells: np.ndarray
    facets: np.ndarray
    facet_tags: np.ndarray
    tags: tuple[str, ...]
    n_vertices: int
    min_dihedral: float
    max_dihedral: float
    min_quality: float
    mean_quality: float
    min_jacobian: float

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> Mesh:
        return _from_raw(cls, raw)

    def to_meshio(self) -> Any:
        """The mesh as a `meshio.Mesh`, which writes many file formats."""
        meshio = _optional("meshio", "to_meshio")
        return meshio.Mesh(self.points, [("tetra10", self.cells)])

    def to_pyvista(self) -> Any:
        """The mesh as a `pyvista.UnstructuredGrid`."""
        pyvista = _optional("pyvista", "to_pyvista")
        return pyvista.UnstructuredGrid({_VTK_QUADRATIC_TETRA: self.cells}, self.points)

    def _rows(self) -> list[Row]:
        return [
            ("tetrahedra", str(len(self.cells))),
            ("vertices", str(self.n_vertices)),
            ("nodes", str(len(self.points))),
            ("boundary parts", ", ".join(self.tags)),
            ("dihedral angles", f"{self.min_dihedral:.1f} to {self.max_dihedral:.1f} degrees"),
            ("mean ratio", f"{self.min_quality:.3f} minimum, {self.mean_quality:.3f} mean"),
            ("scaled Jacobian", f"{self.min_jacobian:.3f} minimum"),
        ]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Flow(Result):
    """Velocity and pressure on the nodes of a mesh.

    Attributes
    ----------
    mesh : Mesh
        The mesh.
    velocity : numpy.ndarray
        Velocity at every node.
    pressure : numpy.ndarray
        Pressure at every vertex; empty for models that do not compute it.
    """

    mesh: Mesh
    velocity: np.ndarray
    pressure: np.ndarray

    @classmethod
    def _from_raw(cls, raw: dict[str, Any]) -> Flow:
        return cls(Mesh._from_raw(raw["mesh"]), frozen(raw["velocity"]), frozen(raw["pressure"]))

    @property
    def _node_pressure(self) -> np.ndarray:
        """Pressure at all nodes: the mean of the ends of the edge at midside nodes."""
        edges = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
        values = np.empty(len(self.mesh.points))
        values[: self.mesh.n_vertices] = self.pressure
        cells = self.mesh.cells
        values[cells[:, 4:]] = self.pressure[cells[:, edges]].mean(axis=2)
        return values

    def _point_data(self) -> dict[str, np.ndarray]:
        data = {"velocity": self.velocity}
        if len(self.pressure):
            data["pressure"] = self._node_pressure
        return data

    def to_meshio(self) -> Any:
        """Mesh, velocity and pressure as a `meshio.Mesh`."""
        mesh = self.mesh.to_meshio()
        mesh.point_data.update(self._point_data())
        return mesh

    def to_pyvista(self) -> Any:
        """Mesh, velocity and pressure as a `pyvista.UnstructuredGrid`."""
        grid = self.mesh.to_pyvista()
        for name, values in self._point_data().items():
            grid.point_data[name] = values
        return grid

    def _rows(self) -> list[Row]:
        return [
            ("nodes", str(len(self.velocity))),
            ("largest velocity", f"{largest(self.velocity):.6g}"),
            ("pressure", "at the vertices" if len(self.pressure) else "not computed"),
        ]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class PointFlow(Result):
    """Velocity and pressure at points.

    Attributes
    ----------
    points : numpy.ndarray
        Coordinates, in the last axis.
    velocity : numpy.ndarray
        Velocities; NaN at points outside the fluid, or outside the mesh.
    pressure : numpy.ndarray
        Pressures; NaN where there is no velocity, and for models that do not compute them.
    """

    points: np.ndarray
    velocity: np.ndarray
    pressure: np.ndarray

    @classmethod
    def _at(cls, points: Any, flow_at: Callable[[np.ndarray], Sequence[np.ndarray]]) -> PointFlow:
        points = np.asarray(points, dtype=float)
        if points.ndim == 0 or points.shape[-1] != 3:
            shape = points.shape
            raise _swimmer.SceneError(f"the last axis of points has length three, not {shape}")
        velocity, pressure = flow_at(points.reshape(-1, 3))
        return cls(
            frozen(points.copy()),
            frozen(velocity.reshape(points.shape)),
            frozen(pressure.reshape(points.shape[:-1])),
        )

    @property
    def is_fluid(self) -> np.ndarray:
        """Whether each point is in the fluid."""
        return ~np.isnan(self.velocity[..., 0])

    def _rows(self) -> list[Row]:
        return [
            ("points", str(self.is_fluid.size)),
            ("in the fluid", str(int(self.is_fluid.sum()))),
            ("largest velocity", f"{largest(np.nan_to_num(self.velocity)):.6g}"),
        ]


def _optional(package: str, method: str) -> Any:
    """A package that is imported when it is needed."""
    try:
        return __import__(package)
    except ImportError as error:
        message = f"{method} needs the package {package}: pip install {package}"
        raise ImportError(message, name=package) from error
