//! Viscosity laws of scene files.

use scene::rheology::Law;
use scene::{RheologyKind, Scene};

fn scene(fluid: &str) -> Result<Scene, scene::SceneError> {
    Scene::parse(&format!(
        "fluid = {{ {fluid} }}\ndomain = {{ kind = \"ball\", radius = 10 }}\n\
         [[bodies]]\nname = \"ball\"\nradius = 1\nposition = [0, 0, 0]\nforce = [1, 0, 0]\n"
    ))
}

#[test]
fn laws_are_read_and_written() {
    let fluids = [
        "law = \"carreau\", zero_shear_viscosity = 2, relaxation_time = 3, index = 0.5",
        "law = \"carreau-yasuda\", zero_shear_viscosity = 2, infinite_shear_viscosity = 0.1, \
         relaxation_time = 3, index = 0.5, transition = 1.5, rheology = \"auto\"",
        "law = \"cross\", zero_shear_viscosity = 2, relaxation_time = 3, index = 0.5",
        "law = \"power-law\", consistency = 2, index = 1.5",
        "law = \"herschel-bulkley\", consistency = 2, index = 0.5, yield_stress = 0.1, \
         regularisation = 1e-4",
    ];
    for fluid in fluids {
        let read = scene(fluid).unwrap();
        let again = Scene::parse(&read.to_toml().unwrap()).unwrap();
        assert_eq!(
            (read.viscosity(), read.differing_key(&again)),
            (2.0, None),
            "{fluid}"
        );
        assert!(read.rheology().is_some(), "{fluid}");
    }
    let carreau = scene(fluids[0]).unwrap();
    let law = Law::Carreau {
        zero_shear_viscosity: 2.0,
        infinite_shear_viscosity: 0.0,
        relaxation_time: 3.0,
        index: 0.5,
    };
    assert_eq!(carreau.rheology().unwrap().law, law);
    let newtonian = carreau.with_rheology(RheologyKind::Newtonian).unwrap();
    assert!(carreau.rheology().unwrap().is_kept() && !newtonian.rheology().unwrap().is_kept());
}

#[test]
fn laws_without_meaning_are_refused_with_their_key() {
    for (fluid, key) in [
        (
            "law = \"carreau\", relaxation_time = 3, index = 0.5",
            "fluid.zero_shear_viscosity",
        ),
        ("zero_shear_viscosity = 2", "fluid.zero_shear_viscosity"),
        (
            "law = \"power-law\", consistency = 1, index = 0.5, transition = 2",
            "fluid.transition",
        ),
        (
            "law = \"cross\", zero_shear_viscosity = 2, relaxation_time = 3, index = 1",
            "fluid.index",
        ),
        (
            "law = \"carreau\", zero_shear_viscosity = 1, infinite_shear_viscosity = 9, \
             relaxation_time = 3, index = 2",
            "fluid.law",
        ),
        (
            "viscosity = 1, law = \"power-law\", consistency = 2, index = 0.5",
            "fluid.viscosity",
        ),
        (
            "law = \"power-law\", consistency = 2, index = 0.5, rheology = \"auto\"",
            "fluid.rheology",
        ),
    ] {
        let message = scene(fluid).unwrap_err().to_string();
        assert!(message.contains(&format!("{key} ")), "{fluid}: {message}");
    }
}
