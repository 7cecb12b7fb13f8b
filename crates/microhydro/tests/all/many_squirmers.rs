//! Squirmers by expansions without a matrix over all spheres.

use std::f64::consts::PI;

use microhydro::multipole::{MultipoleMobility, SlipDrive, SlipModes, SphereSlip, Variant};
use microhydro::nalgebra::{DVector, Matrix3, Vector3};
use microhydro::{
    Accuracy, HydroError, LinkedMotion, LinkedSpheres, Medium, Mobility, PointMobility, PointModel,
    Spheres, Squirmer, multipole,
};

use super::{free, held, total_force};

/// Motion, power and stresslets of spheres with slip.
struct Found {
    motion: LinkedMotion,
    /// `(U, ω)`, six entries per sphere; none of held ones.
    velocities: DVector<f64>,
    power: f64,
    stresslets: Vec<Matrix3<f64>>,
    drive: SlipDrive,
}

impl Found {
    fn velocity(&self, sphere: usize) -> Vector3<f64> {
        self.velocities.fixed_rows::<3>(6 * sphere).into_owned()
    }
}

/// Spheres with slip that are free or held at rest.
#[derive(Clone, Copy)]
struct Case<'a> {
    spheres: &'a Spheres,
    /// Edges of the box; none in unbounded fluid.
    period: Option<&'a Vector3<f64>>,
    tolerance: f64,
    is_held: bool,
    variant: Variant,
}

impl<'a> Case<'a> {
    fn new(spheres: &'a Spheres, period: Option<&'a Vector3<f64>>, tolerance: f64) -> Self {
        Self {
            spheres,
            period,
            tolerance,
            is_held: false,
            variant: Variant::Full,
        }
    }

    fn solve(self, slip: &SphereSlip<'_>) -> Found {
        let modes = SlipModes::new(self.spheres, slip).unwrap();
        let accuracy = Accuracy::relative(self.tolerance);
        let mobility = MultipoleMobility::new(self.spheres, self.period, &accuracy, Some(&modes));
        let mut mobility = mobility.unwrap();
        mobility.set_variant(self.variant);
        let drive = mobility.slip().unwrap().clone();
        let linkages = (0..self.spheres.len()).map(|sphere| {
            let offset = drive.velocities.rows(6 * sphere, 6).into_owned();
            let mut one = match self.is_held {
                true => held(sphere, DVector::zeros(6)),
                false => free(sphere, DVector::zeros(6)),
            };
            one.offset = offset;
            one
        });
        let linked = LinkedSpheres::new(&mobility, linkages.collect()).unwrap();
        let linked = linked.with_hidden(drive.hidden.clone()).unwrap();
        let motion = linked.solve(1e-3 * self.tolerance).unwrap();
        let velocities = motion.coordinates.iter().flat_map(|v| v.iter().copied());
        Found {
            velocities: DVector::from_vec(velocities.collect()),
            power: drive.power(&motion.forces, &motion.hidden),
            stresslets: mobility.stresslets(&motion.hidden),
            motion,
            drive,
        }
    }
}

/// Pullers, pushers and neutral squirmers.
fn squirmers(count: usize) -> Vec<Squirmer> {
    let of = |k: usize| {
        let turn = k as f64;
        let axis = Vector3::new(turn.sin(), turn.cos(), (2.0 * turn).sin() + 0.1).normalize();
        Squirmer {
            b1: 1.0,
            b2: 2.0 - 0.4 * (k % 11) as f64,
            axis,
        }
    };
    (0..count).map(of).collect()
}

/// Unit spheres on a lattice.
fn cube(edge: usize, gap: f64) -> Spheres {
    let centres = (0..edge.pow(3)).map(|k| {
        let place = [k % edge, k / edge % edge, k / edge / edge];
        (2.0 + gap) * Vector3::from(place.map(|x| x as f64))
    });
    Spheres::new(centres.collect(), vec![1.0; edge.pow(3)]).unwrap()
}

