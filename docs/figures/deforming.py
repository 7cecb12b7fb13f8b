"""The pushmepullyou beside the formula for large distances, and a tail beside slender-body theories.

Writes deforming.md, pushmepullyou.svg and tail.svg. Small slopes of the theories are checked first.
"""

import math

from figures import arguments, chart, page, swim, table
from helix import cross, solve

TUBE, LENGTH = 0.3, 8.0  # of the tail, which has one wave
SLOPES = [0.2, 0.4, 0.6, 0.8]
MIDDLE = 0.6  # slope of the table of sizes
PHASES = [k * math.pi / 4 for k in range(4)]
PARTS = 24  # of the centreline in slender-body theory
FACTORS = [2.0, 1.5, 1.1]  # on the default element sizes
RATIOS = [2.45, 2.6, 3, 3.5, 4, 5, 6, 8, 10, 14]  # shortest arms


def pushmepullyou(near):
    """Displacement of the left sphere in a stroke that doubles the distance, by expansions."""
    radii = [1, 2 ** (1 / 3)]
    small, large = [4 / 3 * math.pi * a**3 for a in radii]
    exchange = '[[gait.phases]]\ntargets = {{ "left.volume" = {!r}, "right.volume" = {!r} }}'
    arm = '[[gait.phases]]\nlink = "arm"\nlength = {!r}'
    phases = [
        arm.format(float(2 * near)),
        exchange.format(large, small),
        arm.format(float(near)),
        exchange.format(small, large),
    ]
    found = swim(
        "run",
        f"""model = {{ kind = "multipole", tolerance = 1e-6 }}
bodies = [
    {{ name = "left", radius = 1, position = [{-near / 2}, 0, 0] }},
    {{ name = "right", radius = {radii[1]!r}, position = [{near / 2}, 0, 0] }},
]
links = [{{ name = "arm", body = "right", to = "left" }}]
"""
        + "\n".join(phases),
    )
    return found["displacement"]["left"][0]


def far_field(near):
    """The same to leading order in radii over distances (Avron, Kenneth & Oaknin 2005).

    With the radii 1 and 2^(1/3) the middle moves by `(a1 - a2) / (2 (a1 + a2))` of each change of
    the distance, and by `dV / (4 pi l^2)` of each exchange of the volume 4 pi / 3.
    """
    a, b = 1, 2 ** (1 / 3)
    return (a - b) / (a + b) * near + (1 / (2 * near) ** 2 - 1 / near**2) / 3


def centreline(slope, phase, points):
    """Points of the centreline, tangents and velocities for a rate of one of the phase.

    `y = (a / k) sin(k s - phi)`; the length of arc determines x, which is zero in the middle, and
    x and its derivative are functions of `k s - phi` and a constant.
    """
    k = 2 * math.pi / LENGTH

    def along(s):
        return math.sqrt(1 - (slope * math.cos(k * s - phase)) ** 2)

    middle, parts = LENGTH / 2, 400

    def distance(s):
        step = (s - middle) / parts
        return step * sum(along(middle + (i + 0.5) * step) for i in range(parts))

    found = []
    for s in points:
        sin, cos = math.sin(k * s - phase), math.cos(k * s - phase)
        found.append(
            (
                [distance(s), slope / k * sin, 0.0],
                [along(s), slope * cos, 0.0],
                [-(along(s) - along(middle)) / k, -slope / k * cos, 0.0],
            )
        )
    return found


def free_motion(line, weight, drag):
    """Speed along x of a free tail: velocities give forces by a linear map."""
    columns = []
    for column in range(7):
        unit = [float(i == column % 3) for i in range(3)]
        velocities = [
            (unit if column < 3 else cross(unit, x)) if column < 6 else moved
            for x, _, moved in line
        ]
        forces = drag(velocities)
        total = [0.0] * 6
        for (x, _, _), force in zip(line, forces):
            for row, value in enumerate(force + cross(x, force)):
                total[row] += weight * value
        columns.append(total)
    matrix = [[columns[c][r] for c in range(6)] for r in range(6)]
    return solve(matrix, [-value for value in columns[6]])[0]


