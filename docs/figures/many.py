"""Seconds and memory of one instant against the number of swimmers, with fitted exponents.

Writes many.md. Swimmers of three spheres at random places, at the same volume fraction, whose arms
all contract.
"""

import math
import os
import time

from figures import arguments, page, swim, table

NUMBERS = {
    "oseen": [10, 100, 1000, 3000, 10000],
    "rpy": [10, 100, 1000, 3000, 10000],
    "multipole": [3, 6, 12, 24],
}
QUICK = {model: numbers[:2] for model, numbers in NUMBERS.items()}
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


def measured(model, number, *overrides):
    """The fastest solution, with the seconds of the whole command."""
    best = None
    for _ in range(ROUNDS):
        clock = time.perf_counter()
        found = swim("solve", scene(model, number), overrides=overrides)
        found["command"] = time.perf_counter() - clock
        if best is None or found["command"] < best["command"]:
            best = found
    return best


def rows(model, numbers):
    fits = {"solve": [], "command": [], "memory": []}
    for number in numbers:
        found = measured(model, number)
        seconds, speed = found["seconds"], max(
            math.hypot(*body["velocity"]) for body in found["bodies"]
        )
        yield [
            model,
            3 * number,
            found["solver"]["iterations"] or "direct",
            f"{seconds['assembly'] + seconds['solve']:.3f}",
            f"{seconds['estimate']:.3f}",
            f"{found['command']:.2f}",
            f"{found['peak_rss_mib']:.0f}",
            f"{100 * found['error_estimate']['total'] / speed:.2f} %",
        ]
        fits["solve"].append((number, seconds["total"]))
        fits["command"].append((number, found["command"]))
        fits["memory"].append((number, found["peak_rss_mib"]))
    grown = {name: f"N^{exponent(points):.2f}" for name, points in fits.items()}
    yield [model, "growth", "", grown["solve"], "", grown["command"], grown["memory"], ""]


def main():
    chosen = arguments(__doc__)
    numbers = QUICK if chosen.quick else NUMBERS
    headings = ["model", "spheres", "iterations", "s solution", "s error bar", "s command", "MiB", "bar"]
    lines = [line for model, counts in numbers.items() for line in rows(model, counts)]
    text = page(
        "Many swimmers",
        "many.py",
        "One instant of swimmers of three spheres (arms of ten radii, all contracting) at random places "
        "and in random directions; 0.4 % of the volume are spheres. Seconds of the solution, of its error "
        "bar (`model.estimates = \"sampled\"`: up to 12 spheres by expansions of all of them, beyond by the "
        "first reflection and expansions in four neighbourhoods), and of the whole command with reading, "
        "checks and output; memory of the whole process; the error bar of the velocities relative to the "
        "largest one. Growth is fitted to the last three rows of a model; that of the solution contains "
        f"the error bar. Other programs used the same cores: the load was {os.getloadavg()[0]:.0f}.",
        table(headings, lines),
    )
    (chosen.out / "many.md").write_text(text)


if __name__ == "__main__":
    main()