/// Some spheres of several radii in a box with these edges.
fn in_box() -> (Spheres, Vector3<f64>) {
    let places = [
        [0.1, 0.3, 0.2],
        [4.6, 0.4, 0.5],
        [3.1, 4.2, 6.7],
        [-3.0, 7.3, 2.9],
        [2.2, 0.5, 0.2],
    ];
    let radii = vec![1.0, 0.7, 1.3, 0.5, 0.9];
    let spheres = Spheres::new(places.map(Vector3::from).to_vec(), radii).unwrap();
    (spheres, Vector3::new(7.0, 8.0, 9.0))
}

fn distance(one: &Found, other: &Found) -> f64 {
    (&one.velocities - &other.velocities).amax()
}

/// Lighthill (1952) and Blake (1971): motion, power and stresslet are those of three modes, which
/// any expansion has.
#[test]
fn a_lone_squirmer_has_its_motion_power_and_stresslet() {
    let one = Spheres::new(vec![Vector3::new(1.0, 2.0, 3.0)], vec![0.7]).unwrap();
    let own = Squirmer {
        b1: 1.5,
        b2: -2.0,
        axis: Vector3::new(0.48, 0.6, 0.64),
    };
    let found = Case::new(&one, None, 1e-2).solve(&|_, n| own.slip(n));
    assert!((found.velocity(0) - own.velocity()).norm() < 1e-14);
    assert!((found.power / own.power(0.7) - 1.0).abs() < 1e-14);
    let size = own.stresslet(0.7).norm();
    assert!((found.stresslets[0] - own.stresslet(0.7)).norm() < 1e-14 * size);
}

/// Surfaces that move as rigid ones do not move the fluid: the spheres move the other way, without
/// power.
#[test]
fn slip_that_is_a_rigid_motion_gives_the_opposite_motion() {
    let (spheres, size) = in_box();
    let given = |k: usize| {
        let turn = k as f64 + 0.5;
        let velocity = Vector3::new(turn.sin(), turn.cos(), 0.3 * turn);
        (velocity, Vector3::new(-0.4, turn.cos(), turn.sin()))
    };
    let radii = spheres.radii().to_vec();
    let slip = |k: usize, n: &Vector3<f64>| {
        let (velocity, spin) = given(k);
        velocity + spin.cross(&(radii[k] * n))
    };
    for period in [None, Some(&size)] {
        let found = Case::new(&spheres, period, 1e-3).solve(&slip);
        for k in 0..spheres.len() {
            let (velocity, spin) = given(k);
            let own = found.velocities.rows(6 * k, 6);
            // sums of 384 points of the surface
            assert!((own.fixed_rows::<3>(0) + velocity).norm() < 1e-13);
            assert!((own.fixed_rows::<3>(3) + spin).norm() < 1e-13);
        }
        assert!(found.power.abs() < 1e-12, "{:e}", found.power);
    }
}

/// The same equations, whose resistance matrix and eliminations are those of two spheres.
#[test]
fn two_squirmers_move_as_by_the_resistance_matrix() {
    let some = squirmers(2);
    let slip = |k: usize, n: &Vector3<f64>| some[k].slip(n);
    for gap in [1.0, 0.3, 0.05] {
        let apart = (1.7 + gap) * Vector3::new(0.6, 0.0, 0.8);
        let pair = Spheres::new(vec![Vector3::zeros(), apart], vec![1.0, 0.7]).unwrap();
        let (medium, accuracy) = (Medium::Unbounded, Accuracy::relative(1e-10));
        let resistance = multipole::resistance(&pair, &medium, &accuracy).unwrap();
        let orders = resistance.orders();
        let exact = multipole::surface_flow(&pair, &medium, orders, &[&slip]).unwrap();
        let (velocities, power) = (exact.velocities.column(0), exact.powers[(0, 0)]);
        let found = Case::new(&pair, None, 1e-9).solve(&slip);
        let error = (&found.velocities - velocities).amax();
        assert!(error < 1e-8, "{gap}: {error:e}");
        assert!((found.power / power - 1.0).abs() < 1e-8, "{gap}");
        let rest = DVector::zeros(12);
        let moving = [&found.velocities, &rest];
        let stresslets = multipole::stresslets(&pair, &medium, orders, moving, Some(&slip));
        for (found, exact) in found.stresslets.iter().zip(stresslets.unwrap().values) {
            let error = (found - exact).norm();
            assert!(error < 1e-7, "{gap}: {error:e}");
        }
        let held = Case {
            is_held: true,
            ..Case::new(&pair, None, 1e-9)
        };
        let forces = resistance.matrix() * velocities;
        let found = held.solve(&slip);
        // The same errors times the resistance of the gap, 6π/4 a/h.
        let allowed = 1e-8 * forces.amax() / gap;
        assert!((found.motion.forces + forces).amax() < allowed, "{gap}");
    }
}

