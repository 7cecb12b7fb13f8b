"""Speed against accuracy: drag, swimming speed and net displacement by all methods.

Writes accuracy.md, accuracy.csv and two charts per quantity. About an hour at full size.
"""

import csv
import math
import sys

from figures import ROOT, arguments, chart, page, swim, table

# Exact values (crates/studies/src/reference.rs). The drag of a sphere in a ball of ten radii: Haberman
# & Sayre 1958. Two spheres pushed together with a gap of half a radius: Stimson & Jeffery 1926; the
# forces add up to zero, so the wall at 800 radii changes the speed by less than (2.5 / 800)^3.
LAMBDA = 0.1
DRAG = (1 - LAMBDA**5) / (1 - 2.25 * LAMBDA + 2.5 * LAMBDA**3 - 2.25 * LAMBDA**5 + LAMBDA**6)
PAIR = 2.772418679559134
SPEED = -0.3428979021151601
NET, UNBOUNDED_NET = 0.1604180159643671, 0.1598053403881754

# Kinds of meshes: name, geometry, and whether symmetry planes are used.
MESHES = [
    ("finite elements, curved", "curved", "auto"),
    ("whole fluid, curved", "curved", "off"),
    ("whole fluid, straight", "straight", "off"),
]
SIZES, QUICK_SIZES = [0.8, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15], [0.8, 0.5]
TARGETS, QUICK_TARGETS = [1e-2, 3e-3, 1e-3, 3e-4, 1e-4], [1e-2]

# Explicit Euler with the time step of the paper, a tenth of a phase.
PAPER_STEPS = 10

PAIR_SCENE = [
    "domain.radius=800",
    "bodies.front.position=[1.25, 0, 0]",
    "bodies.front.force=[-1, 0, 0]",
    "bodies.back.position=[-1.25, 0, 0]",
    "bodies.back.force=[1, 0, 0]",
]


def sum_of_forces_over_speed(bodies):
    force, velocity = (bodies[0][key][0] - bodies[1][key][0] for key in ("force", "velocity"))
    return force / velocity


# Quantities at the start of a scene: title, exact value, scene, overrides, and the value of bodies.
START = {
    "drag": (
        "drag of a sphere in a ball of ten radii",
        6 * math.pi * DRAG,
        "sphere-in-ball",
        ["domain.radius=10"],
        lambda bodies: bodies[0]["force"][0] / bodies[0]["velocity"][0],
    ),
    "pair": (
        "resistance of two spheres half a radius apart, pushed together",
        6 * math.pi * PAIR,
        "two-spheres",
        PAIR_SCENE,
        sum_of_forces_over_speed,
    ),
    "speed": (
        "velocity of the three-sphere swimmer's centre in a ball of radius 40",
        SPEED,
        "three-sphere",
        ["gait.phases.0.duration=4"],
        lambda bodies: bodies[1]["velocity"][0],
    ),
}


def point(method, choice, size, dofs, seconds, error, uncorrected, bar):
    found = locals()
    print(f"{method}, {choice}: error {error:.1e}, {seconds:.2f} s", file=sys.stderr)
    return found


