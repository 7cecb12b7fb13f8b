"""Errors, corrected errors and error bars of random instantaneous solutions and random strokes.

Writes random.md and random.csv. Each case is added to random.jsonl as soon as it is known, from which
--resume 1 continues. --seed S --instants 1 --squirmers 0 --strokes 0 (or another 1) draws the case of
seed S again.
"""

import csv
import json
import math
import statistics
import sys

from figures import ROOT, Refused, arguments, page, swim, table

# Tolerance of the multipoles that are compared with: in space a thousandth of the usual errors of
# corrected values, on an axis one for which more digits are cheap, and that of strokes.
EXACT, EXACT_ON_AXIS, EXACT_STROKE = 1e-7, 1e-12, 1e-8
# Tolerance of elements in the meridian plane.
MERIDIAN_TOLERANCE = 1e-4

# What is drawn: radii; smallest gap, in radii of the smaller neighbour; largest gap along a chain;
# number of chains before another smallest gap is drawn; radius of the container over the distance of
# the farthest point of a sphere from its centre; gaps to which arms of strokes close.
RADII, GAPS, WIDEST_GAP, MAX_CHAINS = (0.2, 2.0), (0.02, 3.0), 6.0, 1000
CONTAINERS, STROKE_GAPS = (3.0, 10.0), (0.05, 3.0)

# Size below which a quantity is zero but for rounding, relative to what it is compared with.
NEGLIGIBLE = 1e-9
# A comparison is dropped if the bar of the exact value is above this part of the smaller error.
MAX_EXACT_BAR = 0.05

KINDS = {
    "instant": ("Instants: the velocities", ["velocity"]),
    "squirmer": ("Squirmers", ["velocity", "power", "stresslet"]),
    "stroke": ("Strokes", ["displacement", "rotation", "work"]),
}
QUANTITIES = ["velocity", "angular velocity", "force", "torque", "link force", "power", "stresslet"]
QUANTITIES += ["displacement", "rotation", "work"]


class Random:
    """SplitMix64 (Steele, Lea & Flood 2014): a seed draws the same case in every version."""

    def __init__(self, seed):
        self.state = seed % 2**64

    def bits(self):
        mask = 2**64 - 1
        self.state = (self.state + 0x9E3779B97F4A7C15) & mask
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
        return z ^ (z >> 31)

    def within(self, low, high):
        return low + (high - low) * float(self.bits() >> 11) / float(2**53)

    def log_within(self, limits):
        return math.exp(self.within(*map(math.log, limits)))

    def chance(self, probability):
        return self.within(0, 1) < probability

    def below(self, count):
        return self.bits() % count

    def direction(self):
        while True:
            v = [self.within(-1, 1) for _ in range(3)]
            norm = math.sqrt(sum(x * x for x in v))
            if 0.1 <= norm < 1:
                return [x / norm for x in v]


def chain(random, radii, gap, on_axis):
    """Spheres in a row about their mean: one pair has the given gap, the others wider ones."""
    narrowest = random.below(len(radii) - 1)
    centres = [[0.0] * 3]
    for number, (a, b) in enumerate(zip(radii, radii[1:])):
        own = gap if number == narrowest else random.log_within((gap, WIDEST_GAP))
        direction = [1.0, 0.0, 0.0] if on_axis else random.direction()
        distance = a + b + own * min(a, b)
        centres.append([x + distance * e for x, e in zip(centres[-1], direction)])
    mean = [sum(x) / len(radii) for x in zip(*centres)]
    return [[x - m for x, m in zip(centre, mean)] for centre in centres]


def smallest_gap(radii, centres):
    """Smallest gap of two spheres, in radii of the smaller one; negative if they overlap."""
    return min(
        (math.dist(centres[a], centres[b]) - radii[a] - radii[b]) / min(radii[a], radii[b])
        for b in range(len(radii))
        for a in range(b)
    )


