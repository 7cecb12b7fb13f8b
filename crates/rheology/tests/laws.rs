//! Properties of all laws.

use proptest::prelude::*;
use rheology::{Law, RheologyError, ViscosityLaw};

fn laws() -> impl Strategy<Value = Law> {
    let plateaus = (
        0.2..5.0_f64,
        0.0..0.5_f64,
        0.01..100.0_f64,
        0.2..0.95_f64,
        0.5..5.0_f64,
    );
    let power = (0.1..3.0_f64, 0.1..3.0_f64, 0.2..2.0_f64, 1e-6..1e-2_f64);
    (0..5_u8, plateaus, power).prop_map(|(kind, plateaus, power)| {
        let (zero_shear_viscosity, ratio, relaxation_time, index, transition) = plateaus;
        let infinite_shear_viscosity = ratio * zero_shear_viscosity;
        match kind {
            0 => Law::Carreau {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                relaxation_time,
                index,
            },
            1 => Law::CarreauYasuda {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                relaxation_time,
                index,
                transition,
            },
            2 => Law::Cross {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                relaxation_time,
                index,
            },
            3 => Law::PowerLaw {
                consistency: power.1,
                index: power.2,
                regularisation: power.3,
            },
            _ => Law::HerschelBulkley {
                yield_stress: power.0,
                consistency: power.1,
                index: power.2,
                regularisation: power.3,
            },
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn derivatives_are_those_of_differences(law in laws(), exponent in -4.0..4.0_f64) {
        law.validate().unwrap();
        let g = 10_f64.powf(exponent);
        let h = 1e-4 * g;
        let central = |f: &dyn Fn(f64) -> f64| (f(g + h) - f(g - h)) / (2.0 * h);
        let viscosity = law.viscosity(g);
        // relative error (h / g)^2 / 6 times the third derivative, at most about 60 = 3 4 5 times
        // the value, and the rounding of 1e-16 / 1e-4
        let bound = 1e-7 * viscosity / g;
        prop_assert!((central(&|g| law.viscosity(g)) - law.derivative(g)).abs() < bound);
        let bound = 1e-7 * law.potential(g) / g;
        prop_assert!((central(&|g| law.potential(g)) - viscosity * g).abs() < bound);
    }

    #[test]
    fn the_stress_increases(law in laws(), exponent in -6.0..6.0_f64) {
        prop_assert!(law.tangent_viscosity(10_f64.powf(exponent)) > 0.0);
    }

    #[test]
    fn stresses_scale(law in laws(), exponent in -3.0..3.0_f64, factor in 0.1..10.0_f64) {
        let g = 10_f64.powf(exponent);
        let scaled = law.scaled(factor);
        let close = |a: f64, b: f64| (a - factor * b).abs() <= 1e-14 * a.abs();
        prop_assert!(close(scaled.viscosity(g), law.viscosity(g)));
        prop_assert!(close(scaled.potential(g), law.potential(g)));
        let exact = law.unregularised_viscosity(g);
        prop_assert!(close(scaled.unregularised_viscosity(g), exact));
    }

    #[test]
    fn values_at_rest_and_at_huge_rates_are_numbers(law in laws()) {
        for g in [0.0, f64::MIN_POSITIVE, 1e-150, 1e140] {
            prop_assert!(law.viscosity(g).is_finite() && law.viscosity(g) >= 0.0, "{g:e}");
            prop_assert!(law.potential(g) >= 0.0, "{g:e}: {}", law.potential(g));
            if g > 0.0 {
                prop_assert!(law.derivative(g).is_finite(), "{g:e}");
            }
        }
    }
}

#[test]
fn parameters_without_meaning_are_refused_by_name() {
    let carreau = |zero, infinite, time, index| Law::Carreau {
        zero_shear_viscosity: zero,
        infinite_shear_viscosity: infinite,
        relaxation_time: time,
        index,
    };
    let refused = |law: Law, name| match law.validate() {
        Err(RheologyError::Parameter { parameter, .. }) => assert_eq!(parameter, name),
        other => panic!("{law:?}: {other:?}"),
    };
    refused(carreau(0.0, 0.0, 1.0, 0.5), "zero_shear_viscosity");
    refused(carreau(1.0, -0.1, 1.0, 0.5), "infinite_shear_viscosity");
    refused(carreau(1.0, 0.0, f64::NAN, 0.5), "relaxation_time");
    refused(carreau(1.0, 0.0, 1.0, 0.0), "index");
    refused(carreau(1.0, 0.0, 1.0, f64::INFINITY), "index");
    refused(
        Law::PowerLaw {
            consistency: 1.0,
            index: 0.5,
            regularisation: 0.0,
        },
        "regularisation",
    );
    let cross = Law::Cross {
        zero_shear_viscosity: 1.0,
        infinite_shear_viscosity: 0.0,
        relaxation_time: 1.0,
        index: 1.0,
    };
    refused(cross, "index");
}

/// It was no number without a yield stress, so that the power law of the index 1 was refused in
/// unbounded fluid.
#[test]
fn bug_power_laws_had_no_viscosity_at_rest() {
    let at_rest = |index: f64, yield_stress: f64| {
        let law = Law::HerschelBulkley {
            consistency: 2.0,
            index,
            yield_stress,
            regularisation: 1e-3,
        };
        law.unregularised_viscosity(0.0)
    };
    assert_eq!(at_rest(0.5, 0.0), f64::INFINITY);
    assert_eq!(at_rest(1.0, 0.0), 2.0);
    assert_eq!(at_rest(1.5, 0.0), 0.0);
    assert_eq!(at_rest(1.5, 0.1), f64::INFINITY);
}

#[test]
fn laws_whose_stress_decreases_are_refused() {
    // zero < inf with index < 1 thickens: eta = 1 - 0.99 (1 + x^2)^-0.45 increases, which is fine
    let thickens = Law::Carreau {
        zero_shear_viscosity: 0.01,
        infinite_shear_viscosity: 1.0,
        relaxation_time: 1.0,
        index: 0.1,
    };
    thickens.validate().unwrap();
    // zero < inf with index > 1: eta = 1 - 0.99 (1 + x^2) becomes negative
    let negative = Law::Carreau {
        zero_shear_viscosity: 0.01,
        infinite_shear_viscosity: 1.0,
        relaxation_time: 1.0,
        index: 3.0,
    };
    assert!(matches!(
        negative.validate(),
        Err(RheologyError::StressDecreases { .. })
    ));
}

#[test]
fn the_index_1_and_the_time_0_are_newtonian() {
    for law in [
        Law::Newtonian { viscosity: 2.0 },
        Law::Carreau {
            zero_shear_viscosity: 2.0,
            infinite_shear_viscosity: 0.0,
            relaxation_time: 0.0,
            index: 0.5,
        },
        Law::PowerLaw {
            consistency: 2.0,
            index: 1.0,
            regularisation: 1e-6,
        },
    ] {
        assert!(law.constant_viscosity().is_some());
        assert_eq!(law.viscosity(3.0), 2.0);
        // rounding of the logarithm log(9e12) = 30 in the power law: 30 times 1.1e-16
        assert!((law.potential(3.0) - 9.0).abs() < 9.0 * 4e-15);
    }
}
