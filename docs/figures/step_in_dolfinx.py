"""One step in time of a flow with inertia: this program against PETSc, by dolfinx.

The example `one_step` of the crate `inertia` solves the step and writes mesh and data; the same
elements on the same mesh are assembled by dolfinx and solved by PETSc with several preconditioners to
the same residual. Everything runs on one thread, and times are those of the processor, medians of
three runs; the fastest preconditioners (`--best`) are in the table, all lines go to stderr. Needs
dolfinx 0.5 or later with real numbers, for example the Debian packages python3-dolfinx-real and
python3-scipy:

    cargo build --release -p microswim-inertia --example one_step
    OMP_NUM_THREADS=1 python3 docs/figures/step_in_dolfinx.py
"""

import argparse
import json
import logging
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy
import ufl
from dolfinx import cpp, fem, mesh
from mpi4py import MPI
from petsc4py import PETSc

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("ONE_STEP", str(ROOT / "target" / "release" / "examples" / "one_step"))
RTOL = 1e-8
# Edges of a tetrahedron at whose middle the further nodes are, here and in dolfinx.
OUR_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
THEIR_EDGES = [(2, 3), (1, 3), (1, 2), (0, 3), (0, 2), (0, 1)]

# Preconditioners of the velocity block. "scalar" has one V-cycle for the matrix that the three
# components share, applied to each of them; the others treat the matrix of all components.
BOOMERAMG = {
    "pc_type": "hypre",
    "pc_hypre_type": "boomeramg",
    "pc_hypre_boomeramg_coarsen_type": "HMIS",
    "pc_hypre_boomeramg_interp_type": "ext+i",
    "pc_hypre_boomeramg_P_max": 4,
    "pc_hypre_boomeramg_strong_threshold": 0.5,
}
AGGRESSIVE = BOOMERAMG | {"pc_hypre_boomeramg_agg_nl": 1}
VELOCITY = {
    "BoomerAMG, defaults": {"pc_type": "hypre"},
    "BoomerAMG, HMIS": BOOMERAMG,
    "BoomerAMG, aggressive": AGGRESSIVE,
    "GAMG": {"pc_type": "gamg"},
    "Jacobi, Chebyshev 4": {"ksp_type": "chebyshev", "ksp_max_it": 4, "pc_type": "jacobi"},
    "SSOR": {"pc_type": "sor"},
    "ILU": {"pc_type": "ilu"},
    "scalar BoomerAMG, defaults": {"scalar": True, "pc_type": "hypre"},
    "scalar BoomerAMG, HMIS": {"scalar": True} | BOOMERAMG,
    "scalar BoomerAMG, aggressive": {"scalar": True} | AGGRESSIVE,
    "scalar BoomerAMG, 0.7": {"scalar": True}
    | BOOMERAMG
    | {"pc_hypre_boomeramg_strong_threshold": 0.7},
    "scalar BoomerAMG, Jacobi": {"scalar": True}
    | BOOMERAMG
    | {"pc_hypre_boomeramg_relax_type_all": "l1scaled-Jacobi"},
    "scalar GAMG": {"scalar": True, "pc_type": "gamg"},
    "scalar SSOR": {"scalar": True, "pc_type": "sor"},
    "scalar ILU": {"scalar": True, "pc_type": "ilu"},
}


class Step:
    """Mesh, data and exact solution of a step."""

    def __init__(self, folder, ours):
        def read(name, kind, columns):
            return numpy.fromfile(folder / name, kind).reshape(-1, columns)

        self.ours = ours
        self.cells = read("cells", numpy.uint32, 10).astype(numpy.int64)
        names = ["points", "prescribed", "before", "velocity"]
        self.points, self.prescribed, self.before, self.velocity = (
            read(name, numpy.float64, 3) for name in names
        )


def solver(matrix, options, name):
    """A solver of PETSc with its own options, one application by default."""
    ksp = PETSc.KSP().create()
    ksp.setOperators(matrix)
    prefix = f"{name}_"
    ksp.setOptionsPrefix(prefix)
    database = PETSc.Options()
    for key, value in ({"ksp_type": "preonly"} | options).items():
        database[prefix + key] = value
    ksp.setFromOptions()
    ksp.setUp()
    return ksp


class Scalar:
    """One scalar solver for the three interleaved components."""

    def __init__(self, matrix, options):
        self.inner = solver(matrix, options, "scalar")
        self.x, self.y = matrix.createVecs()

    def apply(self, _, x, y):
        of_all, result = x.array_r, y.array_w
        for component in range(3):
            self.x.array[:] = of_all[component::3]
            self.inner.solve(self.x, self.y)
            result[component::3] = self.y.array_r


