//! Scenes that together have every key with numbers.

pub const SCENES: [&str; 10] = [
    r#"
fluid.viscosity = 1
model.tolerance = 1e-3
fem.rtol = 1e-8
fem.surface_size = 0.4
fem.size_factor = 1
fem.target = 1e-2
fem.subdomains = 8
fem.overlap = 1
[domain]
kind = "ball"
radius = 40
[[bodies]]
name = "left"
radius = 1
position = [-10, 0, 0]
force = [1, 0, 0]
torque = [1, 0, 0]
mass = 1
inertia = 1
[[bodies]]
name = "right"
radius = 1
position = [0, 0, 0]
[[links]]
name = "arm"
body = "left"
to = "right"
[gait]
cycles = 2
[[gait.phases]]
link = "arm"
length = 6
duration = 1
[optimise]
displacement = 0.1
rotation = 0.1
direction = [1, 0, 0]
axis = [0, 0, 1]
lower = 5
upper = { arm = 9 }
gap = 0.1
period = 1
power = 1
terms = 8
tolerance = 1e-3
[learn]
contracted = 6
extended = { arm = 10 }
direction = [1, 0, 0]
episodes = 10
steps = 10
discount = 0.9
rate = 0.5
exploration = 0.1
seed = 1
"#,
    r#"
[domain]
kind = "box"
size = [30, 20, 20]
[[bodies]]
name = "spheroid"
shape = "spheroid"
radius = 1
half_length = 2
axis = [0, 0, 1]
position = [1, 0, 0]
force = [1, 0, 0]
"#,
    r#"
[[bodies]]
name = "ellipsoid"
shape = "ellipsoid"
semi_axes = [3, 2, 1]
orientation = [0.1, 0.2, 0.3]
position = [1, 0, 0]
[[bodies]]
name = "helix"
shape = "helix"
radius = 1
tube_radius = 0.2
pitch = 2
turns = 3
position = [9, 0, 0]
"#,
    r#"
[domain]
kind = "cylinder"
radius = 5
[[bodies]]
name = "ball"
radius = 1
position = [1, 0, 0]
"#,
    r#"
[[bodies]]
name = "left"
radius = 1
position = [-10, 0, 0]
[[bodies]]
name = "right"
radius = 1
position = [0, 0, 0]
[[links]]
name = "arm"
body = "left"
to = "right"
[[gait.phases]]
targets = { arm = 6 }
[optimise]
objective = "speed"
max_rate = 0.5
max_power = 10
radii = [0.5, 2]
arms = [4, 20]
"#,
    r#"
[[bodies]]
name = "left"
radius = 1
position = [-10, 0, 0]
[[bodies]]
name = "right"
radius = 1
position = [0, 0, 0]
[[links]]
name = "arm"
body = "left"
to = "right"
[gait]
period = 8
[[gait.harmonics]]
link = "arm"
mean = 9
amplitude = 2
phase = 0.5
order = 2
"#,
    r#"
[[bodies]]
name = "left"
radius = 1
position = [-10, 0, 0]
[[bodies]]
name = "right"
radius = 1
position = [0, 0, 0]
[[bodies]]
name = "tail"
radius = 1
position = [10, 0, 0]
[[links]]
name = "screw"
body = "left"
to = "right"
joint = "screw"
axis = [0, 0, 1]
pivot = [1, 0, 0]
pitch = 2
drive = "spring"
stiffness = 1
rest = 1
damping = 1
[[links]]
name = "spring"
body = "tail"
to = "right"
drive = "force"
force = 1
"#,
    r#"
gravity = [0, 0, -1]
[fluid]
density = 1
[background]
kind = "uniform"
velocity = [1, 0, 0]
[[bodies]]
name = "squirmer"
radius = 1
density = 2
position = [1, 0, 0]
[bodies.slip]
b1 = 1
b2 = 2
axis = [0, 0, 1]
"#,
    r#"
[background]
kind = "shear"
gradient = [[0, 1, 0], [0, 0, 0], [0, 0, 0]]
[[bodies]]
name = "a"
radius = 1
position = [1, 0, 0]
"#,
    r#"
[domain]
kind = "surface"
file = "tests/all/tetrahedron.obj"
scale = 100
[[bodies]]
name = "part"
shape = "surface"
file = "tests/all/tetrahedron.obj"
scale = 1
centre = [1, 1, 1]
position = [50, 50, 50]
"#,
];
