"""A helix under a torque along its axis: finite elements and resistive-force theory.

Writes helix.md and helix.svg. The check of resistive-force theory against the force balance of an
infinite helix runs first.
"""

import math
import time

from figures import arguments, chart, page, swim, table

TUBE = 0.1  # radius of the tube over that of the helix
TURNS = 2
COARSE = 2.0  # factor on the default element sizes, for the picture
FACTORS = [1.4, 1.0, 0.7]  # of the table of sizes
ANGLES = [20, 30, 40, 50, 60, 70]  # between the curve and the axis, in degrees
MIDDLE = 40  # angle of the table of sizes


def pitch(angle):
    return 2 * math.pi / math.tan(math.radians(angle))


def by_elements(angle, factor):
    start = time.perf_counter()
    found = swim(
        "solve",
        f"""model.kind = "fem"
fem.size_factor = {factor}
bodies = [{{ name = "helix", shape = "helix", radius = 1, tube_radius = {TUBE}, pitch = {pitch(angle)}, \
turns = {float(TURNS)}, position = [0, 0, 0], torque = [1, 0, 0] }}]""",
    )
    found["time"] = time.perf_counter() - start
    print(f"{angle} degrees, factor {factor}: {found['dofs']['total']} dofs, {found['time']:.1f} s")
    return found


def advance(solution):
    """Distance per turn of a solution."""
    body = solution["bodies"][0]
    return 2 * math.pi * body["velocity"][0] / body["angular_velocity"][0]


def gray_hancock(angle):
    """Drag per length along and across a thin curve (Gray & Hancock 1955): a wave is a pitch."""
    logarithm = math.log(2 * pitch(angle) / TUBE)
    return 2 * math.pi / (logarithm - 0.5), 4 * math.pi / (logarithm + 0.5)


def lighthill(angle):
    """The same of Lighthill (1976): with q = 0.09 of the length of the curve per turn."""
    length = 2 * math.pi / math.sin(math.radians(angle))
    logarithm = math.log(2 * 0.09 * length / TUBE)
    return 2 * math.pi / logarithm, 4 * math.pi / (logarithm + 0.5)


def solve(matrix, rhs):
    """Gauss elimination with partial pivoting."""
    rows = [list(row) + [b] for row, b in zip(matrix, rhs)]
    n = len(rows)
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(n):
            if i != k:
                factor = rows[i][k] / rows[k][k]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k])]
    return [rows[k][n] / rows[k][k] for k in range(n)]


def cross(a, b):
    return [a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3)]


def resistive_advance(drag, angle, turns=TURNS):
    """Distance per turn by resistive-force theory, with the six motions of a free helix.

    The drag is integrated along the curve by the midpoint rule, whose error is below the width of
    a line of the picture.
    """
    along, across = drag(angle)
    count = math.ceil(400 * turns)
    rise = pitch(angle) / (2 * math.pi)
    length = math.hypot(rise, 1)
    matrix = [[0.0] * 6 for _ in range(6)]
    for k in range(count):
        theta = 2 * math.pi * turns * ((k + 0.5) / count - 0.5)
        sin, cos = math.sin(theta), math.cos(theta)
        place = [rise * theta, cos, sin]
        tangent = [rise / length, -sin / length, cos / length]
        weight = length * 2 * math.pi * turns / count
        for column in range(6):
            unit = [float(i == column % 3) for i in range(3)]
            velocity = unit if column < 3 else cross(unit, place)
            slip = sum(t * v for t, v in zip(tangent, velocity))
            force = [
                weight * (across * v + (along - across) * slip * t)
                for t, v in zip(tangent, velocity)
            ]
            for row, value in enumerate(force + cross(place, force)):
                matrix[row][column] += value
    motion = solve(matrix, [0, 0, 0, 1, 0, 0])
    return 2 * math.pi * motion[0] / motion[3]


def check():
    """The speed of a long helix is that of the force balance along the axis of an infinite one."""
    for angle in (25, 45, 65):
        along, across = gray_hancock(angle)
        ratio, radians = across / along, math.radians(angle)
        sin, cos = math.sin(radians), math.cos(radians)
        exact = 2 * math.pi * (ratio - 1) * sin * cos / (ratio * sin**2 + cos**2)
        error = [abs(resistive_advance(gray_hancock, angle, n) / exact - 1) for n in (20, 40)]
        # Whole turns: the other motions decay as the inverse square of the length.
        assert error[1] < 1e-3 and error[1] < 0.3 * error[0], (angle, error)


def main():
    chosen = arguments(__doc__)
    check()
    angles, factors = (ANGLES[4:], []) if chosen.quick else (ANGLES, FACTORS)
    rows = []
    for factor in factors:
        found = by_elements(MIDDLE, factor)
        before, after = found["uncorrected"], found
        rows.append(
            [
                factor,
                found["dofs"]["total"],
                f"{before['bodies'][0]['velocity'][0]:.6e}",
                f"{after['bodies'][0]['velocity'][0]:.6e} ± {found['error_estimate']['total']:.1e}",
                f"{advance(before):.5f}",
                f"{advance(after):.5f}",
                f"{found['time']:.1f}",
            ]
        )
    advances = [(angle, advance(by_elements(angle, COARSE))) for angle in angles]
    theories = [("Gray & Hancock 1955", gray_hancock), ("Lighthill 1976", lighthill)]
    of_theories = [
        [angle, f"{found:.4f}", *(f"{resistive_advance(drag, angle):.4f}" for _, drag in theories)]
        for angle, found in advances
    ]
    text = page(
        "A helix and resistive-force theory",
        "helix.py",
        f"A right-handed helix of {TURNS} turns with a tube of {TUBE} radii, in unbounded fluid, free "
        "under a unit torque along its axis; radius and viscosity are 1. The curve of the helix has "
        "the angle `atan(2 π radius / pitch)` with the axis. Resistive-force theory has a drag per "
        "length for motion along and across the curve and no interaction between its parts; both "
        f"variants are integrated along the curve of the same {TURNS} turns, without the ends.",
        "![Distance per turn against the angle](helix.svg)",
        table(["angle, degrees", "elements", *(name for name, _ in theories)], of_theories),
        f"## Three mesh sizes, {MIDDLE} degrees",
        table(
            [
                "size factor",
                "dofs",
                "speed, uncorrected",
                "speed",
                "distance per turn, uncorrected",
                "distance per turn",
                "time, s",
            ],
            rows,
        ),
    )
    (chosen.out / "helix.md").write_text(text)
    curves = [
        (name, [(a, resistive_advance(drag, a)) for a in range(20, 71, 2)], "line")
        for name, drag in theories
    ]
    chart(
        chosen.out / "helix.svg",
        "angle between curve and axis, degrees",
        "distance per turn, radii",
        [("finite elements", advances, "points"), *curves],
    )


if __name__ == "__main__":
    main()
