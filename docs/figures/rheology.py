"""Errors of the speed of a squirmer against processor seconds, in a fluid of Carreau and a Newtonian one.

Writes rheology.csv and rheology.svg.
"""

import csv
import resource

from figures import arguments, chart, swim

# The squirmer of docs/book/rheology.md: a spectral program has its speed in the fluid of Carreau.
CARREAU = 'law = "carreau", zero_shear_viscosity = 1, relaxation_time = 1, index = 0.5'
NEWTONIAN = "viscosity = 1"
EXACT = {"Carreau": 0.9327406407 * 2 / 3}
# Tolerance of the multipoles for the Newtonian speed.
EXACT_TOLERANCE = 1e-12
TOLERANCES = {"Carreau": ["1e-2", "1e-3", "1e-4", "1e-5"], "Newtonian": ["1e-2", "1e-4", "1e-6"]}
SIZES = [0.9, 0.6, 0.4, 0.28, 0.2]


def solve(fluid, model):
    """Speed, error bar and processor seconds."""
    text = (
        f"fluid = {{ {fluid} }}\n{model}\ndomain = {{ kind = \"ball\", radius = 10 }}\n"
        '[[bodies]]\nname = "squirmer"\nradius = 1\nposition = [0, 0, 0]\n'
        "slip = { b1 = 1, b2 = 0, axis = [1, 0, 0] }\n"
    )
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    found = swim("solve", text)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return found["bodies"][0]["velocity"][0], found["error_estimate"]["total"], seconds


def main():
    chosen = arguments(__doc__)
    exact, rows = dict(EXACT), []
    exact["Newtonian"], _, _ = solve(
        NEWTONIAN, f'model = {{ kind = "multipole", tolerance = {EXACT_TOLERANCE}, accept = "best" }}'
    )
    for name, fluid in [("Carreau", CARREAU), ("Newtonian", NEWTONIAN)]:
        plane = [
            (f"{name}, meridian plane", tolerance,
             f'model = {{ kind = "axisymmetric", tolerance = {tolerance}, accept = "best" }}')
            for tolerance in TOLERANCES[name]
        ]
        space = [
            (f"{name}, space", size,
             f'model = {{ kind = "fem", accept = "best" }}\nfem.surface_size = {size}')
            for size in SIZES
        ]
        for series, setting, model in (plane[:1] + space[:1] if chosen.quick else plane + space):
            speed, bar, seconds = solve(fluid, model)
            error, size = abs(speed - exact[name]), exact[name]
            rows.append((series, setting, error / size, bar / size, seconds))
    with open(chosen.out / "rheology.csv", "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["series", "setting", "error", "bar", "processor_seconds"])
        for series, setting, error, bar, seconds in rows:
            table.writerow([series, setting, f"{error:.2e}", f"{bar:.2e}", f"{seconds:.2f}"])
    names = list(dict.fromkeys(row[0] for row in rows))
    series = [(name, [(row[4], row[2]) for row in rows if row[0] == name], "both") for name in names]
    chart(
        chosen.out / "rheology.svg", "processor seconds", "relative error of the speed", series,
        is_log=True, legend=250,
    )


if __name__ == "__main__":
    main()
