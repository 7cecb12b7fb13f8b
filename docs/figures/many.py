"""Seconds and memory of one instant against the number of spheres, with fitted exponents, and speed
against accuracy.

Writes many.md, many-seconds.svg, many-memory.svg and many-accuracy.svg. Swimmers of three spheres at
random places, at the same volume fraction, whose arms all contract; and cubic lattices of spheres
with random forces.
"""

import math
import os
import random
import time

from figures import arguments, chart, page, swim, table

# Numbers of swimmers.
NUMBERS = {
    "oseen": [10, 100, 1000, 3000, 10000],
    "rpy": [10, 100, 1000, 3000, 10000],
    "multipole": [10, 33, 100, 333, 1000],
}
# Spheres along an edge of the lattices, by their gaps.
LATTICES = {0.1: [3, 5, 7, 10, 14], 0.05: [3, 5, 7]}
# Numbers of swimmers of the comparison of accuracies, with tolerances and that of the reference.
COMPARED = [3, 33, 333]
TOLERANCES = [1e-1, 1e-2, 1e-3, 1e-4]
REFERENCE = 1e-5
# Edge of the cube per cube root of the number: 0.4 % of its volume are spheres.
EDGE = 15.0
# The fastest of so many rounds counts, since other load on the machine can only slow it down.
ROUNDS = 3

SWIMMER = """
model.kind = "{model}"
gait.phases = [{{ targets = {{ left = 6, right = 6 }} }}]
bodies = [
  {{ name = "l", radius = 1, position = [-10, 0, 0] }},
  {{ name = "c", radius = 1, position = [0, 0, 0] }},
  {{ name = "r", radius = 1, position = [10, 0, 0] }},
]
links = [{{ name = "left", body = "l", to = "c" }}, {{ name = "right", body = "r", to = "c" }}]
copies = [{{ of = "c", count = {copies}, size = [{edge}, {edge}, {edge}], isotropic = true, gap = 0.5 }}]
"""


def scene(model, number):
    edge = EDGE * max(number, 8) ** (1 / 3)
    return SWIMMER.format(model=model, copies=number - 1, edge=edge)


def exponent(points):
    """Slope of the last three points in logarithms."""
    logs = [(math.log(n), math.log(value)) for n, value in points[-3:]]
    x, y = (sum(column) / len(logs) for column in zip(*logs))
    return sum((a - x) * (b - y) for a, b in logs) / sum((a - x) ** 2 for a, _ in logs)


def lattice(edge, gap):
    """Spheres of radius one in a cube, with forces that are uniform between -1 and 1."""
    numbers, distance = random.Random(1), 2 + gap
    places = [(i, j, k) for i in range(edge) for j in range(edge) for k in range(edge)]
    bodies = [
        f'[[bodies]]\nname = "b{number}"\nradius = 1\nposition = {[distance * k for k in place]}\n'
        f"force = {[numbers.uniform(-1, 1) for _ in range(3)]}\n"
        for number, place in enumerate(places)
    ]
    return 'model = { kind = "multipole", tolerance = 1e-3 }\n' + "".join(bodies)


def measured(scene, *overrides):
    """The fastest solution, with the seconds of the whole command."""
    best = None
    for _ in range(ROUNDS):
        clock = time.perf_counter()
        found = swim("solve", scene, overrides=overrides)
        found["command"] = time.perf_counter() - clock
        if best is None or found["command"] < best["command"]:
            best = found
    return best


def velocities(found):
    return [body["velocity"] for body in found["bodies"]]


def largest(vectors):
    return max(math.hypot(*vector) for vector in vectors)


def rows(name, scenes, series):
    """Rows of the table from (number of spheres, scene); adds to the series of the charts."""
    fits = {"solve": [], "command": [], "memory": []}
    for count, text in scenes:
        found = measured(text)
        seconds = found["seconds"]
        bar = found["error_estimate"]["total"] / largest(velocities(found))
        yield [
            name,
            count,
            found["solver"]["iterations"] or "direct",
            f"{seconds['assembly'] + seconds['solve']:.3f}",
            f"{seconds['estimate']:.3f}",
            f"{found['command']:.2f}",
            f"{found['peak_rss_mib']:.0f}",
            f"{100 * bar:.2g} %",
        ]
        fits["solve"].append((count, seconds["total"]))
        fits["command"].append((count, found["command"]))
        fits["memory"].append((count, found["peak_rss_mib"]))
    grown = {of: f"N^{exponent(points):.2f}" for of, points in fits.items()}
    series["seconds"].append((name, fits["solve"], "both"))
    series["memory"].append((name, fits["memory"], "both"))
    yield [name, "growth", "", grown["solve"], "", grown["command"], grown["memory"], ""]


