//! The laws.

use crate::ViscosityLaw;
use crate::error::RheologyError;
use crate::potential::carreau_yasuda_potential;

/// Viscosity laws with the usual names of their parameters.
///
/// Viscosities have the unit of a stress times a time, shear rates that of one over a time. An
/// index below 1 is a fluid that thins, above 1 one that thickens, 1 a Newtonian one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Law {
    /// Constant viscosity.
    Newtonian {
        /// Viscosity.
        viscosity: f64,
    },
    /// Carreau (1972): `inf + (zero - inf) (1 + (t g)^2)^((n - 1) / 2)`.
    Carreau {
        /// Viscosity at rest.
        zero_shear_viscosity: f64,
        /// Viscosity at infinite shear rate; not 0 only where it is known.
        infinite_shear_viscosity: f64,
        /// Time `t`, one over the shear rate at which the viscosity starts to change.
        relaxation_time: f64,
        /// Power-law index `n`.
        index: f64,
    },
    /// Yasuda (1979): `inf + (zero - inf) (1 + (t g)^a)^((n - 1) / a)`.
    CarreauYasuda {
        /// Viscosity at rest.
        zero_shear_viscosity: f64,
        /// Viscosity at infinite shear rate.
        infinite_shear_viscosity: f64,
        /// Time `t`.
        relaxation_time: f64,
        /// Power-law index `n`.
        index: f64,
        /// Exponent `a`; 2 is the law of Carreau, larger values change over a smaller range of
        /// rates.
        transition: f64,
    },
    /// Cross (1965): `inf + (zero - inf) / (1 + (t g)^(1 - n))`.
    Cross {
        /// Viscosity at rest.
        zero_shear_viscosity: f64,
        /// Viscosity at infinite shear rate.
        infinite_shear_viscosity: f64,
        /// Time `t`.
        relaxation_time: f64,
        /// Power-law index `n` of the rates between both viscosities, from 0 to below 1.
        index: f64,
    },
    /// Ostwald and de Waele: `K s^(n - 1)` with `s = sqrt(g^2 + e^2)`.
    PowerLaw {
        /// Consistency `K`, the viscosity at the shear rate 1.
        consistency: f64,
        /// Index `n`.
        index: f64,
        /// Regularisation `e`, a shear rate far below those of the flow.
        regularisation: f64,
    },
    /// Herschel and Bulkley (1926): `yield_stress / s + K s^(n - 1)` with `s = sqrt(g^2 + e^2)`
    /// (regularised as by Bercovier & Engelman 1980).
    HerschelBulkley {
        /// Stress below which the fluid does not flow.
        yield_stress: f64,
        /// Consistency `K`.
        consistency: f64,
        /// Index `n`.
        index: f64,
        /// Regularisation `e`, a shear rate far below those of the flow.
        regularisation: f64,
    },
}

impl Law {
    /// The viscosity of a law whose parameters make it the same at all shear rates.
    ///
    /// ```
    /// use rheology::Law;
    /// let with_index = |index| Law::PowerLaw { consistency: 2.0, index, regularisation: 1e-3 };
    /// assert_eq!(with_index(1.0).constant_viscosity(), Some(2.0));
    /// assert_eq!(with_index(0.9).constant_viscosity(), None);
    /// ```
    pub fn constant_viscosity(&self) -> Option<f64> {
        let is_constant = match (self.plateaus(), self.power()) {
            // the exponent times that of the rate is that of the viscosity at high rates
            (Some(law), _) => {
                law.exponent * law.transition == 0.0 || law.time == 0.0 || law.zero == law.inf
            }
            (_, Some([yield_stress, _, index, _])) => yield_stress == 0.0 && index == 1.0,
            (None, None) => true,
        };
        is_constant.then(|| self.viscosity(0.0))
    }

