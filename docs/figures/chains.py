"""Chains of three to six spheres: the best stroke, and the one that learning finds.

Writes chains.md and chains.svg. Tables and strokes are kept in out/chains, with which an
interrupted study continues.
"""

import json
import math
import time

from figures import ROOT, arguments, chart, page, swim, table

# Lengths of extended and contracted arms in radii, those of the three-sphere swimmer of Table 1.
EXTENDED, CONTRACTED = 10, 6

# Numbers of spheres, and the displacement per step of the learned cycle: the largest mean of a
# cycle over all states of the joints (Karp 1978), `swim learn`; the first two are exact ones.
LEARNED = {3: 0.039951335, 4: 0.064539809, 5: 0.0817748, 6: 0.0947868}

# Largest relative error of the displacement of the learned cycle by a table of degree 4, whose
# coefficients decrease by a factor of 3 + sqrt(8) per degree.
MAX_ERROR = 1e-3


def scene(spheres):
    """A chain along x whose gait is the learned cycle.

    All arms contract one after the other, then extend in the same order.
    """
    lines = ['model.kind = "multipole"', 'domain.kind = "unbounded"']
    # Four digits for three spheres; tables of more joints are coarser.
    if spheres == 3:
        lines += ["optimise.tolerance = 2e-4"]
    else:
        lines += ["optimise.tolerance = 1e-2", "optimise.terms = 16"]
    for k in range(spheres):
        x = EXTENDED * k
        lines += ["[[bodies]]", f'name = "s{k}"', "radius = 1", f"position = [{x}, 0, 0]"]
    arms = range(spheres - 1)
    for k in arms:
        lines += ["[[links]]", f'name = "a{k}"', f'body = "s{k}"', f'to = "s{k + 1}"']
    for length in (CONTRACTED, EXTENDED):
        for k in arms:
            lines += ["[[gait.phases]]", f'link = "a{k}"', f"length = {length}"]
    return "\n".join(lines) + "\n"


def chain(spheres, known):
    """The row of the table, and the two efficiencies."""
    start = time.perf_counter()
    folder = ROOT / "out" / "chains" / str(spheres)
    found = swim("optimise", scene(spheres), "--out", folder)
    # Drag of all spheres, with radius and viscosity 1.
    drag = 6 * math.pi * spheres
    run = found["run"]
    efficiency = drag * run["displacement"] ** 2 / (run["energy"] * found["period"])
    gait = found["gait"]
    learned = drag * gait["displacement"] ** 2 / gait["period_energy_product"]
    per_step = gait["displacement"] / (2 * (spheres - 1))
    assert abs(per_step / known - 1) < MAX_ERROR, f"{spheres} spheres: {per_step} instead of {known}"
    errors = found["table"]
    row = [
        spheres,
        f"{efficiency:.4e}",
        f"{run['displacement']:.5f} ± {run['displacement_error']:.5f}",
        f"{found['displacement']:.5f}",
        f"{100 * found['refinement_error']:.2f} %",
        f"{learned:.4e}",
        f"{per_step:.6f}",
        errors["points"],
        f"{sum(errors['errors']):.1e}",
        found["terms"],
        f"{time.perf_counter() - start:.0f}",
    ]
    print(json.dumps(row))
    return row, efficiency, learned


def main():
    chosen = arguments(__doc__)
    sizes = [3] if chosen.quick else list(LEARNED)
    found = [chain(spheres, LEARNED[spheres]) for spheres in sizes]
    text = page(
        "Chains of spheres",
        "chains.py",
        f"Equal spheres in a row, in unbounded fluid, each arm between {CONTRACTED} and {EXTENDED} "
        "radii: the closed stroke of the highest Lighthill efficiency `6 π μ r Δ² / (E T)`, with the "
        "sum `r` of the radii. Displacement and energy are those of the run of the optimum by "
        'multipoles, without the table. "Refinement" is the change of the efficiency by the last '
        "doubling of the number of terms.",
        "The learned cycle contracts the arms one after the other and extends them in the same "
        "order: the best cycle of the states that [`swim learn`](design.md#swim-learn) knows. Its "
        "efficiency is that at constant power, by the table.",
        "![Efficiency against the number of spheres](chains.svg)",
        table(
            [
                "spheres",
                "efficiency",
                "displacement per cycle",
                "by the table",
                "refinement",
                "efficiency, learned",
                "displacement per step, learned",
                "shapes",
                "table error per unit rate",
                "terms",
                "time, s",
            ],
            [row for row, _, _ in found],
        ),
    )
    (chosen.out / "chains.md").write_text(text)
    best = [(row[0], efficiency) for row, efficiency, _ in found]
    learned = [(row[0], efficiency) for row, _, efficiency in found]
    if len(found) > 1:
        chart(
            chosen.out / "chains.svg",
            "number of spheres",
            "Lighthill efficiency",
            [("best stroke", best, "both"), ("learned cycle, at constant power", learned, "both")],
        )


if __name__ == "__main__":
    main()
