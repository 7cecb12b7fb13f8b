//! Symmetric quadrature rules on the reference tetrahedron and triangle.
//!
//! The rules are symmetric, so that a reflected mesh gives reflected matrices. Weights are positive
//! and points lie inside, so that mass matrices are positive definite and stiffness matrices
//! semidefinite on every valid cell. The weights sum to the reference measure, 1/6 and 1/2.
//!
//! Crates of Gauss rules, such as gauss-quad, are one-dimensional. Collapsed tensor products of
//! Gauss-Jacobi rules are not symmetric and need more points: 27 instead of 14 for degree 5 and 64
//! instead of 24 for degree 6.

use std::sync::LazyLock;

use mesh::Vec3;

use crate::FemError;
use crate::taylor_hood::{shape_functions, shape_gradients};

/// Quadrature point of the reference tetrahedron, with the values of the shape functions.
pub(crate) struct CellPoint {
    /// Barycentric coordinates, which are the linear shape functions.
    pub barycentric: [f64; 4],
    /// Weight.
    pub weight: f64,
    /// Quadratic shape functions.
    pub shape: [f64; 10],
    /// Gradients of the quadratic shape functions in reference coordinates.
    pub gradients: [Vec3; 10],
}

impl CellPoint {
    /// Quadrature point at `barycentric` with the given weight.
    pub fn new(barycentric: [f64; 4], weight: f64) -> Self {
        Self {
            barycentric,
            weight,
            shape: shape_functions(barycentric),
            gradients: shape_gradients(barycentric),
        }
    }
}

/// Quadrature point of the reference triangle.
#[derive(Clone, Copy)]
pub(crate) struct FacetPoint {
    /// Barycentric coordinates.
    pub barycentric: [f64; 3],
    /// Weight.
    pub weight: f64,
}

/// Rule of 4 points and degree 2: exact for products of first derivatives on affine cells.
pub(crate) fn degree_2() -> &'static [CellPoint] {
    static RULE: LazyLock<Vec<CellPoint>> = LazyLock::new(|| {
        // a = (5 - √5) / 20: Hammer and Stroud, 1956.
        tetrahedron(&[(0.25, orbit_31((5.0 - 5f64.sqrt()) / 20.0))])
    });
    &RULE
}

/// Rule of 14 points and degree 5 (Walkington, 2000).
pub(crate) fn degree_5() -> &'static [CellPoint] {
    static RULE: LazyLock<Vec<CellPoint>> = LazyLock::new(|| {
        tetrahedron(&[
            (0.112_687_925_718_015_85, orbit_31(0.310_885_919_263_300_6)),
            (0.073_493_043_116_361_95, orbit_31(0.092_735_250_310_891_23)),
            (
                0.042_546_020_777_081_466,
                orbit_22(0.045_503_704_125_649_65),
            ),
        ])
    });
    &RULE
}

/// Rule of 24 points and degree 6 (Keast, 1986).
pub(crate) fn degree_6() -> &'static [CellPoint] {
    static RULE: LazyLock<Vec<CellPoint>> = LazyLock::new(|| {
        tetrahedron(&[
            (0.039_922_750_258_167_49, orbit_31(0.214_602_871_259_151_68)),
            (
                0.010_077_211_055_320_643,
                orbit_31(0.040_673_958_534_611_35),
            ),
            (0.055_357_181_543_654_72, orbit_31(0.322_337_890_142_275_5)),
            (
                27.0 / 560.0,
                orbit_211(0.063_661_001_875_017_53, 0.603_005_664_791_649_1),
            ),
        ])
    });
    &RULE
}

/// Rule of 46 points and degree 8 with the orbits of Zhang, Cui and Liu, 2009.
///
/// The moment equations have one solution more than equations; these numbers are the one next to
/// the published rule, solved by Newton's method with 60 digits.
pub(crate) fn degree_8() -> &'static [CellPoint] {
    static RULE: LazyLock<Vec<CellPoint>> = LazyLock::new(|| {
        tetrahedron(&[
            (
                0.006_397_171_373_016_017_5,
                orbit_31(0.039_675_482_759_097_61),
            ),
            (0.040_190_479_503_089_13, orbit_31(0.314_487_794_881_734_9)),
            (0.024_308_010_669_750_2, orbit_31(0.101_986_811_760_184_13)),
            (
                0.054_858_844_369_956_895,
                orbit_31(0.184_203_710_160_087_13),
            ),
            (
                0.035_719_623_584_376_754,
                orbit_22(0.063_436_307_254_038_01),
            ),
            (
                0.007_183_189_893_131_17,
                orbit_211(0.021_690_156_030_471_537, 0.719_931_873_199_222_4),
            ),
            (
                0.016_372_163_009_409_704,
                orbit_211(0.204_480_072_581_958_55, 0.580_577_256_707_835_7),
            ),
        ])
    });
    &RULE
}