def coefficients(name):
    """Drag per length along and across: Gray & Hancock (1955) with the wave, Lighthill (1976)."""
    if name == "Gray & Hancock":
        logarithm = math.log(2 * LENGTH / TUBE)
        return 2 * math.pi / (logarithm - 0.5), 4 * math.pi / (logarithm + 0.5)
    logarithm = math.log(0.18 * LENGTH / TUBE)
    return 2 * math.pi / logarithm, 4 * math.pi / (logarithm + 0.5)


def mean(speed):
    """Over the phases; half a turn later the tail is mirrored."""
    return sum(speed(phase) for phase in PHASES) / len(PHASES)


def resistive(name, slope):
    return mean(lambda phase: resistive_at(name, slope, phase))


def resistive_at(name, slope, phase):
    count = 100
    line = centreline(slope, phase, [(k + 0.5) * LENGTH / count for k in range(count)])
    along, across = coefficients(name)

    def drag(velocities):
        forces = []
        for (_, t, _), u in zip(line, velocities):
            slip = sum(a * b for a, b in zip(t, u))
            forces.append([across * v + (along - across) * slip * a for a, v in zip(t, u)])
        return forces

    return free_motion(line, LENGTH / count, drag)


def slender(slope):
    return mean(lambda phase: slender_at(slope, phase))


def slender_at(slope, phase):
    """Slender-body theory: forces and doublets on the centreline (Hancock 1953).

    The velocity of a section is the flow of all of them at the distance `a` from the centreline,
    `(I / R + r r / R^3 + a^2 / 2 (I / R^3 - 3 r r / R^5)) f / 8 pi` with `R^2 = r^2 + a^2`: of a
    straight line the integral is that of Lighthill's theory with the cut at `a sqrt(e) / 2`.
    """
    line = centreline(slope, phase, [(k + 0.5) * LENGTH / PARTS for k in range(PARTS)])
    weight = LENGTH / PARTS
    matrix = [[0.0] * 3 * PARTS for _ in range(3 * PARTS)]
    for i, (x, _, _) in enumerate(line):
        for j, (y, _, _) in enumerate(line):
            r = [p - q for p, q in zip(x, y)]
            square = sum(c * c for c in r) + TUBE**2
            factor = weight / (8 * math.pi * math.sqrt(square))
            for a in range(3):
                for b in range(3):
                    matrix[3 * i + a][3 * j + b] = factor * (
                        (a == b) * (1 + TUBE**2 / 2 / square)
                        + r[a] * r[b] / square * (1 - 3 * TUBE**2 / 2 / square)
                    )

    def drag(velocities):
        found = solve(matrix, [v for u in velocities for v in u])
        return [found[3 * i : 3 * i + 3] for i in range(PARTS)]

    return free_motion(line, weight, drag)


def by_elements(slope, factor):
    found = [instant(slope, factor, phase) for phase in PHASES]
    speeds = [of["bodies"][0]["velocity"][0] for of in found]
    bars = [of["error_estimate"]["total"] for of in found]
    dofs = found[0]["dofs"]["total"]
    print(f"slope {slope}, factor {factor}: {dofs} dofs")
    return sum(speeds) / len(PHASES), sum(bars) / len(PHASES), dofs


def instant(slope, factor, phase):
    return swim(
        "solve",
        f"""fem.size_factor = {factor}
bodies = [{{ name = "worm", shape = "tube", length = {LENGTH}, radius = {TUBE}, position = [0, 0, 0],
             deformation = {{ kind = "undulation", wave = "displacement", amplitude = {slope}, phase = {phase!r} }} }}]
gait.phases = [{{ targets = {{ "worm.phase" = {phase + 2 * math.pi!r} }}, duration = {2 * math.pi!r} }}]""",
    )