def compared(numbers):
    """Rows and series of seconds against errors: largest difference to the reference, relative."""
    lines, series = [], []
    for number in numbers:
        text = scene("multipole", number)
        exact = velocities(swim("solve", text, overrides=[f"model.tolerance={REFERENCE}"]))
        curves = {"oseen and rpy": ([], "points"), "multipole": ([], "both")}
        for model, tolerances in [("oseen", [None]), ("rpy", [None]), ("multipole", TOLERANCES)]:
            points, _ = curves["multipole" if model == "multipole" else "oseen and rpy"]
            for tolerance in tolerances:
                sets = [] if tolerance is None else [f"model.tolerance={tolerance}"]
                # a bar of point forces may exceed the tolerance
                found = measured(scene(model, number), 'model.accept="best"', *sets)
                differences = [
                    [a - b for a, b in zip(one, other)]
                    for one, other in zip(velocities(found), exact)
                ]
                error = largest(differences) / largest(exact)
                bar = found["error_estimate"]["total"] / largest(exact)
                seconds = found["seconds"]["total"]
                points.append((seconds, error))
                lines.append(
                    [3 * number, model, tolerance or "", f"{seconds:.3f}", f"{error:.1e}", f"{bar:.1e}"]
                )
        series += [(f"{name}, {3 * number} spheres", *curve) for name, curve in curves.items()]
    return lines, series


def main():
    chosen = arguments(__doc__)
    cut = slice(0, 2) if chosen.quick else slice(None)
    series = {"seconds": [], "memory": []}
    lines = []
    for model, numbers in NUMBERS.items():
        scenes = ((3 * number, scene(model, number)) for number in numbers[cut])
        lines += rows(model, scenes, series)
    for gap, edges in LATTICES.items():
        scenes = ((edge**3, lattice(edge, gap)) for edge in edges[cut])
        lines += rows(f"multipole, lattice, gap {gap}", scenes, series)
    chart(chosen.out / "many-seconds.svg", "spheres", "seconds", series["seconds"], is_log=True, legend=230)
    chart(chosen.out / "many-memory.svg", "spheres", "MiB", series["memory"], is_log=True, legend=230)
    errors, curves = compared(COMPARED[cut])
    chart(chosen.out / "many-accuracy.svg", "seconds", "relative error", curves, is_log=True, legend=230)
    headings = ["model", "spheres", "iterations", "s solution", "s error bar", "s command", "MiB", "bar"]
    text = page(
        "Many swimmers",
        "many.py",
        "One instant of swimmers of three spheres (arms of ten radii, all contracting) at random places "
        "and in random directions; 0.4 % of the volume are spheres. Lattices are cubic, of unit spheres "
        "with random forces, by multipoles at a tolerance of 1e-3. Seconds of the solution, of its error "
        "bar (`model.estimates = \"sampled\"`: up to 12 spheres by expansions of all of them, beyond by the "
        "first reflection and expansions in four neighbourhoods; of multipoles by fewer of them), and of "
        "the whole command with reading, checks and output; memory of the whole process; the error bar of "
        "the velocities relative to the largest one. Growth is fitted to the last three rows of a model; "
        "that of the solution contains the error bar. Other programs used the same cores: the load was "
        f"{os.getloadavg()[0]:.0f}.",
        table(headings, lines),
        "![Seconds against spheres](many-seconds.svg)",
        "![Memory against spheres](many-memory.svg)",
        "## Speed against accuracy",
        "The same swimmers: largest error of a velocity, relative to the largest velocity, against the "
        f"seconds with the error bar. The reference is that of multipoles at a tolerance of {REFERENCE:g}.",
        table(["spheres", "model", "tolerance", "s", "error", "bar"], errors),
        "![Speed against accuracy](many-accuracy.svg)",
    )
    (chosen.out / "many.md").write_text(text)


if __name__ == "__main__":
    main()