    /// Checks all parameters.
    ///
    /// # Errors
    ///
    /// [`RheologyError::Parameter`] for the first parameter outside its range, and
    /// [`RheologyError::StressDecreases`] where the stress does not increase with the shear rate.
    pub fn validate(&self) -> Result<(), RheologyError> {
        let positive =
            |parameter, value: f64| require(parameter, value, value > 0.0, "positive and finite");
        let not_negative = |parameter, value: f64| {
            require(
                parameter,
                value,
                value >= 0.0,
                "zero or positive, and finite",
            )
        };
        match *self {
            Self::Newtonian { viscosity } => positive("viscosity", viscosity),
            Self::Carreau {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                relaxation_time,
                index,
            }
            | Self::CarreauYasuda {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                relaxation_time,
                index,
                ..
            }
            | Self::Cross {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                relaxation_time,
                index,
            } => {
                positive("zero_shear_viscosity", zero_shear_viscosity)?;
                not_negative("infinite_shear_viscosity", infinite_shear_viscosity)?;
                not_negative("relaxation_time", relaxation_time)?;
                match *self {
                    Self::Cross { .. } => {
                        let range = "positive and below 1";
                        require("index", index, index > 0.0 && index < 1.0, range)?;
                    }
                    _ => positive("index", index)?,
                }
                if let Self::CarreauYasuda { transition, .. } = *self {
                    positive("transition", transition)?;
                }
                self.require_increasing_stress(relaxation_time)
            }
            Self::PowerLaw { .. } | Self::HerschelBulkley { .. } => {
                let [yield_stress, consistency, index, regularisation] =
                    self.power().unwrap_or_default();
                not_negative("yield_stress", yield_stress)?;
                positive("consistency", consistency)?;
                positive("index", index)?;
                positive("regularisation", regularisation)
            }
        }
    }

    /// The law with all stresses multiplied by a factor.
    ///
    /// A scene in other units of stress has the same flow.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        let mut law = self;
        match &mut law {
            Self::Newtonian { viscosity } => *viscosity *= factor,
            Self::Carreau {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                ..
            }
            | Self::CarreauYasuda {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                ..
            }
            | Self::Cross {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                ..
            } => {
                *zero_shear_viscosity *= factor;
                *infinite_shear_viscosity *= factor;
            }
            Self::PowerLaw { consistency, .. } => *consistency *= factor,
            Self::HerschelBulkley {
                yield_stress,
                consistency,
                ..
            } => {
                *yield_stress *= factor;
                *consistency *= factor;
            }
        }
        law
    }

    /// Whether the law is regular at rest by its regularisation alone.
    pub fn is_regularised(&self) -> bool {
        self.power().is_some() && self.constant_viscosity().is_none()
    }

    /// The same law with its regularisation, if it has one, multiplied by a factor.
    ///
    /// ```
    /// use rheology::Law;
    /// let with = |regularisation| Law::PowerLaw { consistency: 1.0, index: 0.5, regularisation };
    /// assert_eq!(with(1e-3).regularised(10.0), with(1e-2));
    /// ```
    #[must_use]
    pub fn regularised(&self, factor: f64) -> Self {
        let mut law = *self;
        if let Self::PowerLaw { regularisation, .. }
        | Self::HerschelBulkley { regularisation, .. } = &mut law
        {
            *regularisation *= factor;
        }
        law
    }

    /// Refuses a stress that decreases between both plateaus of the viscosity.
    ///
    /// The derivative is looked at in steps of a tenth of a decade of `relaxation_time g` from
    /// 1e-6 to 1e12: it changes over a decade or more.
    fn require_increasing_stress(&self, relaxation_time: f64) -> Result<(), RheologyError> {
        if relaxation_time == 0.0 {
            return Ok(());
        }
        let rates = (-60..=120).map(|k| 10_f64.powf(f64::from(k) / 10.0) / relaxation_time);
        for shear_rate in rates.filter(|rate| rate.is_finite()) {
            if self.tangent_viscosity(shear_rate) <= 0.0 {
                return Err(RheologyError::StressDecreases { shear_rate });
            }
        }
        Ok(())
    }
}

fn require(
    parameter: &'static str,
    value: f64,
    inside: bool,
    range: &'static str,
) -> Result<(), RheologyError> {
    if inside && value.is_finite() {
        Ok(())
    } else {
        Err(RheologyError::Parameter {
            parameter,
            value,
            range,
        })
    }
}

/// Between `zero` and `inf`: the function `(1 + x^a)^((n - 1) / a)` of `x = t g`.
struct Plateaus {
    zero: f64,
    inf: f64,
    time: f64,
    transition: f64,
    exponent: f64,
}

impl Law {
    /// Laws with two plateaus as one: that of Cross is Yasuda's with `a = 1 - n`, and `(1 +
    /// x^a)^-1`.
    fn plateaus(&self) -> Option<Plateaus> {
        let (zero, inf, time, transition, exponent) = match *self {
            Self::Carreau {
                zero_shear_viscosity: zero,
                infinite_shear_viscosity: inf,
                relaxation_time,
                index,
            } => (zero, inf, relaxation_time, 2.0, (index - 1.0) / 2.0),
            Self::CarreauYasuda {
                zero_shear_viscosity: zero,
                infinite_shear_viscosity: inf,
                relaxation_time,
                index,
                transition,
            } => (
                zero,
                inf,
                relaxation_time,
                transition,
                (index - 1.0) / transition,
            ),
            Self::Cross {
                zero_shear_viscosity: zero,
                infinite_shear_viscosity: inf,
                relaxation_time,
                index,
            } => (zero, inf, relaxation_time, 1.0 - index, -1.0),
            _ => return None,
        };
        Some(Plateaus {
            zero,
            inf,
            time,
            transition,
            exponent,
        })
    }

