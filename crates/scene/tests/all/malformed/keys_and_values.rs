//! Text that is not TOML, unknown keys, values of the wrong kind and numbers out of range.

/// The part of the valid scene to replace, its replacement, and what the message must contain.
pub const CASES: &[(&str, &str, &[&str])] = &[
    // Not TOML.
    (
        "viscosity = 1",
        "viscosity = ",
        &["scene.toml:2", "not valid TOML"],
    ),
    ("[fluid]", "[fluid", &["scene.toml:1", "not valid TOML"]),
    (
        "radius = 40",
        "radius = 40\nradius = 41",
        &["scene.toml:7", "duplicate key"],
    ),
    (
        "radius = 40",
        "radius = 4O",
        &["scene.toml:6", "not valid TOML"],
    ),
    ("[model]", "\u{0}", &["not valid TOML"]),
    // Unknown keys.
    (
        "viscosity",
        "viscocity",
        &[
            "scene.toml:2",
            "'fluid.viscocity'",
            "did you mean 'fluid.viscosity'?",
        ],
    ),
    (
        "[fluid]",
        "[fluids]",
        &["scene.toml:1", "did you mean 'fluid'?"],
    ),
    (
        "cycles",
        "cycle",
        &["scene.toml:24", "did you mean 'gait.cycles'?"],
    ),
    (
        "radius = 40",
        "temperature = 3\nradius = 40",
        &[
            "scene.toml:6",
            "domain has kind, radius, size, file, surface_kind, scale, walls",
        ],
    ),
    (
        "[fem]",
        "rtol = 1e-3\n[fem]",
        &["'model.rtol'", "did you mean 'fem.rtol'?"],
    ),
    (
        "kind = \"fem\"",
        "kind.fem = 1",
        &[
            "scene.toml:37",
            "model.kind must be one of auto, oseen",
            "not a table",
        ],
    ),
    (
        "name = \"arm\"",
        "name = \"arm\"\nlenght = 3",
        &["scene.toml:20", "'links[0].lenght'", "has name, body, to"],
    ),
    // Wrong types.
    (
        "viscosity = 1",
        "viscosity = \"1\"",
        &[
            "scene.toml:2",
            "fluid.viscosity must be a number greater than zero",
            "the text \"1\"",
        ],
    ),
    (
        "position = [0, 0, 0]",
        "position = [0, 0]",
        &["scene.toml:16", "bodies[1].position must be three numbers"],
    ),
    (
        "position = [0, 0, 0]",
        "position = [0, nan, 0]",
        &["scene.toml:16", "bodies[1].position must be three numbers"],
    ),
    (
        "position = [0, 0, 0]",
        "position = [0, 0, \"a\"]",
        &["bodies[1].position must be three numbers"],
    ),
    (
        "cycles = 2",
        "cycles = 2.5",
        &["scene.toml:24", "gait.cycles must be a whole number", "2.5"],
    ),
    (
        "cycles = 2",
        "cycles = 0",
        &["gait.cycles must be a whole number of at least 1"],
    ),
    (
        "cycles = 2",
        "cycles = 99999999999",
        &["gait.cycles must be a whole number"],
    ),
    (
        "[gait]\ncycles = 2",
        "[gait]\ncycles = true",
        &["gait.cycles must be a whole number", "true"],
    ),
    (
        "[fluid]\nviscosity = 1",
        "fluid = 3",
        &["scene.toml:1", "fluid must be a table, written as [fluid]"],
    ),
    (
        "[[links]]",
        "[links]",
        &[
            "scene.toml:18",
            "links must be a list of tables, written as [[links]]",
        ],
    ),
    (
        "name = \"left\"",
        "name = \"\"",
        &[
            "scene.toml:9",
            "bodies[0].name must be a text that is not empty",
        ],
    ),
    (
        "name = \"left\"",
        "name = 7",
        &["bodies[0].name must be a text"],
    ),
    // Numbers out of range.
    (
        "viscosity = 1",
        "viscosity = 0",
        &["fluid.viscosity must be a number greater than zero, not 0"],
    ),
    (
        "viscosity = 1",
        "viscosity = -2.5",
        &["fluid.viscosity", "not -2.5"],
    ),
    (
        "viscosity = 1",
        "viscosity = nan",
        &["fluid.viscosity", "not nan"],
    ),
    (
        "viscosity = 1",
        "viscosity = inf",
        &["fluid.viscosity", "not inf"],
    ),
    (
        "radius = 40",
        "radius = -40",
        &[
            "scene.toml:6",
            "domain.radius must be a number greater than zero",
        ],
    ),
    (
        "radius = 1\nposition = [0",
        "radius = 0\nposition = [0",
        &["scene.toml:15", "bodies[1].radius"],
    ),
    (
        "duration = 1\n\n[model]",
        "duration = 0\n\n[model]",
        &["gait.phases[1].duration"],
    ),
    (
        "length = 6",
        "length = -6",
        &["scene.toml:28", "gait.phases[0].length"],
    ),
    (
        "tolerance = 1e-3",
        "tolerance = 2",
        &["model.tolerance must be below 1"],
    ),
    (
        "rtol = 1e-8",
        "rtol = 1e-30",
        &["scene.toml:41", "fem.rtol", "at least 1e-14"],
    ),
    (
        "[fem]\nrtol = 1e-8",
        "[fem]\nsurface_size = -1",
        &["fem.surface_size"],
    ),
];
