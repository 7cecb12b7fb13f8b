//! Wrong words, missing keys, wrong names and impossible geometry.

/// The part of the valid scene to replace, its replacement, and what the message must contain.
pub const CASES: &[(&str, &str, &[&str])] = &[
    // Words.
    (
        "kind = \"ball\"",
        "kind = \"bal\"",
        &[
            "scene.toml:5",
            "domain.kind cannot be \"bal\"; did you mean \"ball\"?",
        ],
    ),
    (
        "kind = \"fem\"",
        "kind = \"magic\"",
        &["model.kind cannot be \"magic\"; it is one of auto, oseen, rpy"],
    ),
    (
        "cycles = 2",
        "arms = \"clampd\"",
        &["did you mean \"clamped\"?"],
    ),
    (
        "radius = 1\nposition = [-10",
        "shape = \"cube\"\nradius = 1\nposition = [-10",
        &["bodies[0].shape cannot be \"cube\""],
    ),
    // Surfaces from files.
    (
        "radius = 1\nposition = [0",
        "shape = \"surface\"\nposition = [0",
        &[
            "scene.toml:13",
            "bodies[1].file is missing: give the STL, OBJ or Gmsh file",
        ],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"surface\"\nfile = \"no/such.stl\"\nposition = [0",
        &["scene.toml:16", "bodies[1].file is refused: no/such.stl"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"surface\"\nfile = \"Cargo.toml\"\nposition = [0",
        &["Cargo.toml: unknown file extension; use .stl, .obj or .msh"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"surface\"\nradius = 1\nfile = \"part.stl\"\nposition = [0",
        &["bodies[1].radius belongs to shape = \"sphere\""],
    ),
    (
        "radius = 1\nposition = [0",
        "radius = 1\nscale = 2\nposition = [0",
        &["bodies[1].scale belongs to shape = \"surface\""],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"surface\"\nscale = 0\nposition = [0",
        &["bodies[1].scale must be a number greater than zero"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"surface\"\nsurface_kind = \"smoth\"\nposition = [0",
        &["did you mean \"smooth\"?"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"file\"\nsurface = \"part\"\nposition = [0",
        &["bodies[1].shape \"file\" is a part of the boundary of a mesh"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"surface\"",
        &["domain.file is missing"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"ball\"\nradius = 40\nscale = 2",
        &["scene.toml:7", "domain.scale belongs to kind = \"surface\""],
    ),
    // Missing things.
    (
        "radius = 1\nposition = [0",
        "position = [0",
        &[
            "scene.toml:13",
            "bodies[1].radius is missing: a sphere needs a radius",
        ],
    ),
    (
        "position = [0, 0, 0]",
        "",
        &["bodies[1].position is missing"],
    ),
    ("name = \"centre\"", "", &["bodies[1].name is missing"]),
    (
        "radius = 40",
        "",
        &[
            "scene.toml:4",
            "domain.radius is missing: a ball needs a radius",
        ],
    ),
    ("kind = \"ball\"", "", &["domain.kind is missing"]),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"box\"",
        &["domain.size is missing"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"",
        &["domain.file is missing"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"\nfile = \"no/such.msh\"",
        &["scene.toml:6", "domain.file cannot be read: no/such.msh"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"\nfile = \"src\"\nwalls = [\"outer\"]",
        &["domain.file names src, which is not a file"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"\nfile = \"Cargo.toml\"",
        &["domain.walls is missing"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"\nfile = \"Cargo.toml\"\nwalls = []",
        &["domain.walls is empty"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"\nfile = \"Cargo.toml\"\nwalls = [\"outer\"]",
        &["bodies[0].surface is missing"],
    ),
    ("length = 6\n", "", &["gait.phases[0].length is missing"]),
    (
        "link = \"arm\"\nlength = 6",
        "length = 6",
        &["gait.phases[0].link is missing"],
    ),
    // Names.
    (
        "name = \"centre\"",
        "name = \"left\"",
        &["scene.toml:14", "\"left\" is the name of bodies[0] too"],
    ),
    (
        "[gait]",
        "[[links]]\nname = \"arm\"\nbody = \"centre\"\nto = \"left\"\n[gait]",
        &["\"arm\" is the name of links[0] too"],
    ),
    (
        "[gait]",
        "[[links]]\nname = \"arm-2\"\nbody = \"centre\"\nto = \"left\"\n[gait]",
        &["links[1]", "a second time"],
    ),
    (
        "to = \"centre\"",
        "to = \"center\"",
        &[
            "scene.toml:21",
            "links[0].to names no body: \"center\"; did you mean \"centre\"?",
        ],
    ),
    (
        "to = \"centre\"",
        "to = \"moon\"",
        &["names no body: \"moon\"; there are left, centre"],
    ),
    (
        "to = \"centre\"",
        "to = \"left\"",
        &["scene.toml:21", "links body 'left' to itself"],
    ),
    (
        "link = \"arm\"\nlength = 6",
        "link = \"amr\"\nlength = 6",
        &[
            "scene.toml:27",
            "names no link: \"amr\"; did you mean \"arm\"?",
        ],
    ),
    // Geometry.
    (
        "position = [-10, 0, 0]",
        "position = [0, 0, 0]",
        &["links[0] has no direction", "at the same place"],
    ),
    (
        "position = [-10, 0, 0]",
        "position = [-1.5, 0, 0]",
        &["'left' and 'centre' touch or overlap at the start: gap -0.5"],
    ),
    (
        "position = [-10, 0, 0]",
        "position = [-2, 0, 0]",
        &["touch or overlap at the start: gap 0"],
    ),
    (
        "position = [-10, 0, 0]",
        "position = [-39, 0, 0]",
        &[
            "scene.toml:11",
            "'left' is outside the domain",
            "clearance 0",
        ],
    ),
    (
        "position = [-10, 0, 0]",
        "position = [-90, 0, 0]",
        &["'left' is outside the domain", "clearance -51"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"box\"\nsize = [19, 40, 40]",
        &["'left' is outside the domain", "clearance -1.5"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"wall\"",
        &["is outside the domain", "clearance -1"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"cylinder\"\nradius = 1",
        &["is outside the domain", "clearance 0"],
    ),
    (
        "length = 6",
        "length = 1.5",
        &[
            "scene.toml:28",
            "touch or overlap in phase 1 at 100 %",
            "gap -0.5",
        ],
    ),
    (
        "length = 6",
        "length = 2",
        &["touch or overlap in phase 1", "gap 0"],
    ),
    (
        "[fluid]\nviscosity = 1\n\n[domain]\nkind = \"ball\"\nradius = 40\n\n[[bodies]]\n",
        "gravity = [0, 0, -1]\n[[bodies]]\ndensity = 2\nmass = 3\n",
        &["bodies[0].density is given beside a mass", "remove one"],
    ),
    // Points.
    (
        "radius = 1\nposition = [0",
        "shape = \"point\"\nradius = 1\nposition = [0",
        &["bodies[1].radius makes no sense for a point"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"point\"\ntorque = [1, 0, 0]\nposition = [0",
        &["bodies[1].torque cannot act on a point"],
    ),
    (
        "[gait]",
        "[[bodies]]\nname = \"p\"\nshape = \"point\"\nposition = [5, 0, 0]\n[gait]",
        &["bodies[2] is a point that no link holds"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"spheroid\"\nradius = 1\nposition = [0",
        &["scene.toml:", "bodies[1].half_length is missing"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"spheroid\"\nradius = 1\nhalf_length = 2\naxis = [0, 0, 0]\nposition = [0",
        &["bodies[1].axis must not be zero"],
    ),
    (
        "radius = 1\nposition = [0",
        "half_length = 2\nradius = 1\nposition = [0",
        &["bodies[1].half_length belongs to shape = \"spheroid\", \"capsule\", \"disk\""],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"ellipsoid\"\nradius = 1\nposition = [0",
        &["bodies[1].radius belongs to shape = \"sphere\""],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"ellipsoid\"\nposition = [0",
        &["scene.toml:", "bodies[1].semi_axes is missing"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"elipsoid\"\nposition = [0",
        &["did you mean \"ellipsoid\"?"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"capsule\"\nradius = 1\nhalf_length = 0.5\nposition = [0",
        &["bodies[1].half_length must be larger than the radius"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"disk\"\nradius = 1\nhalf_length = 2\nposition = [0",
        &["bodies[1].half_length must be smaller than the radius"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"torus\"\nradius = 1\ntube_radius = 1\nposition = [0",
        &["bodies[1].tube_radius must be smaller than the radius"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"helix\"\nradius = 1\ntube_radius = 0.1\npitch = 0\nturns = 2\nposition = [0",
        &["bodies[1].pitch must be other than zero"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"helix\"\nradius = 1\ntube_radius = 0.1\npitch = 1\nturns = 1e6\nposition = [0",
        &["bodies[1].turns must be at most 1000"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"capsule\"\nradius = 1\nhalf_length = 2\naxis = [0, 0, 1]\norientation = [0, 90, 0]\nposition = [0",
        &["bodies[1].orientation is given beside axis"],
    ),
];