/// The changes by both variants, the one of lower orders times the factor of what remains, contain
/// the errors against the resistance matrix of higher orders.
#[test]
fn changes_by_variants_contain_the_errors_among_27_squirmers() {
    let spheres = cube(3, 1.0);
    let some = squirmers(27);
    let slip = |k: usize, n: &Vector3<f64>| some[k].slip(n);
    let (medium, accuracy) = (Medium::Unbounded, Accuracy::order(8));
    let resistance = multipole::resistance(&spheres, &medium, &accuracy).unwrap();
    let exact = multipole::surface_flow(&spheres, &medium, resistance.orders(), &[&slip]).unwrap();
    let (velocities, power) = (exact.velocities.column(0), exact.powers[(0, 0)]);
    for tolerance in [1e-2, 1e-4] {
        let case = Case::new(&spheres, None, tolerance);
        let found = case.solve(&slip);
        let [mut bar, mut of_power] = [0.0; 2];
        for variant in [Variant::Neglecting, Variant::Lowered] {
            let other = Case { variant, ..case }.solve(&slip);
            bar += distance(&found, &other);
            of_power += (other.power - found.power).abs();
        }
        let error = (&found.velocities - velocities).amax();
        assert!(error < bar, "{tolerance:e}: {error:e} of {bar:e}");
        assert!((found.power - power).abs() < of_power, "{tolerance:e}");
        assert!(bar < 1e-2 && of_power < 1e-2 * power, "{tolerance:e}");
    }
}

/// Far from a narrow gap energies have the factors of wide ones.
#[test]
fn the_mean_factor_of_lower_orders_is_that_of_the_spheres_that_dissipate() {
    let centres = [0.0, 2.05, 8.0, 13.0, 18.0].map(|x| Vector3::new(x, 0.0, 0.0));
    let spheres = Spheres::new(centres.to_vec(), vec![1.0; 5]).unwrap();
    let some = squirmers(5);
    let mean = |squirming: [usize; 2]| {
        let slip = |k: usize, n: &Vector3<f64>| match squirming.contains(&k) {
            true => some[k].slip(n),
            false => Vector3::zeros(),
        };
        let modes = SlipModes::new(&spheres, &slip).unwrap();
        let accuracy = Accuracy::relative(1e-3);
        let mobility = MultipoleMobility::new(&spheres, None, &accuracy, Some(&modes)).unwrap();
        let found = Case::new(&spheres, None, 1e-3).solve(&slip);
        let tails = mobility.tails();
        assert_eq!(tails.len(), 5);
        assert!(tails[0] == mobility.tail() && tails[4] < 0.1 * tails[0]);
        let none = DVector::zeros(mobility.hidden());
        assert!(mobility.mean_tail(&none) == mobility.tail());
        mobility.mean_tail(&found.motion.hidden) / mobility.tail()
    };
    let (near, far) = (mean([0, 1]), mean([3, 4]));
    assert!(near > 0.9 && near <= 1.0, "{near}");
    assert!(far < 0.5, "{far}");
}

/// A force on a held sphere is the power that its slip has less than if it were free: by the
/// reciprocal theorem `P = P_0 - F · U_0`, with the velocities `U_0` of free spheres.
#[test]
fn powers_of_held_and_free_squirmers_satisfy_the_reciprocal_theorem() {
    let (spheres, size) = in_box();
    let some = squirmers(5);
    let slip = |k: usize, n: &Vector3<f64>| some[k].slip(n);
    for period in [None, Some(&size)] {
        let case = Case::new(&spheres, period, 1e-6);
        let free = case.solve(&slip);
        let held = Case {
            is_held: true,
            ..case
        };
        let held = held.solve(&slip);
        let expected = free.power - held.motion.forces.dot(&free.velocities);
        // The residual, 1e-9, of both.
        let error = (held.power / expected - 1.0).abs();
        assert!(error < 1e-7, "{error:e}");
        assert!(total_force(&free.motion.forces).norm() < 1e-12);
        assert!(held.motion.forces.amax() > 1.0);
    }
}

