//! Example scenes, as `swim new` writes them.

/// Names and texts of the example scenes.
pub const TEMPLATES: [(&str, &str); 14] = [
    (
        "three-sphere",
        include_str!("../templates/three-sphere.toml"),
    ),
    ("smooth", include_str!("../templates/smooth.toml")),
    ("chain", include_str!("../templates/chain.toml")),
    ("planar", include_str!("../templates/planar.toml")),
    ("tetrahedral", include_str!("../templates/tetrahedral.toml")),
    ("purcell", include_str!("../templates/purcell.toml")),
    ("scallop", include_str!("../templates/scallop.toml")),
    ("elastic-arm", include_str!("../templates/elastic-arm.toml")),
    ("corkscrew", include_str!("../templates/corkscrew.toml")),
    ("squirmer", include_str!("../templates/squirmer.toml")),
    ("jeffery", include_str!("../templates/jeffery.toml")),
    ("settling", include_str!("../templates/settling.toml")),
    (
        "optimal-stroke",
        include_str!("../templates/optimal-stroke.toml"),
    ),
    ("learning", include_str!("../templates/learning.toml")),
];

#[cfg(test)]
mod tests {
    use super::TEMPLATES;
    use crate::Scene;

    #[test]
    fn every_template_is_a_scene() {
        for (name, text) in TEMPLATES {
            assert!(Scene::parse(text).is_ok(), "{name}");
        }
    }
}