class Pressure:
    """Inverse of the Schur complement: Cahouet and Chabard (1988), Kay, Loghin and Wathen (2002).

    `-(M^-1 (1 + N L^-1) + κ L^-1)` with three Chebyshev steps for the mass matrix M and one V-cycle
    for the Laplacian L. The convection N loses half of its boundary term at the inflow, as ours.
    """

    def __init__(self, mass, laplacian, convection, coefficient):
        jacobi = {"ksp_type": "chebyshev", "ksp_max_it": 3, "pc_type": "jacobi"}
        # eigenvalues of the mass matrix of linear tetrahedra over its diagonal (Wathen 1987)
        bounds = {"ksp_chebyshev_eigenvalues": "0.5,2.5"}
        self.mass = solver(mass, jacobi | bounds, "mass")
        self.laplacian = solver(laplacian, BOOMERAMG, "laplacian")
        self.convection, self.coefficient = convection, coefficient
        self.potential, self.work = mass.createVecs()

    def apply(self, _, x, y):
        self.laplacian.solve(x, self.potential)
        x.copy(self.work)
        if self.convection is not None:
            self.convection.multAdd(self.potential, x, self.work)
        self.mass.solve(self.work, y)
        y.axpy(self.coefficient, self.potential)
        y.scale(-1.0)


def python_solver(ksp, context):
    ksp.setType("preonly")
    ksp.pc.setType("python")
    ksp.pc.setPythonContext(context)