class Arrangement:
    """Spheres of a seed: half on a line, half chains, half in a ball, a quarter with straight facets."""

    def __init__(self, seed, has_slip):
        random = Random(seed)
        count = 2 + random.below(4)
        self.radii = [random.log_within(RADII) for _ in range(count)]
        on_axis = random.chance(0.5)
        self.centres = None
        while self.centres is None:
            self.gap = random.log_within(GAPS)
            # In space, spheres of a chain may come closer to each other than neighbours do, and
            # between some radii no chain has a wide gap everywhere.
            for _ in range(MAX_CHAINS):
                centres = chain(random, self.radii, self.gap, on_axis)
                if abs(smallest_gap(self.radii, centres) - self.gap) <= 1e-9 * self.gap:
                    self.centres = centres
                    break
        extent = max(math.hypot(*centre) + r for centre, r in zip(self.centres, self.radii))
        self.container = extent * random.within(*CONTAINERS) if random.chance(0.5) else None
        self.rates, self.loads = [], []
        if random.chance(0.5):
            self.rates = [random.within(-1, 1) for _ in range(count - 1)]
        else:
            # Half of the free spheres on a line have loads along it, so that the flow has rotational
            # symmetry; the others have loads in any direction.
            along_axis = on_axis and random.chance(0.5)
            for radius in self.radii:
                # A torque of the size of the force times the radius.
                self.loads.append([self.load(random, size, along_axis) for size in (1.0, radius)])
        self.is_straight = random.chance(0.25)
        flat = [load for pair in self.loads for load in pair]
        self.is_axisymmetric = on_axis and all(load[1] == load[2] == 0 for load in flat)
        self.slips = self.draw_slips(Random(~seed), on_axis) if has_slip else []

    @staticmethod
    def load(random, size, along_axis):
        if along_axis:
            return [random.within(-size, size), 0.0, 0.0]
        direction = random.direction()
        length = random.within(0, size)
        return [length * e for e in direction]

    def draw_slips(self, random, on_axis):
        """Modes b1 and b2, and the axis, of each sphere: along the axis of an axisymmetric flow; half
        of the others on a line have axes in one symmetry plane."""
        in_plane = on_axis and random.chance(0.5)
        slips = []
        for _ in self.radii:
            modes = [random.within(-1, 1), random.within(-2, 2)]
            axis = random.direction()
            if self.is_axisymmetric:
                axis = [1.0, 0.0, 0.0]
            elif in_plane:
                axis[2] = 0.0
            slips.append((*modes, axis))
        return slips

    def text(self, model, tolerance):
        lines = [f'model = {{ kind = "{model}", tolerance = {tolerance} }}']
        if self.container is not None:
            lines.append(f'domain = {{ kind = "ball", radius = {self.container} }}')
        if self.is_straight:
            lines.append('fem.geometry = "straight"')
        for k, (radius, centre) in enumerate(zip(self.radii, self.centres)):
            lines += ["[[bodies]]", f'name = "s{k}"', f"position = {centre}", f"radius = {radius}"]
            if self.loads:
                lines += [f"force = {self.loads[k][0]}", f"torque = {self.loads[k][1]}"]
            if self.slips:
                b1, b2, axis = self.slips[k]
                lines.append(f"slip = {{ b1 = {b1}, b2 = {b2}, axis = {axis} }}")
        targets = []
        for k, rate in enumerate(self.rates):
            lines += ["[[links]]", f'name = "l{k}"', f'body = "s{k + 1}"', f'to = "s{k}"']
            # Only the rates matter, but the spheres must not touch during the phase.
            length = math.dist(self.centres[k], self.centres[k + 1])
            targets.append(f"l{k} = {length + rate * self.duration()}")
        if targets:
            lines += ["[[gait.phases]]", f"targets = {{ {', '.join(targets)} }}"]
            lines.append(f"duration = {self.duration()}")
        return "\n".join(lines) + "\n"

    def duration(self):
        """A hundredth of the time in which the smallest gap closes at the largest rate."""
        return 0.01 * self.gap * min(self.radii)

    def description(self):
        radii = " ".join(f"{r:.3f}" for r in self.radii)
        centres = " / ".join(" ".join(f"{x:.3f}" for x in centre) for centre in self.centres)
        container = "unbounded" if self.container is None else f"ball {self.container:.2f}"
        facets = "straight" if self.is_straight else "curved"
        return f"radii {radii}; centres {centres}; {container}; {facets}"

    def groups(self, model):
        if model == "axisymmetric":
            return ["meridian plane"]
        groups = ["all", "linked" if self.rates else "free"]
        groups.append("unbounded" if self.container is None else "ball")
        groups.append("straight" if self.is_straight else "curved")
        groups.append("axisymmetric" if self.is_axisymmetric else "three-dimensional")
        return groups + ["gap below 0.2"] * (self.gap < 0.2)


