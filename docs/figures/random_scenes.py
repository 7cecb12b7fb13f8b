"""Scenes that a seed draws, for the study random_cases.py."""

import math

# What is drawn: radii; smallest gap, in radii of the smaller neighbour; largest gap along a chain;
# number of chains before another smallest gap is drawn; radius of the container over the distance of
# the farthest point of a sphere from its centre; gaps to which arms of strokes close.
RADII, GAPS, WIDEST_GAP, MAX_CHAINS = (0.2, 2.0), (0.02, 3.0), 6.0, 1000
CONTAINERS, STROKE_GAPS = (3.0, 10.0), (0.05, 3.0)
# Gaps of a lone body to a wall, and of two bodies with slip, in radii of the smaller one.
WALL_GAPS, SLIP_GAPS = (0.02, 3.0), (0.001, 0.02)
# Masses in units of drag times duration: from no inertia to hardly any drag.
MASSES = (1e-3, 1e3)
# Tolerances of runs by multipoles, whose error is that of the integration and the expansion.
TOLERANCES = (1e-4, 1e-2)
# Of fluids with a viscosity law: indices; relaxation times, yield stresses and regularisations in units
# of those of the motion; smallest gaps and containers, as above.
INDICES, SHEAR_NUMBERS, BINGHAM_NUMBERS = (0.3, 1.3), (0.1, 10.0), (0.03, 1.0)
REGULARISATIONS = (1e-3, 3e-2)
LAW_GAPS, LAW_CONTAINERS = (0.1, 3.0), (2.0, 8.0)


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
        self.velocities = []
        self.is_straight = random.chance(0.25)
        flat = [load for pair in self.loads for load in pair]
        self.is_axisymmetric = on_axis and all(load[1] == load[2] == 0 for load in flat)
        self.slips = self.draw_slips(Random(~seed), on_axis) if has_slip else []
        # Of expansions; drawn apart, so that the arrangements of a seed stay those of earlier studies.
        self.tolerance = Random(-seed).log_within(TOLERANCES)

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
        lines = [f'model = {{ kind = "{model}", tolerance = {tolerance}, accept = "best" }}']
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
            if self.velocities:
                lines.append(f"velocity = [{self.velocities[k]}, 0, 0]")
                lines.append("angular_velocity = [0, 0, 0]")
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


class Fluid:
    """A law with viscosity 1 at rest, or at the rate of a speed 1 over the mean radius."""

    LAWS = ("carreau", "carreau-yasuda", "cross", "power-law", "herschel-bulkley")

    def __init__(self, random, law, radii):
        self.law, self.regularisation = law, None
        time = sum(radii) / len(radii)
        index = random.within(*INDICES)
        if law in ("power-law", "herschel-bulkley"):
            self.regularisation = random.log_within(REGULARISATIONS) / time
            # Half of the power laws have the default.
            if law == "power-law" and random.chance(0.5):
                self.regularisation = 1e-6
            self.keys = f"consistency = {time ** (index - 1.0)}, index = {index}"
            if law == "herschel-bulkley":
                self.keys += f", yield_stress = {random.log_within(BINGHAM_NUMBERS) / time}"
            return
        if law == "cross":
            index = min(index, 0.9)
        plateau = random.within(0, 0.5) if random.chance(0.5) else 0.0
        time *= random.log_within(SHEAR_NUMBERS)
        self.keys = f"zero_shear_viscosity = 1, infinite_shear_viscosity = {plateau}, "
        self.keys += f"relaxation_time = {time}, index = {index}"
        if law == "carreau-yasuda":
            self.keys += f", transition = {random.within(0.7, 3.0)}"

    def text(self, regularisation):
        """The keys, with this factor on the regularisation of the law."""
        text = f'law = "{self.law}", {self.keys}'
        if self.regularisation is not None:
            text += f", regularisation = {self.regularisation * regularisation}"
        return text

    def description(self):
        keys = ", ".join(f"{key} {float(value):.3g}" for key, value in
                         (pair.split(" = ") for pair in self.keys.split(", ")))
        if self.regularisation is not None:
            keys += f", regularisation {self.regularisation:.1g}"
        return f"{self.law}: {keys}"


