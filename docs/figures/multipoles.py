"""Processor time of multipole expansions of many spheres, against what `swim check` predicts.

Writes multipoles.md. Spheres in cubic lattices with a force of random direction on each; processor
time, because other programs may use the same cores.
"""

import math
import random
import re
import resource

from figures import arguments, page, swim, swim_text, table

CASES = [
    (number, gap, tolerance)
    for number, gaps, tolerances in [
        (27, [1, 0.4, 0.1, 0.05], [1e-2, 1e-3, 1e-5]),
        (64, [1, 0.4, 0.1], [1e-2, 1e-3]),
        (125, [1, 0.4, 0.1, 0.05], [1e-3]),
    ]
    for gap in gaps
    for tolerance in tolerances
]
SECONDS = {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0}


def scene(number, gap, tolerance):
    edge = math.ceil(number ** (1 / 3) - 1e-9)
    chosen = random.Random(number)
    lines = [f'model.kind = "multipole"', f"model.tolerance = {tolerance}"]
    for k in range(number):
        place = [(2 + gap) * c for c in (k % edge, k // edge % edge, k // edge**2)]
        force = [chosen.gauss(0, 1) for _ in range(3)]
        lines += ["[[bodies]]", f'name = "s{k}"', "radius = 1", f"position = {place}", f"force = {force}"]
    return "\n".join(lines) + "\n"


def processor_seconds(work):
    """What `work` returns, with the processor time of the commands in it."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    found = work()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return found, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def rows(cases):
    for number, gap, tolerance in cases:
        text = scene(number, gap, tolerance)
        said = swim_text("check", text)
        seconds, unit, mib = re.search(r"cost per solve\s+([\d.]+) (\w+), (\d+) MiB", said).groups()
        predicted = 2 * float(seconds) * SECONDS[unit]
        found, measured = processor_seconds(lambda: swim("solve", text))
        speed = max(math.hypot(*body["velocity"]) for body in found["bodies"])
        yield [
            number,
            gap,
            f"{tolerance:.0e}",
            found["solver"]["iterations"],
            f"{predicted:.2f}",
            f"{measured:.2f}",
            f"{predicted / measured:.2f}",
            mib,
            f"{found['peak_rss_mib']:.0f}",
            f"{found['error_estimate']['total'] / speed:.1e}",
        ]


def main():
    chosen = arguments(__doc__)
    headings = [
        "spheres",
        "gap",
        "tolerance",
        "iterations",
        "s predicted",
        "s measured",
        "ratio",
        "MiB predicted",
        "MiB measured",
        "bar",
    ]
    text = page(
        "Multipoles of many spheres",
        "multipoles.py",
        "Spheres of radius 1 in cubic lattices with a force of random direction on each, by `swim solve` "
        "with `model.kind = \"multipole\"`. Processor time of the whole command and twice the seconds on two "
        "cores that `swim check` predicts; memory of the couplings predicted, and of the whole process "
        "measured; the error bar of the velocities relative to the largest one.",
        table(headings, rows(CASES[:3] if chosen.quick else CASES)),
    )
    (chosen.out / "multipoles.md").write_text(text)


if __name__ == "__main__":
    main()