def norm(vector):
    return math.hypot(*vector)


def largest(vectors):
    return max(map(norm, vectors))


def quantities_of_instant(drawn, found):
    """Name, vectors before and after the correction, bars, and the size below which it is rounding.

    Forces, torques and joint forces are given loads where there are no joints, and left out. Power is
    a vector of one component, a stresslet one of nine.
    """
    bars, before = found["error_estimate"], found["uncorrected"] or found
    speed = max(norm(b["velocity"]) for b in found["bodies"])
    force = max(norm(b["force"]) for b in found["bodies"])
    radius = max(drawn.radii)

    def of_bodies(key, bars, negligible=0.0):
        both = [[body[key] for body in solution["bodies"]] for solution in (before, found)]
        return key.replace("_", " "), *both, bars, negligible

    yield of_bodies("velocity", bars)
    yield of_bodies("angular_velocity", bars["angular_velocity"], NEGLIGIBLE * speed / radius)
    yield "power", [[before["power"]]], [[found["power"]]], bars["power"], 0.0
    if found["bodies"][0]["stresslet"] is not None:
        flat = [
            [[x for row in body["stresslet"] for x in row] for body in solution["bodies"]]
            for solution in (before, found)
        ]
        bar = bars.get("stresslet")
        yield "stresslet", *flat, bar if bar is None else {"total": bar, "mesh": bar}, 0.0
    if drawn.rates:
        yield of_bodies("force", bars["force"])
        yield of_bodies("torque", bars["torque"], NEGLIGIBLE * force * radius)
        links = [[link["force"] for link in solution["links"]] for solution in (before, found)]
        yield "link force", *links, bars["force"], 0.0


def quantities_of_stroke(found):
    """The same of a run; the rotation is known with its correction only."""

    def mean(displacement):
        return [[sum(x) / len(displacement) for x in zip(*displacement.values())]]

    before = found["uncorrected"] or found
    both = [mean(run["displacement"]) for run in (before, found)]
    yield "displacement", *both, found["error_estimate"], 0.0
    # A stroke turns by a few degrees unless its symmetry forbids it.
    yield "rotation", [found["rotation"]], [found["rotation"]], found["rotation_error"], NEGLIGIBLE
    yield "work", [[before["work"]]], [[found["work"]]], found["work_error"], 0.0


def compare(found, exact, exact_bar):
    """Errors relative to the largest exact vector; None for a quantity that is zero by symmetry."""
    name, before, after, bars, _ = found
    _, values, _, _, negligible = exact
    scale = largest(values)
    if scale <= negligible:
        return None
    before, after = (
        [[(x - y) / scale for x, y in zip(*pair)] for pair in zip(vectors, values)]
        for vectors in (before, after)
    )
    estimates = [[b - a for b, a in zip(*pair)] for pair in zip(before, after)]
    square = sum(x * x for vector in before for x in vector)
    product = sum(x * y for pair in zip(estimates, before) for x, y in zip(*pair))
    return {
        "name": name,
        "scale": scale,
        "uncorrected": largest(before),
        "corrected": largest(after),
        "bar": bars and bars["total"] / scale,
        "bar_without_mesh": (bars["total"] - bars.get("mesh", 0)) / scale if bars else 0.0,
        "estimate": largest(estimates),
        "effectivity": product / square if square > 0 else None,
        "exact_bar": exact_bar,
    }


def exact_bars(exact):
    """Relative error bar of each quantity of the solution that is compared with."""
    bars, bodies = exact["error_estimate"], exact["bodies"]
    by_name = {"power": bars["power"]["total"] / abs(exact["power"]) if exact["power"] else 0.0}
    for key in ("velocity", "angular_velocity", "force", "torque"):
        bar = bars["total"] if key == "velocity" else bars[key]["total"]
        size = max(norm(body[key]) for body in bodies)
        by_name[key.replace("_", " ")] = bar / (size or 1e-300)
    by_name["link force"] = by_name["force"]
    if bodies[0]["stresslet"] is not None:
        stresslet = max(norm([x for row in body["stresslet"] for x in row]) for body in bodies)
        by_name["stresslet"] = bars.get("stresslet", math.inf) / (stresslet or 1e-300)
    return by_name