def check():
    """The speed of small slopes is quadratic."""
    for name in ("Gray & Hancock", "Lighthill"):
        ratio = resistive(name, 0.02) / resistive(name, 0.01)
        assert abs(ratio - 4) < 1e-2, ratio


def main():
    chosen = arguments(__doc__)
    check()
    ratios = RATIOS[2:4] if chosen.quick else RATIOS
    strokes = [(near, pushmepullyou(near), far_field(near)) for near in ratios]
    relative = [(near, -found / near) for near, found, _ in strokes]
    fine = [2.3 + 0.1 * k for k in range(118)]
    chart(
        chosen.out / "pushmepullyou.svg",
        "shortest distance of the centres, radii",
        "displacement over the change of the distance",
        [
            ("expansions, exact to 1e-6", relative, "points"),
            ("formula for large distances", [(l, -far_field(l) / l) for l in fine], "line"),
        ],
    )
    slopes = SLOPES[2:3] if chosen.quick else SLOPES
    factors = FACTORS[1:2] if chosen.quick else FACTORS
    middle = [(factor, *by_elements(MIDDLE, factor)) for factor in factors]
    known = {MIDDLE: next(found[1:] for found in middle if found[0] == FACTORS[1])}
    speeds = [(slope, known.get(slope) or by_elements(slope, FACTORS[1])) for slope in slopes]
    theories = [
        ("resistive forces, Gray & Hancock 1955", lambda a: resistive("Gray & Hancock", a)),
        ("resistive forces, Lighthill 1976", lambda a: resistive("Lighthill", a)),
        ("slender body", slender),
    ]
    curve = [0.06 * k for k in range(1, 15)]
    chart(
        chosen.out / "tail.svg",
        "slope of the wave",
        "speed, radii of the tube per radian",
        [
            ("finite elements", [(slope, -u / TUBE) for slope, (u, _, _) in speeds], "points"),
            *(
                (name, [(slope, -theory(slope) / TUBE) for slope in curve], "line")
                for name, theory in theories
            ),
        ],
    )
    text = page(
        "Bodies that deform, and theories",
        "deforming.py",
        "## The pushmepullyou\n\nTwo spheres of the radii 1 and 2^(1/3) on an arm whose length doubles, exchange "
        "their volumes, come together, and exchange them back. Displacement of the left sphere, by expansions "
        "(error below 1e-6), beside the formula for large distances (Avron, Kenneth & Oaknin 2005), whose error "
        "decreases as the inverse of the distance.",
        "![Displacement of the pushmepullyou against the shortest distance](pushmepullyou.svg)",
        table(
            ["distances", "displacement", "formula", "error of the formula"],
            [
                [f"{l:g} to {2 * l:g}", f"{u:.6f}", f"{v:.6f}", f"{100 * (v / u - 1):.1f} %"]
                for l, u, v in strokes
            ],
        ),
        f"## A tail\n\nA free tube of the length {LENGTH:g} and the radius {TUBE} with one wave of displacement, "
        "and a rate of one of its phase: the mean of its speeds towards its front at four phases. Resistive-force theory has a "
        "drag per length along and across the centreline, with the wave in its logarithm; slender-body theory has "
        "forces on the centreline and the flow of each at the others. Both are of the first order in the "
        "inverse of the logarithm of the length over the radius; neither has the round ends.",
        "![Speed of a tail against its slope](tail.svg)",
        table(
            ["slope", "elements", *(name for name, _ in theories)],
            [
                [slope, f"{-u:.5f} ± {bar:.1e}", *(f"{-theory(slope):.5f}" for _, theory in theories)]
                for slope, (u, bar, _) in speeds
            ],
        ),
        f"### Three mesh sizes, slope {MIDDLE}",
        table(
            ["size factor", "dofs", "speed"],
            [[factor, dofs, f"{-u:.6f} ± {bar:.1e}"] for factor, u, bar, dofs in middle],
        ),
    )
    (chosen.out / "deforming.md").write_text(text)


if __name__ == "__main__":
    main()