class Thinning(Arrangement):
    """One to three spheres on an axis in a fluid with a viscosity law: held, linked or free, half of
    them with slip."""

    DRIVES = ("held", "linked", "free")

    def __init__(self, seed):
        random = Random(seed)
        # All laws and drives are drawn equally often.
        self.law = Fluid.LAWS[seed % 5]
        self.drive = self.DRIVES[seed // 5 % 3]
        count = 2 + random.below(2) if self.drive == "linked" else 1 + random.below(3)
        self.radii = [random.log_within(RADII) for _ in range(count)]
        self.gap = random.log_within(LAW_GAPS)
        self.centres = chain(random, self.radii, self.gap, True) if count > 1 else [[0.0] * 3]
        extent = max(abs(centre[0]) + r for centre, r in zip(self.centres, self.radii))
        self.container = extent * random.within(*LAW_CONTAINERS)
        self.rates, self.loads, self.velocities, self.slips = [], [], [], []
        if self.drive == "linked":
            self.rates = [random.within(-1, 1) for _ in range(count - 1)]
        elif self.drive == "held":
            self.velocities = [random.within(-1, 1) for _ in range(count)]
        else:
            # Forces that move the spheres at speeds of order 1 at viscosity 1.
            sizes = [6.0 * math.pi * radius for radius in self.radii]
            self.loads = [[[random.within(-f, f), 0.0, 0.0], [0.0] * 3] for f in sizes]
        if random.chance(0.5):
            modes = [(random.within(-1, 1), random.within(-1, 1)) for _ in range(count)]
            self.slips = [(*mode, [1.0, 0.0, 0.0]) for mode in modes]
        self.is_straight, self.is_axisymmetric = False, True
        self.fluid = Fluid(random, self.law, self.radii)
        # Elements have no held bodies in unbounded fluid, and the meridian plane no fluid of Cross, which
        # reaches its viscosity at rest slowly, or without such a viscosity.
        is_bounded = self.drive == "held" or self.law == "cross" or self.fluid.regularisation is not None
        if not is_bounded and random.chance(0.5):
            self.container = None

    def text(self, model, tolerance, regularisation=1.0):
        """The scene, with this factor on the regularisation of the law."""
        return f"fluid = {{ {self.fluid.text(regularisation)} }}\n" + super().text(model, tolerance)

    def description(self):
        slip = "; slip" if self.slips else ""
        return f"{self.fluid.description()}; {self.drive}{slip}; {super().description()}"

    def groups(self, model):
        return ["meridian plane" if model == "axisymmetric" else "all", self.law, self.drive]


class Steady:
    """A steady state in a fluid with inertia, on the axis of a ball; half of them with a viscosity law."""

    SETUPS = ("squirmer", "pulled", "held", "fixed", "carrier")
    # Radius of the ball and gap between two spheres in radii of the first one; radius of the second;
    # density, for a viscosity and speeds of order 1; factor on the sizes of elements in space.
    BALLS, GAPS, SECOND, DENSITIES = (3.0, 12.0), (0.5, 1.5), (0.5, 1.0), (0.1, 10.0)
    SIZES, RATIOS = (0.9, 1.75), (-3.0, 3.0)

    def __init__(self, seed):
        random = Random(seed)
        self.setup = self.SETUPS[seed % 5]
        self.density = random.log_within(self.DENSITIES)
        self.size = random.within(*self.SIZES)
        self.ratio = random.within(*self.RATIOS)
        self.radii, places = [1.0], [0.0]
        self.gap = None
        if self.setup in ("fixed", "carrier"):
            self.gap = random.within(*self.GAPS)
            self.radii.append(random.within(*self.SECOND))
            places.append(sum(self.radii) + self.gap)
        if self.setup == "fixed":
            places = [x - 0.5 * places[-1] for x in places]
        self.places = places
        extent = max(abs(x) + r for x, r in zip(places, self.radii))
        self.container = extent * random.log_within(self.BALLS)
        self.fluid = None
        if random.chance(0.5):
            self.fluid = Fluid(random, Fluid.LAWS[random.below(5)], self.radii)

    def text(self, model, tolerance, regularisation=1.0):
        fluid = self.fluid.text(regularisation) if self.fluid else "viscosity = 1"
        lines = [f'model = {{ kind = "{model}", tolerance = {tolerance}, accept = "best" }}']
        lines.append(f"fluid = {{ {fluid}, density = {self.density} }}")
        lines.append(f'domain = {{ kind = "ball", radius = {self.container} }}')
        if model == "fem":
            lines.append(f"fem.size_factor = {self.size}")
        first = {
            "pulled": f"force = [{6.0 * math.pi}, 0, 0]",
            "held": "velocity = [1, 0, 0]\nangular_velocity = [0, 0, 0]",
        }.get(self.setup, f"slip = {{ b1 = 1.5, b2 = {1.5 * self.ratio} }}")
        for k, (radius, x) in enumerate(zip(self.radii, self.places)):
            lines += ["[[bodies]]", f'name = "s{k}"', f"position = [{x}, 0, 0]", f"radius = {radius}"]
            if k == 0:
                lines.append(first)
            if self.setup == "fixed":
                lines.append("fixed = true")
        if self.setup == "carrier":
            lines += ["[[links]]", 'name = "arm"', 'body = "s1"', 'to = "s0"']
        return "\n".join(lines) + "\n"

    def description(self):
        second = f"; second {self.radii[1]:.3f} at a gap of {self.gap:.3f}" if self.gap else ""
        fluid = self.fluid.description() if self.fluid else "Newtonian"
        fluid += f", density {self.density:.3f}"
        sizes = f"ball {self.container:.2f}; sizes {self.size:.2f}; ratio {self.ratio:.2f}"
        return f"{self.setup}; {fluid}; {sizes}{second}"

    def groups(self, model):
        return ["all", self.setup, "law" if self.fluid else "Newtonian"]


class Lone:
    """A sphere with a force and a torque: above a plane wall, or anywhere in a ball."""

    def __init__(self, seed):
        random = Random(seed)
        self.radii, self.rates = [random.within(*RADII)], []
        radius = self.radii[0]
        self.gap = random.log_within(WALL_GAPS)
        self.is_above_wall = random.chance(0.5)
        direction = [0.0, 0.0, 1.0] if self.is_above_wall else random.direction()
        distance = radius * (1.0 + self.gap if self.is_above_wall else random.within(0, 5))
        self.position = [distance * e for e in direction]
        self.container = distance + radius * (1.0 + self.gap)
        self.force = Arrangement.load(random, 1.0, False)
        self.torque = Arrangement.load(random, radius, False)

    def text(self, model, tolerance):
        wall, ball = 'domain.kind = "wall"', f'domain = {{ kind = "ball", radius = {self.container} }}'
        return (
            f'model = {{ kind = "{model}", tolerance = {tolerance} }}\n'
            f"{wall if self.is_above_wall else ball}\n"
            f'[[bodies]]\nname = "s"\nradius = {self.radii[0]}\nposition = {self.position}\n'
            f"force = {self.force}\ntorque = {self.torque}\n"
        )

    def description(self):
        place = "wall" if self.is_above_wall else f"ball {self.container:.3f}"
        position = " ".join(f"{x:.3f}" for x in self.position)
        return f"radius {self.radii[0]:.3f}; centre {position}; {place}"

    def groups(self, _model):
        return ["all", "wall" if self.is_above_wall else "ball"] + ["gap below 0.2"] * (self.gap < 0.2)


class SlipGap:
    """Two spheres with slip along their line of centres and a narrow gap; half of them are linked."""

    def __init__(self, seed):
        random = Random(seed)
        self.radii = [random.log_within(RADII) for _ in range(2)]
        self.gap = random.log_within(SLIP_GAPS)
        self.modes = [(random.within(-1, 1), random.within(-2, 2)) for _ in range(2)]
        self.rates = [0.0] if random.chance(0.5) else []
        self.distance = sum(self.radii) + self.gap * min(self.radii)
        self.tolerance = random.log_within(TOLERANCES)

    def text(self, model, tolerance):
        lines = [f'model = {{ kind = "{model}", tolerance = {tolerance}, accept = "best" }}']
        for k, (radius, (b1, b2)) in enumerate(zip(self.radii, self.modes)):
            lines += ["[[bodies]]", f'name = "s{k}"', f"position = [{k * self.distance}, 0, 0]"]
            lines += [f"radius = {radius}", f"slip = {{ b1 = {b1}, b2 = {b2} }}"]
        if self.rates:
            lines += ["[[links]]", 'name = "l"', 'body = "s1"', 'to = "s0"']
        return "\n".join(lines) + "\n"

    def description(self):
        modes = " / ".join(f"{b1:.3f} {b2:.3f}" for b1, b2 in self.modes)
        return f"radii {self.radii[0]:.3f} {self.radii[1]:.3f}; gap {self.gap:.2e}; b1 b2 {modes}"

    def groups(self, _model):
        return ["all", "linked" if self.rates else "free"] + ["gap below 0.005"] * (self.gap < 0.005)


class Stroke:
    """A stroke of three spheres; two thirds are collinear, unbounded, curved, one cycle."""

    SETUPS = {2: "ball", 5: "straight", 8: "two cycles", 11: "angle"}

    def __init__(self, seed, on_line=False):
        random = Random(seed)
        self.setup = "plain" if on_line else self.SETUPS.get(seed % 12, "plain")
        while True:
            self.radii = [random.within(0.6, 1.6) for _ in range(3)]
            self.arms = [random.within(5, 10) for _ in range(2)]
            self.gaps = [random.log_within(STROKE_GAPS) for _ in range(2)]
            # Up to this angle the outer spheres cannot touch each other.
            self.angle = random.within(20, 60)
            pairs = zip(self.radii, self.radii[1:], self.gaps)
            self.closed = [a + b + gap * min(a, b) for a, b, gap in pairs]
            if all(short < 0.9 * long for short, long in zip(self.closed, self.arms)):
                break
        self.tolerance = random.log_within(TOLERANCES)
        self.gap = min(self.gaps)

    def text(self):
        lines = {
            "ball": 'domain = { kind = "ball", radius = 40 }',
            "straight": 'fem.geometry = "straight"',
            "two cycles": "gait.cycles = 2",
        }
        turn = math.radians(self.angle) if self.setup == "angle" else 0.0
        end = [self.arms[1] * math.cos(turn), self.arms[1] * math.sin(turn), 0.0]
        text = lines.get(self.setup, "") + "\n"
        places = [[-self.arms[0], 0.0, 0.0], [0.0] * 3, end]
        for name, radius, place in zip(["left", "centre", "right"], self.radii, places):
            text += f'[[bodies]]\nname = "{name}"\nposition = {place}\nradius = {radius}\n'
        for name in ("left", "right"):
            text += f'[[links]]\nname = "{name}-arm"\nbody = "{name}"\nto = "centre"\n'
        for lengths in (self.closed, self.arms):
            for name, length in zip(("left", "right"), lengths):
                text += f'[[gait.phases]]\nlink = "{name}-arm"\nlength = {length}\n'
        return text

    def description(self):
        lists = [" ".join(f"{x:.3f}" for x in v) for v in (self.radii, self.arms, self.gaps)]
        of_angle = f" of {self.angle:.1f} degrees" if self.setup == "angle" else ""
        return f"{self.setup}{of_angle}; radii {lists[0]}; arms {lists[1]}; gaps {lists[2]}"

    def groups(self):
        below = [f"gap below {limit}" for limit in (0.5, 0.2) if self.gap < limit]
        return ["all", self.setup] + below


class Growth:
    """Two or three spheres of which some grow or shrink, free, linked or one of them held; in a ball the
    sum of their volumes stays."""

    # Radii; smallest gaps in radii of the smaller neighbour; rates of the radii relative to them.
    RADII, GAPS, RATE = (0.5, 2.0), (0.1, 3.0), 0.3

    def __init__(self, seed):
        random = Random(seed)
        self.gap = 0.0
        while self.gap < self.GAPS[0]:
            count = 2 + random.below(2)
            self.radii = [random.log_within(self.RADII) for _ in range(count)]
            self.centres = chain(random, self.radii, random.log_within(self.GAPS), False)
            self.gap = smallest_gap(self.radii, self.centres)
        self.setup = ["free", "linked", "held"][random.below(3)]
        self.growths = [random.within(-self.RATE, self.RATE) for _ in range(count)]
        if count == 3 and random.chance(0.5):
            self.growths[1] = 0.0
        # Rates of volumes are 4 pi radius^3 times these.
        self.volumes = [4 * math.pi * g * r**3 for g, r in zip(self.growths, self.radii)]
        self.container = None
        if random.chance(0.4):
            extent = max(math.hypot(*c) + r for c, r in zip(self.centres, self.radii))
            self.container = extent * random.within(*CONTAINERS)
            self.volumes[-1] -= sum(self.volumes)
        # Forces are not given where there are joints.
        self.rates = [0.0] * (count - 1) if self.setup == "linked" else []
        self.is_axisymmetric = False

    def text(self, model, tolerance):
        # In a short time volumes stay positive.
        text = f'model = {{ kind = "{model}", tolerance = {tolerance}, accept = "best" }}\n'
        if self.container:
            text += f'domain = {{ kind = "ball", radius = {self.container} }}\n'
        for number, (radius, centre) in enumerate(zip(self.radii, self.centres)):
            text += f'[[bodies]]\nname = "{number}"\nradius = {radius}\nposition = {centre}\n'
            if self.setup == "held" and number == 0:
                text += "fixed = true\n"
        if self.setup == "linked":
            for number in range(1, len(self.radii)):
                text += f'[[links]]\nname = "link {number}"\nbody = "{number}"\nto = "{number - 1}"\n'
        text += "[[gait.phases]]\nduration = 0.001\n[gait.phases.targets]\n"
        for number, (radius, rate) in enumerate(zip(self.radii, self.volumes)):
            if rate:
                text += f'"{number}.volume" = {4 * math.pi / 3 * radius**3 + 0.001 * rate!r}\n'
        return text

    def description(self):
        domain = "ball" if self.container else "unbounded"
        lists = [" ".join(f"{x:.3f}" for x in v) for v in (self.radii, self.growths)]
        return f"{self.setup}, {domain}; radii {lists[0]}; growth {lists[1]}; gap {self.gap:.3f}"

    def groups(self, model):
        return [f"{model}", f"{model}, {self.setup}"]


class Wave:
    """Spheres on an axis that deform in waves, or two that exchange volume; half of them in a ball."""

    # Degrees of the two modes of a body, their largest amplitudes relative to the radius, and the lengths
    # and amplitudes of an arm relative to the sum of the radii.
    DEGREES, AMPLITUDES, ARMS, STROKES = (2, 5), (0.03, 0.15), (1.8, 4.0), (0.1, 0.5)

    def __init__(self, seed):
        random = Random(seed)
        self.setup = ["one wave", "two waves", "exchange"][seed % 3]
        count = 1 if self.setup == "one wave" else 2
        self.radii = [random.log_within((0.5, 2.0)) for _ in range(count)]
        self.in_ball = random.chance(0.5)
        # In a container the volume of a body that deforms must stay.
        self.motion = ["isochoric", "tangential", "radial"][random.below(2 if self.in_ball else 3)]
        size = sum(self.radii)
        self.arm = size * random.within(*self.ARMS)
        self.stroke = size * random.within(*self.STROKES)
        self.waves = []
        for radius in self.radii:
            degree = self.DEGREES[0] + random.below(self.DEGREES[1] - self.DEGREES[0])
            amplitudes = [radius * random.log_within(self.AMPLITUDES) for _ in range(2)]
            if self.motion == "tangential":
                # Angles, not lengths.
                amplitudes = [amplitude / radius for amplitude in amplitudes]
            self.waves.append([degree, amplitudes, [random.within(0, 2 * math.pi) for _ in range(2)]])
        self.shift = random.within(0.2, 0.5)
        self.tolerance = random.log_within(TOLERANCES)
        self.gap = None

    def text(self):
        text = ""
        if self.in_ball:
            text = f'domain = {{ kind = "ball", radius = {4 * (self.arm + self.stroke + sum(self.radii))} }}\n'
        names = ["left", "right"][: len(self.radii)]
        places = [0.0, self.arm][: len(self.radii)]
        has_waves = self.setup != "exchange"
        for name, radius, x, wave in zip(names, self.radii, places, self.waves):
            text += f'[[bodies]]\nname = "{name}"\nposition = [{x}, 0, 0]\nradius = {radius}\n'
            if has_waves:
                text += f'deformation = {{ motion = "{self.motion}", axis = [1, 0, 0], '
                text += f"modes = {{ a = {wave[0]}, b = {wave[0] + 1} }} }}\n"
        if len(names) == 2:
            text += '[[links]]\nname = "arm"\nbody = "right"\nto = "left"\n'
        if not has_waves:
            volume = 4 * math.pi / 3 * self.radii[0] ** 3
            text += '[[links]]\nname = "volume"\nbody = "left"\nto = "right"\njoint = "exchange"\n'
            other = volume - self.shift * 4 * math.pi / 3 * min(self.radii) ** 3
            values = [("arm", self.arm + self.stroke), ("volume", other), ("arm", self.arm), ("volume", volume)]
            for link, value in values:
                text += f'[[gait.phases]]\nlink = "{link}"\nlength = {value}\n'
            return text
        text += "[gait]\nperiod = 1\n"
        if len(names) == 2:
            text += f'[[gait.harmonics]]\nlink = "arm"\nmean = {self.arm}\namplitude = {self.stroke}\n'
        for name, (_, amplitudes, phases) in zip(names, self.waves):
            for mode, amplitude, phase in zip("ab", amplitudes, phases):
                text += f'[[gait.harmonics]]\nlink = "{name}.{mode}"\nmean = 0\n'
                text += f"amplitude = {amplitude}\nphase = {phase}\n"
        return text

    def description(self):
        motion = "" if self.setup == "exchange" else f", {self.motion}"
        waves = " and ".join(f"{w[0]}: {w[1][0]:.3f} {w[1][1]:.3f}" for w in self.waves)
        domain = "ball" if self.in_ball else "unbounded"
        return f"{self.setup}{motion}, {domain}; radii {' '.join(f'{r:.3f}' for r in self.radii)}; {waves}"

    def groups(self):
        return ["all", self.setup] + ([] if self.setup == "exchange" else [self.motion])


class Turn(Stroke):
    """A stroke that turns: two slides at an angle, or two hinges, as Purcell's swimmer has."""

    def __init__(self, seed):
        super().__init__(seed)
        random = Random(~seed)
        self.setup = "hinges" if random.chance(0.5) else "angle"
        self.angles = [random.within(0.3, 1.0) for _ in range(2)]

    def text(self):
        if self.setup == "angle":
            return super().text()
        text = ""
        places = [[-self.arms[0], 0.0, 0.0], [0.0] * 3, [self.arms[1], 0.0, 0.0]]
        for name, radius, place in zip(["left", "centre", "right"], self.radii, places):
            text += f'[[bodies]]\nname = "{name}"\nposition = {place}\nradius = {radius}\n'
        for name in ("left", "right"):
            text += f'[[links]]\nname = "{name}-arm"\nbody = "{name}"\nto = "centre"\n'
            text += 'joint = "hinge"\naxis = [0, 0, 1]\n'
        for sign in (1.0, -1.0):
            for name, angle in zip(("left", "right"), self.angles):
                text += f'[[gait.phases]]\nlink = "{name}-arm"\nlength = {sign * angle}\n'
        for name in ("left", "right"):
            text += f'[[gait.phases]]\nlink = "{name}-arm"\nlength = 0\n'
        return text

    def description(self):
        if self.setup == "angle":
            return super().description()
        lists = [" ".join(f"{x:.3f}" for x in v) for v in (self.radii, self.arms, self.angles)]
        return f"hinges; radii {lists[0]}; arms {lists[1]}; angles {lists[2]}"

    def groups(self):
        return ["all", self.setup]


class Massive:
    """A sphere with mass and moment of inertia that a force and a torque accelerate from rest."""

    def __init__(self, seed):
        random = Random(seed)
        self.radius = random.log_within(RADII)
        self.duration = random.log_within((0.1, 10.0))
        # 6 pi a and 8 pi a^3 at viscosity 1; masses relative to drag times duration.
        self.drags = [6 * math.pi * self.radius, 8 * math.pi * self.radius**3]
        self.masses = [random.log_within(MASSES) * drag * self.duration for drag in self.drags]
        self.loads = [Arrangement.load(random, size, False) for size in (1.0, self.radius)]
        self.tolerance = random.log_within(TOLERANCES)

    def text(self):
        return (
            f"[[gait.phases]]\nduration = {self.duration}\n"
            f'[[bodies]]\nname = "s"\nradius = {self.radius}\nposition = [0, 0, 0]\n'
            f"mass = {self.masses[0]}\ninertia = {self.masses[1]}\n"
            f"force = {self.loads[0]}\ntorque = {self.loads[1]}\n"
        )

    def exact(self):
        """Path, rotation vector and work of the drag: `m v' = F - R v` from rest, and the same for
        the rotation, whose axis is that of the torque."""
        paths, work = [], 0.0
        for drag, mass, load in zip(self.drags, self.masses, self.loads):
            relaxation = mass / drag
            x = self.duration / relaxation
            # t + tau (e^-x - 1), and the integral of (1 - e^(-s / tau))^2: series where they cancel.
            if x < 1e-1:
                terms = [(-x) ** k / math.factorial(k) for k in range(2, 14)]
                path = relaxation * sum(terms)
                of_squares = [(2 - 2 ** (k - 1)) * term for k, term in enumerate(terms, 2)]
                squares = relaxation * sum(of_squares)
            else:
                path = relaxation * (x + math.expm1(-x))
                squares = relaxation * (x + 2 * math.expm1(-x) - math.expm1(-2 * x) / 2)
            paths.append([path * f / drag for f in load])
            work += squares * sum(f * f for f in load) / drag
        return {
            "displacement": {"s": paths[0]},
            "rotation": paths[1],
            "work": work,
            "uncorrected": None,
            "error_estimate": {"total": 0.0},
            "rotation_error": {"total": 0.0},
            "work_error": {"total": 0.0},
        }

    def description(self):
        ratios = [m / d / self.duration for m, d in zip(self.masses, self.drags)]
        return f"radius {self.radius:.3f}; relaxation times / duration {ratios[0]:.1e} {ratios[1]:.1e}"

    def groups(self):
        heavy = self.masses[0] > self.drags[0] * self.duration
        return ["all", "mass above drag" if heavy else "mass below drag"]


class Approach:
    """Two spheres that forces pull towards each other for twice the time in which they would meet."""

    def __init__(self, seed):
        random = Random(seed)
        self.radii = [random.log_within((0.05, 1.0)) for _ in range(2)]
        reach = sum(self.radii)
        self.is_head_on = random.chance(0.5)
        offset = 0.0 if self.is_head_on else random.within(0, 1) * reach
        distance = reach * random.log_within((1.5, 50.0)) + reach
        self.is_fixed = random.chance(0.5)
        self.forces = [random.log_within((0.1, 1.0)), -random.log_within((0.1, 1.0))]
        self.positions = [[0.0, 0.0, 0.0], [distance, offset, 0.0]]
        self.model = ["oseen", "rpy"][random.below(2)]
        drag = [6 * math.pi * a for a in self.radii]
        speeds = [abs(f) / d for f, d in zip(self.forces, drag)]
        speed = speeds[0] if self.is_fixed else sum(speeds)
        self.duration = 2 * distance / speed
        self.gap = (distance - reach) / min(self.radii)
        self.names = ("s0", "s1")

    def text(self):
        lines = [f'model = {{ kind = "{self.model}", accept = "best" }}', "[[gait.phases]]"]
        lines.append(f"duration = {self.duration}")
        for k, name in enumerate(self.names):
            lines += ["[[bodies]]", f'name = "{name}"', f"radius = {self.radii[k]}"]
            lines.append(f"position = {self.positions[k]}")
            is_fixed = k == 1 and self.is_fixed
            lines.append("fixed = true" if is_fixed else f"force = [{self.forces[k]}, 0, 0]")
        return "\n".join(lines) + "\n"

    def touches(self):
        """Whether they must touch; None where the flow may carry one around the other."""
        return True if self.is_head_on else None

    def description(self):
        radii = " ".join(f"{r:.3f}" for r in self.radii)
        end = " ".join(f"{x:.3f}" for x in self.positions[1])
        held = "fixed" if self.is_fixed else f"{self.forces[1]:.3f}"
        return f"{self.model}; radii {radii}; second at {end}; forces {self.forces[0]:.3f} {held}"

    def groups(self):
        return ["all", "pulled head-on" if self.is_head_on else "pulled past"]


class Sweep:
    """A sphere on a hinge that sweeps past, or through, a sphere on a fixed arm."""

    def __init__(self, seed):
        random = Random(seed)
        self.radii = [random.log_within((0.05, 0.5)) for _ in range(2)]
        arm = random.within(3, 8)
        self.arm, reach = arm, sum(self.radii)
        self.sweep = random.within(0.5, 2.5)
        # The post stands at an angle along or beyond the sweep, and near the circle of the sphere.
        angle = random.within(0.4, 2.8)
        radial, height = (random.within(-1, 1) * reach for _ in range(2))
        self.post = [(arm + radial) * math.cos(angle), (arm + radial) * math.sin(angle), height]
        nearest = min(max(angle, 0.0), self.sweep)
        place = [arm * math.cos(nearest), arm * math.sin(nearest), 0.0]
        self.closest = math.dist(place, self.post) - reach
        self.gap = self.closest / min(self.radii)
        self.names, self.model = ("sphere", "post"), "rpy"

    def text(self):
        # The arm at rest and at the start must not decide the outcome: the base is small.
        bodies = [("base", 0.1, [0.0] * 3), ("sphere", self.radii[0], [self.arm, 0.0, 0.0])]
        bodies.append(("post", self.radii[1], self.post))
        text = 'model.kind = "rpy"\nmodel.accept = "best"\n'
        for name, radius, place in bodies:
            text += f'[[bodies]]\nname = "{name}"\nradius = {radius}\nposition = {place}\n'
        text += '[[links]]\nname = "hinge"\nbody = "sphere"\nto = "base"\njoint = "hinge"\n'
        text += 'axis = [0, 0, 1]\n[[links]]\nname = "arm"\nbody = "post"\nto = "base"\n'
        text += f'joint = "fixed"\n[[gait.phases]]\nlink = "hinge"\nlength = {self.sweep}\n'
        return text

    def touches(self):
        return self.closest < 0

    def description(self):
        radii = " ".join(f"{r:.3f}" for r in self.radii)
        post = " ".join(f"{x:.3f}" for x in self.post)
        return f"radii {radii}; arm {self.arm:.3f}; sweep {self.sweep:.3f}; post {post}"

    def groups(self):
        return ["all", "swept through" if self.touches() else "swept past"]