/// Largest degree of the rules.
const MAX_DEGREE: usize = 8;

/// The rule on the tetrahedron with the fewest points that is exact up to `degree`.
pub(crate) fn cell_rule(degree: usize) -> Result<&'static [CellPoint], FemError> {
    match degree {
        0..=2 => Ok(degree_2()),
        3..=5 => Ok(degree_5()),
        6 => Ok(degree_6()),
        7..=MAX_DEGREE => Ok(degree_8()),
        _ => Err(FemError::Degree {
            degree,
            largest: MAX_DEGREE,
        }),
    }
}

/// The rule on the triangle with the fewest points that is exact up to `degree`.
pub(crate) fn facet_rule(degree: usize) -> Result<&'static [FacetPoint], FemError> {
    match degree {
        0..=6 => Ok(facet_degree_6()),
        7..=MAX_DEGREE => Ok(facet_degree_8()),
        _ => Err(FemError::Degree {
            degree,
            largest: MAX_DEGREE,
        }),
    }
}

/// Rule of 12 points and degree 6 on the triangle (Dunavant, 1985).
pub(crate) fn facet_degree_6() -> &'static [FacetPoint] {
    static RULE: LazyLock<Vec<FacetPoint>> = LazyLock::new(|| {
        triangle(
            None,
            &[
                (0.116_786_275_726_379_37, 0.249_286_745_170_910_42),
                (0.050_844_906_370_206_82, 0.063_089_014_491_502_23),
            ],
            (
                0.082_851_075_618_373_57,
                [0.310_352_451_033_784_4, 0.053_145_049_844_816_95],
            ),
        )
    });
    &RULE
}

/// Rule of 16 points and degree 8 on the triangle (Dunavant, 1985).
pub(crate) fn facet_degree_8() -> &'static [FacetPoint] {
    static RULE: LazyLock<Vec<FacetPoint>> = LazyLock::new(|| {
        triangle(
            Some(0.144_315_607_677_787_17),
            &[
                (0.095_091_634_267_284_62, 0.459_292_588_292_723_2),
                (0.103_217_370_534_718_24, 0.170_569_307_751_760_2),
                (0.032_458_497_623_198_08, 0.050_547_228_317_030_98),
            ],
            (
                0.027_230_314_174_434_993,
                [0.008_394_777_409_957_605, 0.263_112_829_634_638_1],
            ),
        )
    });
    &RULE
}

/// Points of a triangle rule from the weights of its orbits, which are for a unit area: the
/// centroid, the permutations of `(b, a, a)`, and those of `(a, b, c)`.
fn triangle(
    centroid: Option<f64>,
    orbits_21: &[(f64, f64)],
    (weight_111, [a, b]): (f64, [f64; 2]),
) -> Vec<FacetPoint> {
    let mut points = Vec::with_capacity(16);
    let mut add = |weight: f64, barycentric: [f64; 3]| {
        points.push(FacetPoint {
            barycentric,
            weight: 0.5 * weight,
        });
    };
    if let Some(weight) = centroid {
        add(weight, [1.0 / 3.0; 3]);
    }
    for &(weight, a) in orbits_21 {
        let b = 1.0 - 2.0 * a;
        for l in [[b, a, a], [a, b, a], [a, a, b]] {
            add(weight, l);
        }
    }
    let c = 1.0 - a - b;
    for l in [
        [a, b, c],
        [b, c, a],
        [c, a, b],
        [b, a, c],
        [a, c, b],
        [c, b, a],
    ] {
        add(weight_111, l);
    }
    points
}