class InDolfinx:
    """The equations of a step, assembled by dolfinx."""

    def __init__(self, step):
        order = list(range(4)) + [4 + OUR_EDGES.index(edge) for edge in THEIR_EDGES]
        element = ufl.VectorElement("Lagrange", "tetrahedron", 2)
        cells = step.cells[:, order]
        self.mesh = mesh.create_mesh(MPI.COMM_SELF, cells, step.points, ufl.Mesh(element))
        velocities = fem.VectorFunctionSpace(self.mesh, ("Lagrange", 2))
        pressures = fem.FunctionSpace(self.mesh, ("Lagrange", 1))
        scalars = fem.FunctionSpace(self.mesh, ("Lagrange", 2))
        # number of each node in the arrays of the step: its cell and place in it are the same
        geometry = self.mesh.geometry
        numbers = numpy.empty(len(step.points), numpy.int64)
        of_cells = velocities.dofmap.list.array.reshape(-1, 10)
        numbers[of_cells] = numpy.asarray(geometry.input_global_indices)[
            geometry.dofmap.array.reshape(-1, 10)
        ]
        self.numbers = numbers
        assert numpy.array_equal(of_cells, scalars.dofmap.list.array.reshape(-1, 10))

        def field(values):
            function = fem.Function(velocities)
            function.x.array[:] = values[numbers].ravel()
            return function

        is_prescribed = ~numpy.isnan(step.prescribed[numbers, 0])
        dofs = numpy.flatnonzero(is_prescribed).astype(numpy.int32)
        self.prescribed = fem.dirichletbc(field(numpy.nan_to_num(step.prescribed)), dofs)
        of_scalars = fem.dirichletbc(PETSc.ScalarType(0), dofs, scalars)
        before = field(step.before)
        density, coefficient = step.ours["density"], step.ours["coefficient"]
        self.convects = step.ours["convects"]
        self.coefficient = coefficient
        dx = ufl.Measure("dx", self.mesh, metadata={"quadrature_degree": 5})

        def momentum(space):
            u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
            form = (coefficient * ufl.inner(u, v) + ufl.inner(ufl.grad(u), ufl.grad(v))) * dx
            if self.convects:
                form += density * ufl.inner(ufl.dot(ufl.grad(u), before), v) * dx
            return form

        u, v = ufl.TrialFunction(velocities), ufl.TestFunction(velocities)
        p, q = ufl.TrialFunction(pressures), ufl.TestFunction(pressures)
        self.forms = fem.form(
            [
                [momentum(velocities), -p * ufl.div(v) * dx],
                [-q * ufl.div(u) * dx, None],
            ]
        )
        zero = fem.Constant(self.mesh, PETSc.ScalarType(0))
        self.loads = fem.form([coefficient * ufl.inner(before, v) * dx, zero * q * dx])
        self.of_pressure = [
            fem.form(form)
            for form in (p * q * dx, ufl.inner(ufl.grad(p), ufl.grad(q)) * dx)
        ]
        convection = density * q * ufl.dot(before, ufl.grad(p)) * dx
        self.pressure_convection = fem.form(convection) if self.convects else None
        self.scalar = fem.form(momentum(scalars))
        self.of_scalars = of_scalars

    def assemble(self):
        """The matrix and the right-hand side, and the matrices of preconditioners."""
        conditions = [self.prescribed]
        matrix = fem.petsc.assemble_matrix_nest(self.forms, bcs=conditions)
        matrix.assemble()
        rhs = fem.petsc.assemble_vector_nest(self.loads)
        fem.petsc.apply_lifting_nest(rhs, self.forms, bcs=conditions)
        for part in rhs.getNestSubVecs():
            part.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        spaces = [form.function_spaces[0] for form in self.loads]
        fem.petsc.set_bc_nest(rhs, fem.bcs_by_block(spaces, conditions))
        mass, laplacian = (fem.petsc.assemble_matrix(form) for form in self.of_pressure)
        for part in (mass, laplacian):
            part.assemble()
        # the null space of constants, as ours
        laplacian.axpy(1e-3, mass)
        convection = None
        if self.pressure_convection is not None:
            convection = fem.petsc.assemble_matrix(self.pressure_convection)
            convection.assemble()
            convection = without_inflow(convection)
        constant = PETSc.Vec().createNest([part.duplicate() for part in rhs.getNestSubVecs()])
        velocity, pressure = constant.getNestSubVecs()
        velocity.set(0.0)
        pressure.set(1.0)
        constant.normalize()
        null_space = PETSc.NullSpace().create(vectors=[constant])
        matrix.setNullSpace(null_space)
        null_space.remove(rhs)
        return matrix, rhs, mass, laplacian, convection

    def scalar_matrix(self):
        matrix = fem.petsc.assemble_matrix(self.scalar, bcs=[self.of_scalars])
        matrix.assemble()
        return matrix

    def set_up(self, assembled, options, scalar, rtol=RTOL):
        """The solver of a step with these options for the velocity block."""
        matrix, rhs, mass, laplacian, convection = assembled
        ksp = PETSc.KSP().create()
        ksp.setOperators(matrix)
        ksp.setType("fgmres")
        ksp.setGMRESRestart(200)
        ksp.setTolerances(rtol=rtol, max_it=200)
        pc = ksp.pc
        pc.setType("fieldsplit")
        fields = matrix.getNestISs()[0]
        pc.setFieldSplitIS(("velocity", fields[0]), ("pressure", fields[1]))
        pc.setFieldSplitType(PETSc.PC.CompositeType.SCHUR)
        pc.setFieldSplitSchurFactType(PETSc.PC.SchurFactType.UPPER)
        pc.setFieldSplitSchurPreType(PETSc.PC.SchurPreType.USER, mass)
        pc.setUp()
        velocity, pressure = pc.getFieldSplitSubKSP()
        options = dict(options)
        if options.pop("scalar", False):
            python_solver(velocity, Scalar(scalar, options))
        else:
            prefix = velocity.getOptionsPrefix()
            database = PETSc.Options()
            for key, value in ({"ksp_type": "preonly"} | options).items():
                database[prefix + key] = value
            velocity.setFromOptions()
            for key in options:
                database.delValue(prefix + key)
        inverse = Pressure(mass, laplacian, convection, self.coefficient)
        python_solver(pressure, inverse)
        velocity.setUp()
        pressure.setUp()
        return ksp

    def at_nodes(self, solution):
        """Velocities in the order of the arrays of the step."""
        of_nodes = numpy.empty((len(self.numbers), 3))
        of_nodes[self.numbers] = solution.getNestSubVecs()[0].array_r.reshape(-1, 3)
        return of_nodes


def without_inflow(convection):
    """The convection of the pressure without half of its boundary term at the inflow."""
    import scipy.sparse

    starts, columns, values = convection.getValuesCSR()
    matrix = scipy.sparse.csr_matrix((values, columns, starts), convection.getSize())
    boundary = (matrix + matrix.T).tocsr()
    inflow = scipy.sparse.diags((numpy.asarray(boundary.sum(axis=1)).ravel() < 0).astype(float))
    matrix = (matrix - 0.25 * (inflow @ boundary + boundary @ inflow)).tocsr()
    parts = (matrix.indptr.astype(numpy.int32), matrix.indices.astype(numpy.int32), matrix.data)
    return PETSc.Mat().createAIJ(matrix.shape, csr=parts)


