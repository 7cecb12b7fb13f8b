//! Potentials without a closed form.

/// Points and weights of Gauss and Legendre with 8 points on `[0, 1]`, the first half.
///
/// Abramowitz & Stegun (1964), table 25.4.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_27),
];

/// Integral of `s (1 + s^a)^b` over `s` from 0 to `x`.
///
/// The substitution `s = exp(y)` makes the integrand `exp(2 y) (1 + exp(a y))^b`, which is analytic
/// in a strip of half-width `pi / a` around the axis. It falls at least like `exp((2 + a b) y)`
/// towards small `y`, which says where the tail is below rounding. Panels of 8 points are at most 1
/// long and at most half as long as the half-width: their error is below `8^-16`.
pub(crate) fn carreau_yasuda_potential(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let small = x.powf(a);
    if small < 1e-8 {
        // two terms of the binomial series; the third is below 1e-16
        return x * x * (0.5 + b * small / (a + 2.0));
    }
    let top = x.ln();
    let integrand = |y: f64| (2.0 * y + b * (a * y).exp().ln_1p()).exp();
    let panel = (std::f64::consts::PI / (2.0 * a)).min(1.0);
    let depth = -f64::EPSILON.ln() / (2.0 + (a * b).min(0.0));
    let panels = (depth / panel).ceil() as usize;
    let mut sum = 0.0;
    for k in 0..panels {
        let middle = top - panel * (k as f64 + 0.5);
        for (point, weight) in GAUSS {
            let offset = panel / 2.0 * point;
            sum += panel / 2.0 * weight * (integrand(middle - offset) + integrand(middle + offset));
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrature_and_closed_form_agree_for_the_law_of_carreau() {
        for index in [0.1, 0.5, 1.5, 3.0] {
            let b: f64 = (index - 1.0) / 2.0;
            for x in [1e-6_f64, 1e-3, 0.1, 1.0, 30.0, 1e4] {
                let exact = ((b + 1.0) * (x * x).ln_1p()).exp_m1() / (2.0 * (b + 1.0));
                let error = carreau_yasuda_potential(x, 2.0, b) / exact - 1.0;
                // 50 panels with an error of 8^-16 = 4e-15 of their own part
                assert!(error.abs() < 1e-14, "index {index}, x = {x}: {error:e}");
            }
        }
    }

    /// `a = 1, b = -1`: the integral of `s / (1 + s)` is `x - log(1 + x)`.
    #[test]
    fn quadrature_and_logarithm_agree_for_the_law_of_cross() {
        for x in [0.5, 1.0, 7.0, 1e3] {
            let error = carreau_yasuda_potential(x, 1.0, -1.0) / (x - f64::ln_1p(x)) - 1.0;
            assert!(error.abs() < 1e-13, "x = {x}: {error:e}");
        }
    }
}