/// The images of the dipole are a flow against the motion, of the volume fraction. The third
/// degrees that their flow induces, of the order `(a/L)^5`, meet the sphere with `(a/L)^3`.
#[test]
fn a_squirmer_in_a_cubic_box_is_slower_by_the_volume_fraction() {
    let one = Spheres::new(vec![Vector3::new(1.0, 2.0, 3.0)], vec![1.0]).unwrap();
    let own = Squirmer {
        b1: 1.5,
        b2: 3.0,
        axis: Vector3::new(0.48, 0.6, 0.64),
    };
    let change = |edge: f64| {
        let size = Vector3::repeat(edge);
        let found = Case::new(&one, Some(&size), 1e-6).solve(&|_, n| own.slip(n));
        let points = PointMobility::periodic(PointModel::Rpy, &one, &size).unwrap();
        let by_points = points.by_slip(&[own]).unwrap().fixed_rows::<3>(0).norm();
        let fraction = 4.0 / 3.0 * PI / edge.powi(3);
        assert!((by_points - (1.0 - fraction)).abs() < 1e-11);
        (found.velocity(0) - (1.0 - fraction) * own.axis).norm()
    };
    let changes = [4.0, 8.0, 16.0].map(change);
    for pair in changes.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 8.0).abs() < 0.5, "{changes:?}");
    }
}

/// Far apart squirmers are those of Rotne, Prager and Yamakawa up to the fifth power.
#[test]
fn dilute_squirmers_in_a_box_move_as_singularities() {
    let change = |scale: f64| {
        let places = [[0.1, 0.3, 0.2], [1.1, 0.2, 0.3], [0.4, 1.0, 1.1]];
        let centres = places.map(|place| scale * Vector3::from(place)).to_vec();
        let spheres = Spheres::new(centres, vec![1.0; 3]).unwrap();
        let size = scale * Vector3::new(2.0, 2.2, 2.4);
        let some = squirmers(3);
        let found = Case::new(&spheres, Some(&size), 1e-8).solve(&|k, n| some[k].slip(n));
        let points = PointMobility::periodic(PointModel::Rpy, &spheres, &size).unwrap();
        (found.velocities - points.by_slip(&some).unwrap()).amax()
    };
    let [near, far] = [6.0, 12.0].map(change);
    let order = (near / far).log2();
    // The next powers are 6 % at the nearer distance, each of a factor of some units.
    assert!((4.5..6.0).contains(&order), "{near:e} {far:e}");
}

#[test]
fn boxes_may_be_shifted_and_repeated() {
    let (spheres, size) = in_box();
    let some = squirmers(5);
    let slip = |k: usize, n: &Vector3<f64>| some[k % 5].slip(n);
    let tolerance = 1e-4;
    let found = Case::new(&spheres, Some(&size), tolerance).solve(&slip);
    let shifted = |shift: &Vector3<f64>, images: bool| {
        let image = |k: usize| match images {
            true => size.component_mul(&Vector3::new(k as f64 - 2.0, (k % 2) as f64, -1.0)),
            false => Vector3::zeros(),
        };
        let centres = spheres.centres().iter().enumerate();
        let centres = centres.map(|(k, x)| x + shift + image(k)).collect();
        let moved = Spheres::new(centres, spheres.radii().to_vec()).unwrap();
        let moved = Case::new(&moved, Some(&size), tolerance).solve(&slip);
        distance(&found, &moved)
    };
    // Rounding of places of some tens.
    assert!(shifted(&Vector3::new(0.3, -1.7, 12.9), false) < 1e-11);
    assert!(shifted(&Vector3::zeros(), true) < 1e-11);
    let twice = spheres.centres().iter().copied();
    let copies = twice.clone().map(|x| x + size.x * Vector3::x());
    let radii = spheres.radii().iter().chain(spheres.radii()).copied();
    let two = Spheres::new(twice.chain(copies).collect(), radii.collect()).unwrap();
    let double = Vector3::new(2.0 * size.x, size.y, size.z);
    let two = Case::new(&two, Some(&double), tolerance).solve(&slip);
    for first in [0, 30] {
        let own = two.velocities.rows(first, 30);
        // The same images in other sums, each to the tolerance.
        let error = (own - &found.velocities).amax();
        assert!(error < tolerance, "{error:e}");
    }
    let error = (two.power / found.power - 2.0).abs();
    assert!(error < tolerance, "{error:e}");
}