def compared(case, command, text, exact, bars, quantities, *options):
    """The case with its comparisons, or with the reason of a refusal."""
    try:
        found = swim(command, text, *options)
    except Refused as error:
        return {**case, "refused": str(error)}
    pairs = zip(quantities(found), quantities(exact))
    all_compared = (compare(own, other, bars[own[0]]) for own, other in pairs)
    case["comparisons"] = [c for c in all_compared if c is not None]
    if not found.get("tolerance_met", True):
        case["groups"].append("tolerance missed")
    case["dofs"] = found.get("dofs", {}).get("total", 0)
    case["seconds"] = found["seconds"]["total"]
    return case


def instants(seed, has_slip):
    """Cases of one arrangement: elements in space, and in the meridian plane where there is one."""
    drawn = Arrangement(seed, has_slip)
    tolerance = EXACT_ON_AXIS if drawn.is_axisymmetric else EXACT
    exact = swim("solve", drawn.text("multipole", tolerance))
    # The tolerance of elements in space is that of the integration.
    models = [("fem", 1e-3)] + [("axisymmetric", MERIDIAN_TOLERANCE)] * drawn.is_axisymmetric
    for model, tolerance in models:
        case = {"kind": "squirmer" if has_slip else "instant", "seed": seed, "model": model}
        case |= {"groups": drawn.groups(model), "gap": drawn.gap, "drawn": drawn.description()}
        text = drawn.text(model, tolerance)
        yield compared(
            case,
            "solve",
            text,
            exact,
            exact_bars(exact),
            lambda found: quantities_of_instant(drawn, found),
        )


def stroke(seed):
    """The stroke of a seed; two thirds are collinear, unbounded, curved, one cycle."""
    random = Random(seed)
    setup = {2: "ball", 5: "straight", 8: "two cycles", 11: "angle"}.get(seed % 12, "plain")
    while True:
        radii = [random.within(0.6, 1.6) for _ in range(3)]
        arms = [random.within(5, 10) for _ in range(2)]
        gaps = [random.log_within(STROKE_GAPS) for _ in range(2)]
        # Up to this angle the outer spheres cannot touch each other.
        angle = random.within(20, 60)
        pairs = list(zip(radii, radii[1:]))
        closed = [a + b + gap * min(a, b) for (a, b), gap in zip(pairs, gaps)]
        if all(short < 0.9 * long for short, long in zip(closed, arms)):
            break
    lines = {
        "ball": 'domain = { kind = "ball", radius = 40 }',
        "straight": 'fem.geometry = "straight"',
        "two cycles": "gait.cycles = 2",
    }
    turn = math.radians(angle) if setup == "angle" else 0.0
    end = [arms[1] * math.cos(turn), arms[1] * math.sin(turn), 0.0]
    text = lines.get(setup, "") + "\n"
    places = zip(["left", "centre", "right"], radii, [[-arms[0], 0.0, 0.0], [0.0] * 3, end])
    for name, radius, place in places:
        text += f'[[bodies]]\nname = "{name}"\nposition = {place}\nradius = {radius}\n'
    for name in ("left", "right"):
        text += f'[[links]]\nname = "{name}-arm"\nbody = "{name}"\nto = "centre"\n'
    for lengths in (closed, arms):
        for name, length in zip(("left", "right"), lengths):
            text += f'[[gait.phases]]\nlink = "{name}-arm"\nlength = {length}\n'
    out = ["--out", ROOT / "out" / "random"]
    exact_model = f'model = {{ kind = "multipole", tolerance = {EXACT_STROKE}, accept = "best" }}\n'
    exact = swim("run", exact_model + text, *out)
    displacement = list(exact["displacement"].values())
    net = norm([sum(x) / len(displacement) for x in zip(*displacement)])
    bar = exact["error_estimate"]["total"] / net
    bars = {"displacement": bar}
    bars["rotation"] = exact["rotation_error"]["total"] / (norm(exact["rotation"]) or 1e-300)
    bars["work"] = exact["work_error"]["total"] / abs(exact["work"])
    gap = min(gaps)
    groups = ["all", setup] + [f"gap below {limit}" for limit in (0.5, 0.2) if gap < limit]
    lists = [" ".join(f"{x:.3f}" for x in values) for values in (radii, arms, gaps)]
    of_angle = f" of {angle:.1f} degrees" if setup == "angle" else ""
    drawn = f"{setup}{of_angle}; radii {lists[0]}; arms {lists[1]}; gaps {lists[2]}"
    case = {"kind": "stroke", "seed": seed, "model": "fem", "groups": groups, "gap": gap}
    model = 'model = { kind = "fem", accept = "best" }\n'
    case["drawn"] = drawn
    yield compared(case, "run", model + text, exact, bars, quantities_of_stroke, *out)