def measured(step, chosen, repeats):
    """Lines of the table: times, iterations and residual by each preconditioner."""
    equations = InDolfinx(step)
    times = []
    for _ in range(repeats):
        clock = time.process_time()
        assembled = equations.assemble()
        times.append(time.process_time() - clock)
    assembly = statistics.median(times)
    clock = time.process_time()
    scalar = equations.scalar_matrix()
    of_scalar = time.process_time() - clock
    matrix, rhs = assembled[:2]
    size = numpy.linalg.norm(step.velocity)
    lines = []
    for name in chosen:
        set_ups, solves = [], []
        try:
            for _ in range(repeats):
                clock = time.process_time()
                ksp = equations.set_up(assembled, VELOCITY[name], scalar)
                middle = time.process_time()
                solution = rhs.duplicate()
                solution.set(0.0)
                ksp.solve(rhs, solution)
                solves.append(time.process_time() - middle)
                set_ups.append(middle - clock)
                reason, iterations = ksp.getConvergedReason(), ksp.getIterationNumber()
                if reason < 0:
                    break
        except PETSc.Error as error:
            print(f"{name}: error {error.ierr}", file=sys.stderr)
            continue
        residual = rhs.duplicate()
        matrix.mult(solution, residual)
        residual.aypx(-1.0, rhs)
        error = numpy.linalg.norm(equations.at_nodes(solution) - step.velocity) / size
        # once more, until the error is ours: PETSc stops by the residual alone
        again = RTOL * min(1.0, step.ours["error"] / error)
        ksp.setTolerances(rtol=again)
        solution.set(0.0)
        clock = time.process_time()
        ksp.solve(rhs, solution)
        to_our_error = time.process_time() - clock
        line = {
            "velocity": name,
            "to our error": to_our_error if ksp.getConvergedReason() > 0 else math.nan,
            "iterations": iterations,
            "converged": reason > 0,
            "residual": residual.norm() / rhs.norm(),
            "error": error,
            "assembly": assembly + (of_scalar if name.startswith("scalar") else 0.0),
            "setup": statistics.median(set_ups),
            "solve": statistics.median(solves),
        }
        print(json.dumps(line), file=sys.stderr, flush=True)
        lines.append(line)
        ksp.destroy()
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--sizes", default="0.23,0.14", help="element sizes on the sphere")
    parser.add_argument("--reynolds", default="0,10")
    parser.add_argument("--step", default="0.1")
    parser.add_argument("--only", help="preconditioners with one of these names, separated by ;")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--best", type=int, default=3, help="lines of a case in the table")
    chosen = parser.parse_args()
    only = chosen.only.split(";") if chosen.only else VELOCITY
    names = [name for name in VELOCITY if name in only]
    # the compilation of forms is reported in detail
    logging.disable(logging.INFO)
    headings = "dofs Re solver iterations error assembly set-up solve".split()
    headings += ["over ours", "to our error", "whole step"]
    print("| " + " | ".join(headings) + " |")
    print("|--:|--:|:--|--:|--:|--:|--:|--:|--:|--:|--:|")
    for size in chosen.sizes.split(","):
        for reynolds in chosen.reynolds.split(","):
            with tempfile.TemporaryDirectory() as folder:
                words = [f"size={size}", f"reynolds={reynolds}", f"step={chosen.step}"]
                words += [f"repeats={chosen.repeats}", f"out={folder}"]
                environment = os.environ | {"RAYON_NUM_THREADS": "1"}
                done = subprocess.run(
                    [PROGRAM, *words], capture_output=True, text=True, check=True, env=environment
                )
                ours = json.loads(done.stdout)
                ours |= {"convects": float(reynolds) > 0, "to our error": ours["solve"]}
                print(done.stdout, file=sys.stderr, flush=True)
                step = Step(pathlib.Path(folder), ours)
            total = ours["setup"] + ours["solve"]

            def row(name, line):
                solver = line["setup"] + line["solve"]
                to_our_error = (line["setup"] + line["to our error"]) / total
                whole = (solver + line["assembly"]) / (total + ours["assembly"])
                ratios = [solver / total, to_our_error, whole]
                parts = [f"{line[part]:.2f} s" for part in ("assembly", "setup", "solve")]
                iterations = line["iterations"]
                head = [ours["dofs"], reynolds, name, iterations, f"{line['error']:.0e}"]
                cells = [*head, *parts, *(f"{ratio:.1f}" for ratio in ratios)]
                print("| " + " | ".join(map(str, cells)) + " |", flush=True)

            row("this program", ours)
            lines = [line for line in measured(step, names, chosen.repeats) if line["converged"]]
            lines.sort(key=lambda line: line["setup"] + line["solve"])
            for line in lines[: chosen.best]:
                row(line["velocity"], line)


if __name__ == "__main__":
    main()
