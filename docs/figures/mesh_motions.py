"""The default stroke with each mesh motion of the program, on generated meshes and on those of Gmsh.

Writes ale-files.md. The command `gmsh` makes the meshes of files from scenes/three-sphere.geo; without
it only the generated mesh is studied.
"""

import shutil
import subprocess
import sys
import tempfile

from figures import ROOT, Refused, arguments, page, swim, table

MOTIONS = ["laplace", "kanchi-masud", "inverse-volume", "elastic", "biharmonic", "rbf"]
# Exact net displacement of the default stroke (crates/studies/src/reference.rs).
NET = 0.1604180159643671

# Meshes of files: size on the spheres, growth, largest size and length of the arms.
FILES = {
    "fast": (0.4, 0.6, 12, 10),
    "coarse": (0.65, 0.3, 8, 10),
    "middle": (0.4, 0.25, 6, 10),
    "fine": (0.25, 0.2, 5, 10),
    "near": (0.3, 0.3, 8, 4),
    "close": (0.25, 0.3, 8, 3),
}
CONTAINERS = {"ball": 0, "box": 1}
ALGORITHMS = {"delaunay": "del3d", "hxt": "hxt"}


def scene_of_file(name, container, algorithm, folder):
    """The scene and the overrides for a mesh that Gmsh makes."""
    *numbers, arm = FILES[name]
    file = f"{folder}/{container}-{algorithm}-{name}.msh"
    words = ["gmsh", "-3", "-algo", ALGORITHMS[algorithm], "-optimize_netgen", "-o", file]
    values = [*zip(("size", "growth", "largest"), numbers), ("arm", arm)]
    for key, value in [*values, ("box", CONTAINERS[container])]:
        words += ["-setnumber", key, str(value)]
    subprocess.run([*words, str(ROOT / "scenes" / "three-sphere.geo")], check=True, capture_output=True)
    overrides = [f"domain.file={file}", f"bodies.left.position=[{-arm}, 0, 0]"]
    return ROOT / "scenes" / "three-sphere-mesh.toml", [*overrides, f"bodies.right.position=[{arm}, 0, 0]"], arm


def stroke(scene, overrides, motion, arm, part):
    """The run in which both arms close one after the other to a part of their length, and open."""
    lengths = [part * arm, part * arm, arm, arm]
    phases = [f"gait.phases.{k}.length={length}" for k, length in enumerate(lengths)]
    overrides = [*overrides, *phases, f"fem.mesh_motion={motion}", "model.accept=best"]
    return swim("run", scene, "--out", ROOT / "out" / "mesh-motions", overrides=overrides)


def rows(scene, overrides, arm, exact=None):
    for motion in MOTIONS:
        try:
            found = stroke(scene, overrides, motion, arm, 0.6)
        except Refused as error:
            yield [motion, f"refused: {error}"]
            continue
        net = found["displacement"]["centre"][0]
        print(f"{motion}: {len(found['meshes'])} meshes, net {net:.6f}", file=sys.stderr)
        row = [motion, len(found["meshes"]), found["solves"], f"{net:.6f}"]
        row += [f"{found['error_estimate']['total']:.1e}"]
        row += ["-" if exact is None else f"{abs(net - exact):.1e}"]
        yield row + [f"{found['seconds'][key]:.1f}" for key in ("mesh", "total")]


HEAD = ["fem.mesh_motion", "new meshes", "solves", "net displacement", "bar", "error"]
HEAD += ["seconds for meshes", "seconds in total"]


def main():
    chosen = arguments(__doc__)
    # Not every motion preserves symmetry planes; here all move the same mesh.
    overrides = ["fem.surface_size=0.7", "fem.symmetry=off"]
    default = ROOT / "scenes" / "three-sphere.toml"
    parts = ["## Generated mesh, size 0.7", table(HEAD, rows(default, overrides, 10, NET))]
    names = ["fast"] if chosen.quick else list(FILES)
    choices = [("ball", "hxt")] if chosen.quick else [(c, a) for c in CONTAINERS for a in ALGORITHMS]
    if shutil.which("gmsh") is None:
        names = []
    for container, algorithm in choices:
        for name in names:
            with tempfile.TemporaryDirectory() as folder:
                try:
                    scene, overrides, arm = scene_of_file(name, container, algorithm, folder)
                except subprocess.CalledProcessError as error:
                    print(f"{container}-{algorithm}-{name}: {error}", file=sys.stderr)
                    continue
                exact = NET if (container, arm) == ("ball", 10) else None
                parts.append(f"## {container}-{algorithm}-{name}: arms {arm}")
                parts.append(table(HEAD, list(rows(scene, overrides, arm, exact))))
    text = page(
        "Mesh motions on generated meshes and on meshes of Gmsh",
        "mesh_motions.py",
        "Three spheres of radius 1 on a line. The arms close by four tenths one after the other and open "
        "again (from 10 to 6: the default stroke). New meshes are generated, or moved by another method, "
        "when the moved one would have a poor quality. Meshes of Gmsh: `scenes/three-sphere.geo` with "
        "-optimize_netgen; size, growth and largest size: "
        + "; ".join(f"*{name}* {s}, {g}, {m}" for name, (s, g, m, _) in FILES.items())
        + ".",
        *parts,
    )
    (chosen.out / "ale-files.md").write_text(text)


if __name__ == "__main__":
    main()
