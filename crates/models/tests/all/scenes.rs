//! Scenes that several tests use.

use scene::Scene;

/// Three spheres with two arms of length 10, with further lines of the scene file.
pub fn three_spheres(lines: &str) -> Scene {
    let text = format!(
        r#"
        bodies = [
            {{ name = "left", radius = 1, position = [-10, 0, 0] }},
            {{ name = "centre", radius = 1, position = [0, 0, 0] }},
            {{ name = "right", radius = 1, position = [10, 0, 0] }},
        ]
        links = [
            {{ name = "left arm", body = "left", to = "centre" }},
            {{ name = "right arm", body = "right", to = "centre" }},
        ]
        {lines}
        "#
    );
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Three spheres in a ball, with coarse elements.
pub fn three_spheres_in_ball() -> Scene {
    three_spheres("domain = { kind = \"ball\", radius = 30 }\nfem.surface_size = 1.2")
}