#[test]
fn squirmers_do_not_depend_on_the_number_of_threads() {
    let (spheres, size) = in_box();
    let many = cube(4, 0.5);
    for (spheres, period) in [(&spheres, Some(&size)), (&many, None)] {
        let some = squirmers(spheres.len());
        let by = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let case = Case::new(spheres, period, 1e-3);
            let solve = || case.solve(&|k, n| some[k].slip(n));
            pool.build().unwrap().install(solve)
        };
        let (one, three) = (by(1), by(3));
        assert_eq!(one.velocities, three.velocities);
        assert_eq!(one.drive, three.drive);
        assert_eq!(one.power.to_bits(), three.power.to_bits());
    }
}

/// A slip of the twentieth degree raises the orders of its sphere alone.
#[test]
fn orders_contain_the_slip() {
    let spheres = cube(2, 1.0);
    let accuracy = Accuracy::relative(1e-2);
    let dofs = |slip: &SphereSlip<'_>| {
        let modes = SlipModes::new(&spheres, slip).unwrap();
        let mobility = MultipoleMobility::new(&spheres, None, &accuracy, Some(&modes)).unwrap();
        mobility.hidden()
    };
    let rest = MultipoleMobility::new(&spheres, None, &accuracy, None).unwrap();
    let of_order = |order: usize| {
        let count = |top: usize| top * (top + 2);
        count(order) + count(order - 1) + count(order - 2)
    };
    assert_eq!(rest.dofs(), 8 * of_order(4));
    let own = squirmers(1)[0];
    let first = |k: usize, n: &Vector3<f64>| match k {
        0 => own.slip(n),
        _ => Vector3::zeros(),
    };
    assert_eq!(dofs(&first), 7 * of_order(4) + of_order(6));
    let high = |k: usize, n: &Vector3<f64>| match k {
        0 => n.z.powi(20) * n.cross(&Vector3::z()),
        _ => own.slip(n),
    };
    // The degree 21 of `X_21` has the order 22, and the lower orders have it too.
    assert_eq!(dofs(&high), 7 * of_order(6) + of_order(24));
}

#[test]
fn growing_spheres_and_wrong_lengths_are_refused() {
    let spheres = cube(2, 1.0);
    let growing = |_: usize, n: &Vector3<f64>| 0.1 * n;
    let error = SlipModes::new(&spheres, &growing).err();
    assert!(matches!(error, Some(HydroError::NetFlux { sphere: 0, .. })));
    let rough = |_: usize, n: &Vector3<f64>| n.z.signum() * n.cross(&Vector3::z());
    let error = SlipModes::new(&spheres, &rough).err();
    assert!(matches!(error, Some(HydroError::SlipNotResolved { .. })));
    let infinite = |_: usize, n: &Vector3<f64>| n / 0.0;
    let error = SlipModes::new(&spheres, &infinite).err();
    assert!(matches!(error, Some(HydroError::NotFinite { .. })));
    let mobility = MultipoleMobility::new(&spheres, None, &Accuracy::relative(1e-2), None).unwrap();
    assert!(mobility.slip().is_none());
    let linkages = (0..8).map(|sphere| free(sphere, DVector::zeros(6)));
    let linked = LinkedSpheres::new(&mobility, linkages.collect()).unwrap();
    let error = linked.with_hidden(DVector::zeros(3)).err();
    assert!(matches!(error, Some(HydroError::Length { found: 3, .. })));
}