/// Points of a rule from its orbits under the symmetry group; weights are for a unit volume.
fn tetrahedron(orbits: &[(f64, Vec<[f64; 4]>)]) -> Vec<CellPoint> {
    orbits
        .iter()
        .flat_map(|(weight, orbit)| orbit.iter().map(move |&l| CellPoint::new(l, weight / 6.0)))
        .collect()
}

/// The four permutations of `(b, a, a, a)`, `b = 1 - 3 a`.
fn orbit_31(a: f64) -> Vec<[f64; 4]> {
    (0..4)
        .map(|i| {
            let mut l = [a; 4];
            l[i] = 1.0 - 3.0 * a;
            l
        })
        .collect()
}

/// The six permutations of `(a, a, b, b)`, `b = 1/2 - a`.
fn orbit_22(a: f64) -> Vec<[f64; 4]> {
    pairs()
        .filter(|&(i, j)| i < j)
        .map(|(i, j)| {
            let mut l = [0.5 - a; 4];
            (l[i], l[j]) = (a, a);
            l
        })
        .collect()
}

/// The twelve permutations of `(a, a, b, c)`, `c = 1 - 2 a - b`.
fn orbit_211(a: f64, b: f64) -> Vec<[f64; 4]> {
    pairs()
        .map(|(i, j)| {
            let mut l = [a; 4];
            (l[i], l[j]) = (b, 1.0 - 2.0 * a - b);
            l
        })
        .collect()
}

/// Ordered pairs of different vertices.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..4).flat_map(|i| (0..4).filter(move |&j| j != i).map(move |j| (i, j)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: i32) -> f64 {
        (1..=n).map(f64::from).product()
    }

    /// Largest relative error over the monomials `x^i y^j z^k` of total degree up to `degree`.
    fn largest_error(rule: &[CellPoint], degree: i32) -> f64 {
        let mut largest = 0f64;
        for i in 0..=degree {
            for j in 0..=degree - i {
                for k in 0..=degree - i - j {
                    let sum: f64 = rule
                        .iter()
                        .map(|q| {
                            let [_, x, y, z] = q.barycentric;
                            q.weight * x.powi(i) * y.powi(j) * z.powi(k)
                        })
                        .sum();
                    let exact =
                        factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3);
                    largest = largest.max((sum / exact - 1.0).abs());
                }
            }
        }
        largest
    }

    #[test]
    fn tetrahedron_rules_have_exactly_their_degree() {
        for degree in [2, 5, 6, 8] {
            let rule = cell_rule(degree as usize).unwrap();
            assert!(
                largest_error(rule, degree) < 2e-14,
                "degree {degree}: {:e}",
                largest_error(rule, degree)
            );
            assert!(
                largest_error(rule, degree + 1) > 1e-6,
                "a rule of degree {degree} is exact for degree {}",
                degree + 1
            );
            assert!(
                rule.iter()
                    .all(|q| q.weight > 0.0 && q.barycentric.iter().all(|&l| l > 0.0))
            );
        }
    }

    #[test]
    fn facet_rules_have_exactly_their_degree() {
        let largest_error = |rule: &[FacetPoint], degree: i32| {
            let mut largest = 0f64;
            for i in 0..=degree {
                for j in 0..=degree - i {
                    let sum: f64 = rule
                        .iter()
                        .map(|q| q.weight * q.barycentric[1].powi(i) * q.barycentric[2].powi(j))
                        .sum();
                    let exact = factorial(i) * factorial(j) / factorial(i + j + 2);
                    largest = largest.max((sum / exact - 1.0).abs());
                }
            }
            largest
        };
        for degree in [6, 8] {
            let rule = facet_rule(degree as usize).unwrap();
            let error = largest_error(rule, degree);
            assert!(error < 2e-14, "degree {degree}: {error:e}");
            assert!(largest_error(rule, degree + 1) > 1e-6, "degree {degree}");
            assert!(
                rule.iter()
                    .all(|q| q.weight > 0.0 && q.barycentric.iter().all(|&l| l > 0.0))
            );
        }
    }

    #[test]
    fn a_degree_above_the_largest_names_it() {
        assert_eq!(cell_rule(3).unwrap().len(), 14);
        assert_eq!(facet_rule(7).unwrap().len(), 16);
        let error = cell_rule(9).err().unwrap();
        assert_eq!(Some(&error), facet_rule(9).err().as_ref());
        assert!(error.to_string().contains("largest degree is 8"), "{error}");
    }
}