def is_dropped(c):
    """Whether the exact value is not exact enough to measure an error."""
    return c["exact_bar"] > MAX_EXACT_BAR * min(c["uncorrected"], c["corrected"])


def kept(cases):
    return [c for case in cases for c in case.get("comparisons", []) if not is_dropped(c)]


def statistics_of(found):
    """The cells of the summary after the names."""

    def middle(values):
        return statistics.median_high(values)

    ratios = [[c[k] / c["bar"] for c in found if c["bar"]] for k in ("uncorrected", "corrected")]
    cells = [len(found)]
    cells += [f"{100 * sum(x <= 1 for x in r) / len(r):.0f} %" if r else "-" for r in ratios]
    cells += [f"{max(r):.2f}" if r else "-" for r in ratios]
    cells += [f"{1 / middle(r):.2f}" if r and middle(r) else "-" for r in ratios]
    cells += [f"{middle([c[k] for c in found]):.1e}" for k in ("uncorrected", "corrected")]
    cells.append(f"{middle([c['uncorrected'] / c['corrected'] for c in found if c['corrected']]):.2f}")
    known = [c["effectivity"] for c in found if c["effectivity"] is not None] or [math.nan]
    cells.append(", ".join(f"{x:.2f}" for x in (min(known), middle(known), max(known))))
    return cells


def summary(cases):
    """One row per group and quantity."""
    rows = []
    for kind in KINDS:
        of_kind = [case for case in cases if case["kind"] == kind]
        for group in dict.fromkeys(group for case in of_kind for group in case["groups"]):
            of_group = kept(case for case in of_kind if group in case["groups"])
            for quantity in QUANTITIES:
                found = [c for c in of_group if c["name"] == quantity]
                if found:
                    rows.append([f"{kind}s, {group}", quantity, *statistics_of(found)])
    return table(
        ["group", "quantity", "cases", "uncorrected in bar", "corrected in bar"]
        + ["largest uncorrected / bar", "largest corrected / bar"]
        + ["median bar / uncorrected", "median bar / corrected", "median uncorrected"]
        + ["median corrected", "median uncorrected / corrected"]
        + ["estimate / error (least, median, largest)"],
        rows,
    )


def errors_in_bars(cases, quantities):
    """One row per case and quantity."""
    rows = []
    for case in cases:
        for c in (c for c in kept([case]) if c["name"] in quantities):
            errors = [c["uncorrected"], c["corrected"]]
            row = [case["seed"], case["model"], case["drawn"], c["name"], f"{c['scale']:.10f}"]
            row += [f"{x:.1e}" for x in errors] + [f"{c['bar']:.1e}" if c["bar"] else "-"]
            row += [f"{x / c['bar']:.2f}" if c["bar"] else "-" for x in errors]
            rows.append(row + [f"{case['seconds']:.1f}"])
    head = ["seed", "model", "drawn", "quantity", "exact", "uncorrected", "corrected", "bar"]
    return table(head + ["uncorrected / bar", "corrected / bar", "seconds"], rows)


