"""Iterations of the block solver for varied sizes, containers, gaps, bodies and radii.

Writes iterations.md, with the speed-up by two threads. `cargo bench -p microswim-linalg` measures
passes over the matrices for several columns at once.
"""

import math
import sys

from figures import arguments, page, swim, table

# Number of rounds; the fastest one counts.
ROUNDS = 3


def chain(domain, radii, gap, size):
    """Three spheres on a line in a container, the left arm closing at unit speed."""
    left, right = gap + radii[0] + radii[1], gap + radii[1] + radii[2]
    text = f'domain = {domain}\nmodel.kind = "fem"\nfem.size_factor = {size}\n'
    for k, (radius, x) in enumerate(zip(radii, (-left, 0.0, right))):
        text += f'[[bodies]]\nname = "s{k}"\nradius = {radius}\nposition = [{x}, 0, 0]\n'
    for name, body in (("left", "s0"), ("right", "s2")):
        text += f'[[links]]\nname = "{name}"\nbody = "{body}"\nto = "s1"\n'
    length = left - 0.05 * min(gap, *radii)
    return text + f'[[gait.phases]]\nlink = "left"\nlength = {length}\nduration = 1\n'


def ball(radius):
    return f'{{ kind = "ball", radius = {radius} }}'


def lattice(bodies):
    """Unit spheres on a cubic lattice of spacing four in a ball, each pulled in another direction."""
    side = math.ceil(round(bodies ** (1 / 3), 9))
    middle = 0.5 * (side - 1)
    text = f'domain = {ball(4 * middle * math.sqrt(3) + 12)}\nmodel.kind = "fem"\n'
    text += "fem.size_factor = 1.5\n"
    for k in range(bodies):
        place = [4 * (i - middle) for i in (k % side, k // side % side, k // side**2)]
        force = [math.sin(k), math.cos(k), 1.0]
        text += f'[[bodies]]\nname = "s{k}"\nradius = 1\nposition = {place}\nforce = {force}\n'
    return text


def cases(quick):
    """What is varied, the choice, and the scene."""

    def some(of_quick, all_values):
        return of_quick if quick else all_values

    unit = [1, 1, 1]
    for size in some([1.75, 1.0], [1.75, 1.0, 0.5, 0.36, 0.27]):
        yield "element size", f"{0.4 * size:.2f} radii", chain(ball(40), unit, 8, size)
    for radius in some([20, 100], [20, 40, 100, 200, 500]):
        yield "container", f"{radius} radii", chain(ball(radius), unit, 8, 1)
    boxes = [(60, 60, 60), (80, 60, 60), (100, 40, 40), (60, 12, 12), (100, 10, 10)]
    for box in some(boxes[-1:], boxes):
        domain = f'{{ kind = "box", size = {list(box)} }}'
        yield "box", " x ".join(map(str, box)) + " radii", chain(domain, unit, 1, 1)
    for radius in some([5], [2.5, 5, 20]):
        domain = f'{{ kind = "cylinder", radius = {radius} }}'
        yield "cylinder", f"{radius} radii", chain(domain, unit, 1, 1)
    for gap in some([1, 0.1], [8, 4, 1, 0.3, 0.1]):
        yield "gap", f"{gap} radii", chain(ball(40), unit, gap, 1)
    for bodies in some([1, 8], [1, 2, 3, 8, 27]):
        yield "bodies", bodies, lattice(bodies)
    for ratio in some([5], [1, 2, 5, 10, 20]):
        domain = ball(10 * max(ratio, 4))
        yield "radius ratio", f"1:{ratio}", chain(domain, [1, ratio, 1], 4, 1)


def solve(scene, rtol, threads=None):
    overrides = [f"fem.rtol={rtol}", "fem.symmetry=off", "fem.estimates=off"]
    return swim("solve", scene, overrides=overrides, threads=threads)


def row(family, choice, scene):
    """The cells of a case, solved to the default tolerance and down to rounding errors."""
    usual, exact = (solve(scene, rtol) for rtol in (1e-8, 1e-12))
    pairs = zip(usual["bodies"], exact["bodies"])
    miss = max(math.dist(a["velocity"], b["velocity"]) for a, b in pairs)
    speed = max(math.hypot(*body["velocity"]) for body in exact["bodies"])
    solver = usual["solver"]
    print(f"{family} {choice}: {solver['iterations']} iterations", file=sys.stderr)
    numbers = [usual["dofs"]["total"], solver["iterations"]]
    errors = [f"{solver['true_relative_residual']:.1e}", f"{miss / speed:.1e}"]
    return [family, choice, *numbers, *errors]


def scaling(size):
    """Seconds with one and with two threads, in alternating rounds."""
    scene = chain(ball(40), [1, 1, 1], 8, size)
    phases = ["assembly", "setup", "solve"]
    best = [dict.fromkeys(phases, math.inf) for _ in range(2)]
    for _ in range(ROUNDS):
        for own, threads in zip(best, (1, 2)):
            found = solve(scene, 1e-8, threads)
            own.update({phase: min(own[phase], found["seconds"][phase]) for phase in phases})
    totals = [sum(own.values()) for own in best]
    cells = [", ".join(f"{own[phase]:.3f}" for own in best) for phase in phases]
    cells.append(", ".join(f"{total:.3f}" for total in totals))
    return [found["dofs"]["total"], *cells, f"{totals[0] / totals[1]:.2f}"]


def main():
    chosen = arguments(__doc__)
    rows = [row(*case) for case in cases(chosen.quick)]
    sizes = [1.0] if chosen.quick else [0.5, 0.36, 0.27]
    text = page(
        "Iterations of the block solver",
        "iterations.py",
        "Three spheres on a line in a ball, gaps of 8 and a ball of 40 radii unless another value is "
        "given, one arm closing; for numbers of bodies, spheres on a lattice of spacing four, each pulled "
        "in another direction. Solved to `fem.rtol` = 1e-8; velocities are compared with a solve to 1e-12 "
        "on the same mesh. In boxes and cylinders the gaps are 1.",
        table(["varied", "choice", "dofs", "iterations", "true residual", "solver error of U"], rows),
        "## A second thread",
        "Seconds with one and with two threads, the fastest of three alternating rounds for each phase.",
        table(["dofs", "assembly", "set-up", "solve", "all", "ratio"], map(scaling, sizes)),
    )
    (chosen.out / "iterations.md").write_text(text)


if __name__ == "__main__":
    main()