    /// Yield stress, consistency, index and regularisation of the laws without plateaus.
    fn power(&self) -> Option<[f64; 4]> {
        match *self {
            Self::PowerLaw {
                consistency,
                index,
                regularisation,
            } => Some([0.0, consistency, index, regularisation]),
            Self::HerschelBulkley {
                yield_stress,
                consistency,
                index,
                regularisation,
            } => Some([yield_stress, consistency, index, regularisation]),
            _ => None,
        }
    }
}

impl ViscosityLaw for Law {
    fn viscosity(&self, shear_rate: f64) -> f64 {
        if let Self::Newtonian { viscosity } = *self {
            return viscosity;
        }
        if let Some(Plateaus {
            zero,
            inf,
            time,
            transition,
            exponent,
        }) = self.plateaus()
        {
            let x = time * shear_rate;
            return inf + (zero - inf) * (exponent * x.powf(transition).ln_1p()).exp();
        }
        self.power()
            .map_or(f64::NAN, |[yield_stress, consistency, index, e]| {
                let s = shear_rate.hypot(e);
                yield_stress / s + consistency * s.powf(index - 1.0)
            })
    }

    fn derivative(&self, shear_rate: f64) -> f64 {
        if let Some(Plateaus {
            zero,
            inf,
            time,
            transition,
            exponent,
        }) = self.plateaus()
        {
            let x = time * shear_rate;
            let base = x.powf(transition);
            // d/dg (1 + x^a)^b = b a x^a (1 + x^a)^(b - 1) / g; x^a / (1 + x^a) stays finite
            let slope = exponent * transition / (1.0 + base.recip()) / shear_rate;
            return (zero - inf) * slope * (exponent * base.ln_1p()).exp();
        }
        self.power()
            .map_or(0.0, |[yield_stress, consistency, index, e]| {
                let s = shear_rate.hypot(e);
                let direction = shear_rate / s;
                direction
                    * (consistency * (index - 1.0) * s.powf(index - 2.0) - yield_stress / (s * s))
            })
    }

    fn potential(&self, shear_rate: f64) -> f64 {
        if let Self::Newtonian { viscosity } = *self {
            return viscosity * shear_rate * shear_rate / 2.0;
        }
        if let Some(Plateaus {
            zero,
            inf,
            time,
            transition,
            exponent,
        }) = self.plateaus()
        {
            let half_square = shear_rate * shear_rate / 2.0;
            if time == 0.0 {
                return zero * half_square;
            }
            let x = time * shear_rate;
            let between = if transition == 2.0 {
                // ((1 + x^2)^(b + 1) - 1) / (2 (b + 1)), without cancellation for small x
                let power = exponent + 1.0;
                (power * (x * x).ln_1p()).exp_m1() / (2.0 * power)
            } else {
                carreau_yasuda_potential(x, transition, exponent)
            };
            return inf * half_square + (zero - inf) * between / (time * time);
        }
        self.power()
            .map_or(f64::NAN, |[yield_stress, consistency, index, e]| {
                let s = shear_rate.hypot(e);
                // s - e and s^(n + 1) - e^(n + 1) without cancellation: s^2 = e^2 (1 + q)
                let log = (shear_rate / e).powi(2).ln_1p();
                let power = (index + 1.0) / 2.0;
                let viscous = if log.is_finite() {
                    e.powf(index + 1.0) * (power * log).exp_m1()
                } else {
                    s.powf(index + 1.0)
                };
                consistency * viscous / (index + 1.0)
                    + yield_stress * shear_rate * (shear_rate / (s + e))
            })
    }

    fn unregularised_viscosity(&self, shear_rate: f64) -> f64 {
        match self.power() {
            Some([yield_stress, consistency, index, _]) => {
                // Without a yield stress 0 / 0 at rest would hide the viscosity of the power law.
                let of_yield = match yield_stress > 0.0 {
                    true => yield_stress / shear_rate,
                    false => 0.0,
                };
                of_yield + consistency * shear_rate.powf(index - 1.0)
            }
            None => self.viscosity(shear_rate),
        }
    }
}
