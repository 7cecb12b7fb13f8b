//! Example scenes, as `swim new` writes them.

/// Names of the templates with the texts of their files.
macro_rules! templates {
    ($($name:literal)+) => {
        [$(($name, include_str!(concat!("../templates/", $name, ".toml")))),+]
    };
}

/// Names and texts of the example scenes.
pub const TEMPLATES: [(&str, &str); 24] = templates! {
    "three-sphere" "smooth" "chain" "planar" "tetrahedral" "purcell" "scallop" "elastic-arm"
    "corkscrew" "squirmer" "jeffery" "settling" "optimal-stroke" "learning"
    "thinning-squirmer" "thinning-stroke" "pushmepullyou" "amoeba" "sperm" "worm-in-channel"
    "swarm" "sediment" "squirmers" "brownian-swimmer"
};

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