def write(cases, chosen):
    dropped = sum(is_dropped(c) for case in cases for c in case.get("comparisons", []))
    refused = [
        f"- {case['kind']} of seed {case['seed']} ({case['model']}, {case['drawn']}): {case['refused']}"
        for case in cases
        if "refused" in case
    ]
    parts = ["## Summary", summary(cases), "## Refused", "\n".join(refused) or "None."]
    for kind, (title, quantities) in KINDS.items():
        of_kind = [case for case in cases if case["kind"] == kind]
        if of_kind:
            parts += [f"## {title}", errors_in_bars(of_kind, quantities)]
    options = f"--instants {chosen.instants} --squirmers {chosen.squirmers} --strokes {chosen.strokes}"
    text = page(
        "Random cases",
        f"random_cases.py {options} --seed {chosen.seed}",
        "Errors are relative to the largest exact value of the quantity among the bodies. "
        "uncorrected: the value of the discrete problem; corrected: this value minus its estimated "
        "error. estimate / error: the signed estimate over the true error, projected on it. Exact "
        f"values: multipoles at a tolerance of {EXACT} (instants in three dimensions), "
        f"{EXACT_ON_AXIS} (on an axis) and {EXACT_STROKE} (strokes); {dropped} comparisons were "
        "dropped because their exact values have bars above 5 % of an error. Elements have their "
        f"default sizes; in the meridian plane the tolerance is {MERIDIAN_TOLERANCE}.",
        "Instants: 2 to 5 spheres, radii 0.2 to 2, smallest gap 0.02 to 3 radii of the smaller "
        "neighbour, half of them on a line, half in a ball, half linked, a quarter with straight "
        "facets. Squirmers: the same with slip, b1 up to 1 and b2 up to 2. Strokes: three spheres, "
        "radii 0.6 to 1.6, arms 5 to 10, closing to gaps of 0.05 to 3 radii of the smaller neighbour.",
        *parts,
    )
    (chosen.out / "random.md").write_text(text)
    names = ["kind", "seed", "model", "groups", "gap", "dofs", "seconds", "drawn", "refused"]
    with open(chosen.out / "random.csv", "w", newline="") as file:
        writer = csv.writer(file)
        columns = ["name", "scale", "uncorrected", "corrected", "bar", "bar_without_mesh"]
        columns += ["estimate", "effectivity", "exact_bar"]
        writer.writerow(names + columns + ["dropped"])
        for case in cases:
            case = {**case, "groups": "; ".join(case["groups"])}
            head = [case.get(name, "") for name in names]
            for c in case.get("comparisons", [{}]):
                values = [c.get(column, "") for column in columns]
                writer.writerow(head + values + [is_dropped(c) if c else ""])


def check():
    """Gaps are those that were drawn, and the numbers those of the published generator."""
    assert Random(1234567).bits() == 6457827717110365317
    # No chain of the radii of seed 287 has the gap that was drawn first.
    for seed in (*range(20), 287):
        drawn = Arrangement(seed, True)
        assert GAPS[0] <= drawn.gap <= GAPS[1] and len(drawn.slips) == len(drawn.radii)
        assert abs(smallest_gap(drawn.radii, drawn.centres) - drawn.gap) < 1e-8 * drawn.gap


def main():
    chosen = arguments(
        __doc__,
        instants=(100, "number of instantaneous solutions"),
        squirmers=(20, "number of instantaneous solutions of bodies with slip"),
        strokes=(30, "number of strokes"),
        seed=(1, "seed of the first case; each following one has the next seed"),
        resume=(0, "1: continue with the cases of random.jsonl"),
    )
    check()
    if chosen.quick:
        chosen.instants, chosen.squirmers, chosen.strokes = 2, 1, 1
    path = chosen.out / "random.jsonl"
    lines = path.read_text().splitlines() if chosen.resume else []
    # The last line may be incomplete.
    cases = [json.loads(line) for line in lines if line.endswith("}")]
    done = {(case["kind"], case["seed"]) for case in cases}
    with open(path, "w") as file:
        file.writelines(json.dumps(case) + "\n" for case in cases)
        for kind in KINDS:
            for seed in range(chosen.seed, chosen.seed + getattr(chosen, f"{kind}s")):
                if (kind, seed) in done:
                    continue
                more = stroke(seed) if kind == "stroke" else instants(seed, kind == "squirmer")
                for case in more:
                    cases.append(case)
                    file.write(json.dumps(case) + "\n")
                    file.flush()
                    errors = [f"{c['name']} {c['corrected']:.1e}" for c in case.get("comparisons", [])]
                    end = case.get("refused") or ", ".join(errors)
                    print(f"{kind} of seed {seed}, {case['model']}: {end}", file=sys.stderr)
    write(cases, chosen)


if __name__ == "__main__":
    main()
