//! Every public function on hostile arguments: a right answer or an error, never a panic.

use ale::{
    AleError, Biharmonic, Elastic, Harmonic, Kernel, MeshMotion, MovingBody, MovingMesh, Rbf,
    ReferenceMap, Stiffening,
};
use fem::TaylorHood;
use mesh::{LinearTets, TetMesh, Vec3};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use proptest::prelude::*;

fn number() -> impl Strategy<Value = f64> {
    let hostile = [
        0.0,
        5e-324,
        1e-300,
        1e300,
        f64::MAX,
        f64::NAN,
        f64::INFINITY,
    ];
    prop_oneof![12 => -0.1..0.1, 1 => proptest::sample::select(hostile.to_vec())]
}

fn vector() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(number()).prop_map(Vec3::from)
}

fn motion() -> impl Strategy<Value = Isometry3<f64>> {
    let rotation = prop_oneof![
        4 => prop::array::uniform3(-0.1..0.1)
            .prop_map(|v| UnitQuaternion::from_scaled_axis(Vec3::from(v))),
        1 => prop::array::uniform4(number())
            .prop_map(|[w, i, j, k]| UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k))),
    ];
    (vector(), rotation).prop_map(|(x, q)| Isometry3::from_parts(Translation3::from(x), q))
}

fn methods(poisson: f64) -> [Box<dyn MeshMotion>; 6] {
    [
        Box::new(Harmonic(Stiffening::KanchiMasud)),
        Box::new(Harmonic(Stiffening::None)),
        Box::new(Elastic::new(poisson)),
        Box::new(Biharmonic),
        Box::new(Rbf(Kernel::Linear)),
        Box::new(Rbf(Kernel::Cubic)),
    ]
}

fn cube() -> TetMesh {
    TetMesh::straight(LinearTets::cube(2)).expect("a cube")
}

fn is_valid(mesh: &TetMesh) -> bool {
    (0..mesh.n_cells()).all(|cell| mesh.cell_volume(cell) > 0.0)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn maps_with_hostile_motions_are_valid_or_refused(
        (method, poisson) in (0..6usize, number()),
        bodies in prop::collection::vec((0..7usize, vector(), any::<bool>()), 0..3),
        motions in prop::collection::vec(motion(), 0..3),
    ) {
        let tags = ["x0", "x1", "y0", "y1", "z0", "z1", "none"];
        let body = |&(tag, centre, rotates): &(usize, Vec3, bool)| MovingBody {
            tag: tags[tag].into(),
            centre,
            rotates,
        };
        let bodies: Vec<MovingBody> = bodies.iter().map(body).collect();
        let method = methods(poisson).into_iter().nth(method).expect("a method");
        if let Ok(map) = ReferenceMap::new(cube(), &bodies, method.as_ref()) {
            prop_assert!(is_valid(map.reference()));
            if let Ok(moved) = map.moved(&motions) {
                prop_assert!(is_valid(&moved) && motions.len() == bodies.len());
            }
        }
    }

    #[test]
    fn extensions_of_hostile_fields_answer_or_refuse(
        (method, poisson) in (0..6usize, number()),
        prescribed in prop::collection::vec(any::<bool>(), 26..28),
        fields in prop::collection::vec(prop::collection::vec(vector(), 26..28), 0..3),
        all in 0..4usize,
    ) {
        let mesh = cube();
        let space = TaylorHood::new(&mesh).expect("a space");
        let prescribed: Vec<bool> = prescribed.iter().map(|is| (*is || all == 0) && all != 1).collect();
        let moving = MovingMesh { mesh: &mesh, space: &space, prescribed: &prescribed };
        let method = methods(poisson).into_iter().nth(method).expect("a method");
        let mut extended = fields.clone();
        let fits = prescribed.len() == 27 && fields.iter().all(|field| field.len() == 27);
        if method.extend(&moving, &mut extended).is_ok() {
            prop_assert!(fits);
            for (old, new) in fields.iter().zip(&extended) {
                for ((old, new), is) in old.iter().zip(new).zip(&prescribed) {
                    let is_right = match is {
                        true => old == new,
                        false => new.iter().all(|x| x.is_finite()),
                    };
                    prop_assert!(is_right);
                }
            }
        }
    }
}

#[test]
fn bug_a_misspelt_boundary_part_was_reported_as_a_bad_mesh() {
    let body = |tag: &str| MovingBody {
        tag: tag.into(),
        centre: Vec3::zeros(),
        rotates: false,
    };
    let refused = |bodies: &[MovingBody]| {
        let harmonic = Harmonic(Stiffening::default());
        ReferenceMap::new(cube(), bodies, &harmonic).expect_err("refused")
    };
    let error = refused(&[body("x7")]);
    assert!(matches!(error, AleError::NoSurface(_)), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("x7") && text.contains("x0") && !text.contains("remesh"),
        "{text}"
    );
    let error = refused(&[body("x0"), body("x0")]);
    assert!(matches!(error, AleError::SharedSurface { .. }), "{error}");
}
