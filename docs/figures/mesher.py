"""Speed and quality of the mesh generator, and the error of the answer on its meshes.

Writes mesher.md. Meshes of the command `gmsh` stand beside them where it is installed.
"""

import re
import subprocess
import sys
import tempfile

from figures import ROOT, Refused, arguments, page, swim, swim_text, table

SIZES = [0.4, 0.2, 0.14, 0.11]
# Number of rounds; the fastest one counts, since other load on the machine can only slow it down.
ROUNDS = 5
# Names and arguments of the algorithms of Gmsh; only the first one is parallel.
GMSH = [("Gmsh, HXT", "hxt", 1), ("Gmsh, HXT", "hxt", 2), ("Gmsh, Delaunay", "del3d", 1)]
# Exact velocity of the middle sphere while one arm closes (crates/studies/src/reference.rs).
VELOCITY = -0.3428979021151601
UNIT_RATE = "gait.phases.0.duration=4"


def quality(scene, overrides):
    """Number of tets, angles and mean ratio of the mesh of a scene."""
    with tempfile.NamedTemporaryFile(suffix=".msh") as file:
        text = swim_text("mesh", scene, "--out", file.name, overrides=overrides)
    tets = int(re.search(r"tetrahedra\s+(\d+)", text)[1])
    angles = re.search(r"dihedral angles\s+([\d.]+ to [\d.]+)", text)[1]
    return tets, [angles, re.search(r"([\d.]+) mean", text)[1]]


def errors(solution):
    """Dofs, and the relative errors of the velocity without and with the correction."""
    velocities = [found["bodies"][1]["velocity"][0] for found in (solution["uncorrected"], solution)]
    return [solution["dofs"]["total"], *(f"{abs(v / VELOCITY - 1):.1e}" for v in velocities)]


def ours(size):
    scene = ROOT / "scenes" / "three-sphere.toml"
    overrides = [f"fem.surface_size={size}", "fem.symmetry=off", UNIT_RATE]
    tets, shape = quality(scene, overrides)
    answer = errors(swim("solve", scene, overrides=overrides))
    for threads in (1, 2):
        fast = [*overrides, "fem.estimates=off"]
        rounds = [swim("solve", scene, overrides=fast, threads=threads) for _ in range(ROUNDS)]
        seconds = min(found["seconds"]["mesh"] for found in rounds)
        yield [size, "this project", threads, tets, f"{1e-3 * tets / seconds:.0f}", *shape, *answer]


def seconds_of_meshing(log):
    """Sum of the wall times of curves, surfaces and volumes in the output of Gmsh."""
    times = re.findall(r"Done meshing \dD \(Wall ([\d.]+)s", log)
    assert len(times) == 3, log
    return sum(map(float, times))


def gmsh(size, program, algorithm, threads, folder):
    file = f"{folder}/three-sphere.msh"
    numbers = {"size": size, "growth": min(8 / 7 * size, 0.3), "largest": 20}
    words = ["gmsh", "-3", "-algo", algorithm, "-nt", str(threads)]
    for name, value in numbers.items():
        words += ["-setnumber", name, str(value)]
    words += ["-o", file, str(ROOT / "scenes" / "three-sphere.geo")]
    rounds = [subprocess.run(words, capture_output=True, text=True, check=True) for _ in range(ROUNDS)]
    seconds = min(seconds_of_meshing(done.stdout) for done in rounds)
    scene, overrides = ROOT / "scenes" / "three-sphere-mesh.toml", [f"domain.file={file}"]
    tets, shape = quality(scene, [*overrides, "fem.geometry=straight"])
    try:
        answer = errors(swim("solve", scene, overrides=[*overrides, UNIT_RATE]))
    except Refused as error:
        print(f"{program} at size {size}: {error}", file=sys.stderr)
        answer = ["-"] * 3
    return [size, program, threads, tets, f"{1e-3 * tets / seconds:.0f}", *shape, *answer]


def main():
    chosen = arguments(__doc__)
    log = "".join(f"Info    : Done meshing {k}D (Wall {k}.25s, CPU 0.1s)\n" for k in (1, 2, 3))
    assert seconds_of_meshing(log) == 6.75
    rows = []
    for size in SIZES[:1] if chosen.quick else SIZES:
        rows += ours(size)
        for program in GMSH:
            with tempfile.TemporaryDirectory() as folder:
                try:
                    rows.append(gmsh(size, *program, folder))
                except (OSError, subprocess.CalledProcessError) as error:
                    print(f"{program[0]} at size {size}: {error}", file=sys.stderr)
    text = page(
        "Speed of the mesh generator",
        "mesher.py",
        "Three unit spheres with arms of 10 in a ball of radius 40; edges of the given size on the "
        "spheres, growing by 8/7 of it, at most 0.3, per unit of distance. Thousand tets per second, "
        f"from surfaces to the checked curved mesh; the fastest of {ROUNDS} rounds. The times of Gmsh "
        "are its own, for curves, surfaces and volume, without start and files. `cargo bench -p "
        "microswim-mesher` measures the generation alone.",
        "Angles in degrees. The error is that of the velocity of the middle sphere while one arm "
        "closes, relative to the exact value, without and with the correction by cubic elements (-: "
        "some curved cells are inverted).",
        table(
            ["size", "program", "threads", "tets", "1000 tets/s", "angles", "mean ratio", "dofs"]
            + ["error", "corrected"],
            rows,
        ),
    )
    (chosen.out / "mesher.md").write_text(text)


if __name__ == "__main__":
    main()