def at_start(key, method, choice, overrides, size=None):
    """The point of a method for a quantity at the start of its scene."""
    _, exact, scene, base, value = START[key]
    found = swim("solve", ROOT / "scenes" / f"{scene}.toml", overrides=base + overrides)
    bodies, before = found["bodies"], found["uncorrected"]
    # All quantities belong to the body in the middle.
    speed = math.hypot(*bodies[len(bodies) // 2]["velocity"])
    return point(
        method,
        choice,
        size,
        found["dofs"]["total"],
        found["seconds"]["total"],
        abs(value(bodies) / exact - 1),
        abs(value(before["bodies"]) / exact - 1) if before else None,
        found["error_estimate"]["total"] / speed or None,
    )


def stroke(method, choice, overrides, size=None, exact=NET):
    """The point of a stroke of the default scene; its dofs are those of the first mesh."""
    scene = ROOT / "scenes" / "three-sphere.toml"
    overrides = [*overrides, "model.accept=best"]
    dofs = swim("solve", scene, overrides=overrides)["dofs"]["total"]
    found = swim("run", scene, "--out", ROOT / "out" / "accuracy", overrides=overrides)
    net, before = found["displacement"]["centre"][0], found["uncorrected"]
    bars = found["error_estimate"]
    return point(
        method,
        choice,
        size,
        dofs,
        found["seconds"]["total"],
        abs(net / exact - 1),
        abs(before["displacement"]["centre"][0] / exact - 1) if before else None,
        # Without an estimate of the integration error, the sum of the others is no error bar.
        bars["total"] / abs(net) if "integration" in bars else None,
    )


def euler(method, choice, overrides, steps):
    """The point of the stroke by explicit Euler, each step with a mesh of its own."""
    x, seconds, arms = 0.0, 0.0, [10.0, 10.0]
    for arm, goal in ((0, 6.0), (1, 6.0), (0, 10.0), (1, 10.0)):
        change = (goal - arms[arm]) / steps
        for _ in range(steps):
            now = [
                f"bodies.left.position=[{x - arms[0]}, 0, 0]",
                f"bodies.centre.position=[{x}, 0, 0]",
                f"bodies.right.position=[{x + arms[1]}, 0, 0]",
                f"gait.phases.0.link={('left-arm', 'right-arm')[arm]}",
                f"gait.phases.0.length={arms[arm] + change}",
                f"gait.phases.0.duration={1 / steps}",
            ]
            scene = ROOT / "scenes" / "three-sphere.toml"
            found = swim("solve", scene, overrides=[*overrides, *now, "fem.estimates=off"])
            x += found["bodies"][1]["velocity"][0] / steps
            arms[arm] += change
            seconds += found["seconds"]["total"]
    dofs = found["dofs"]["total"]
    return point(method, choice, None, dofs, seconds, abs(x / NET - 1), None, None)


def meshes(compute, sizes):
    """Points of all kinds of meshes of the given sizes."""
    for method, geometry, symmetry in MESHES:
        for size in sizes:
            overrides = [f"fem.surface_size={size}", f"fem.geometry={geometry}"]
            overrides.append(f"fem.symmetry={symmetry}")
            yield compute(method, f"size {size}", overrides, size)


def start_points(key, quick):
    def compute(*choice):
        return at_start(key, *choice)

    yield from meshes(compute, QUICK_SIZES if quick else SIZES)
    if key != "speed":
        for target in QUICK_TARGETS if quick else TARGETS:
            choice = f"target {target:.0e}"
            yield compute("finite elements, curved, adapted", choice, [f"fem.target={target}"])
    for tolerance in (1e-2, 1e-4, 1e-6):
        overrides = ["model.kind=axisymmetric", f"model.tolerance={tolerance}"]
        yield compute("axisymmetric elements", f"tolerance {tolerance:.0e}", overrides)
    if key == "speed":
        for formulation in ("lagrange", "direct-row"):
            choice = ["size 0.4", [f"fem.formulation={formulation}"]]
            yield compute(f"curved, {formulation}", *choice)
        for rtol in (1e-3, 1e-5):
            choice = f"size 0.4, rtol {rtol:.0e}"
            yield compute("curved, larger tolerance of the solver", choice, [f"fem.rtol={rtol}"])


def net_points(quick):
    # With finer meshes of the whole fluid, a stroke takes minutes.
    yield from meshes(stroke, [s for s in (QUICK_SIZES if quick else SIZES) if s >= 0.2])
    for target in [] if quick else TARGETS:
        method = "sizes chosen for a target error, curved"
        yield stroke(method, f"target {target:.0e}", [f"fem.target={target}"])
    for tolerance in (1e-2, 1e-4):
        overrides = ["model.kind=axisymmetric", f"model.tolerance={tolerance}"]
        yield stroke("axisymmetric elements", f"tolerance {tolerance:.0e}", overrides)
    if not quick:
        paper = ["fem.geometry=straight", "fem.surface_size=0.4"]
        method = "the paper's choices: straight elements, Euler, time step 0.1"
        yield euler(method, "size 0.4", paper, PAPER_STEPS)
    coarse = "fem.surface_size=0.5"
    for steps in (4,) if quick else (4, 16):
        yield euler("curved, Euler", f"size 0.5, {steps} steps per phase", [coarse], steps)
    for tolerance in (1e-1, 1e-2, 1e-4):
        choice = f"size 0.5, tolerance {tolerance:.0e}"
        overrides = [coarse, f"model.tolerance={tolerance}"]
        yield stroke("curved, other tolerances", choice, overrides)
    for kind in ("oseen", "rpy", "multipole"):
        overrides = ["domain.kind=unbounded", f"model.kind={kind}"]
        yield stroke(f"{kind}, unbounded", "-", overrides, exact=UNBOUNDED_NET)


def order(points, fine, error):
    """Observed order `ln(e_1 / e_2) / ln(h_1 / h_2)` from the next coarser mesh to this one."""
    coarser = [
        p for p in points if p["method"] == fine["method"] and (p["size"] or 0) > (fine["size"] or 9)
    ]
    coarse = min(coarser, key=lambda p: p["size"], default=None)
    if coarse is None or coarse[error] is None or fine[error] is None:
        return "-"
    return f"{math.log(coarse[error] / fine[error]) / math.log(coarse['size'] / fine['size']):.1f}"


def gains(points):
    """Factors by which the correction reduces the smallest error that meshes reach in equal seconds."""
    known = [p for p in points if p["size"] and p["uncorrected"] is not None]
    for at in known:
        affordable = [p for p in known if p["seconds"] <= at["seconds"]]
        yield min(p["uncorrected"] for p in affordable) / min(p["error"] for p in affordable)


def front(points):
    """Points for which no other point is both cheaper and better, by increasing cost."""
    best = []
    for cost, error in sorted(points):
        if cost > 0 and error > 0 and (not best or error < best[-1][1]):
            best.append((cost, error))
    return best


def check():
    """Orders, gains and fronts of known points: uncorrected errors of order 4, answers of order 6."""
    known = [
        point("elements", "", size, 1, size**-3, 1e-2 * size**6, size**4, None)
        for size in (0.8, 0.5, 0.4)
    ]
    assert order(known, known[0], "error") == "-"
    assert [order(known, known[2], kind) for kind in ("error", "uncorrected")] == ["6.0", "4.0"]
    # Finer meshes take longer and are better in both respects: 100 / size^2.
    assert math.isclose(min(gains(known)), 100 / 0.64) and math.isclose(max(gains(known)), 100 / 0.16)
    assert front([(2, 0.1), (0, 1e-9), (3, 1e-3), (1, 0.01), (2, 5e-3), (2, 5e-3)]) == [
        (1, 0.01),
        (2, 5e-3),
        (3, 1e-3),
    ]


def charts(key, points, out):
    """Charts of the error over seconds and over dofs; models without a mesh have zero dofs."""
    for cost, name in (("seconds", f"accuracy-{key}"), ("dofs", f"accuracy-{key}-dofs")):
        shown = [p for p in points if p[cost] > 0 and p["error"] > 0]
        best = front((p[cost], p["error"]) for p in shown)
        series = [("Pareto front: none is cheaper and better", best, "line")]
        for method in dict.fromkeys(p["method"] for p in shown):
            of_method = [p for p in shown if p["method"] == method]
            series.append((method, [(p[cost], p["error"]) for p in of_method], "both"))
            before = [(p[cost], p["uncorrected"]) for p in of_method if p["uncorrected"]]
            if before:
                series.append((f"{method}: uncorrected", before, "line"))
        chart(out / f"{name}.svg", cost, "relative error", series, is_log=True, legend=400)


HEADINGS = ["method", "choice", "dofs", "seconds", "error", "uncorrected", "bar", "order"]
HEADINGS.append("uncorrected order")


def main():
    chosen = arguments(__doc__, only=("", "only this quantity: drag, pair, speed or net"))
    check()
    keys = [chosen.only] if chosen.only else [*START, "net"]
    parts, rows = [], []
    for key in keys:
        title, exact = START[key][:2] if key in START else ("net displacement of the stroke", NET)
        made = start_points(key, chosen.quick) if key in START else net_points(chosen.quick)
        points = list(made)
        charts(key, points, chosen.out)
        lines = []
        for p in points:
            errors = [p[k] and f"{p[k]:.1e}" or "-" for k in ("error", "uncorrected", "bar")]
            orders = [order(points, p, kind) for kind in ("error", "uncorrected")]
            line = [p["method"], p["choice"], p["dofs"], f"{p['seconds']:.3f}", *errors, *orders]
            lines.append(line)
            rows.append({"quantity": key, **p})
        parts += [
            f"## {title}, exactly {exact:.10g}",
            f"![error against dofs](accuracy-{key}-dofs.svg)",
            f"![error against seconds](accuracy-{key}.svg)",
            table(HEADINGS, lines),
        ]
        factors = list(gains(points))
        if factors:
            parts.append(
                "In equal seconds, the best mesh of a given size has an error "
                f"{min(factors):.0f} to {max(factors):.0f} times smaller than before the correction."
            )
    text = page(
        "Speed against accuracy",
        "accuracy.py",
        "Seconds are wall-clock times from the scene to the value, mesh generation included. Errors "
        "are relative to exact values. error: that of the answer; uncorrected: that of the value "
        "before the estimated discretisation error was subtracted, which takes the same seconds; "
        "bar: the error bar that the program gives; order: of both errors in the element size, from "
        "the next larger size to this one.",
        *parts,
    )
    (chosen.out / "accuracy.md").write_text(text)
    with open(chosen.out / "accuracy.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
