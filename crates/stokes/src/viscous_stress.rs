//! Stress of a generalised Newtonian fluid at a known velocity: its matrices, forces and power.

use fem::{StokesMatrices, TaylorHood};
use linalg::{CoupledOperator, Csr, Csr33};
use mesh::TetMesh;
use nalgebra::{Matrix3, Vector3};
use rheology::ViscosityLaw;
use rigid::FluidMatrices;

use crate::StokesError;

/// Degree of the quadrature of the stress.
///
/// Viscosities are no polynomials. Both sides of the momentum equation have the same rule, so that
/// the iteration converges for any; the degree decides the error that remains. It is the rule of
/// the error estimates, whose residuals then contain no error of the quadrature.
pub const DEGREE: usize = 5;

/// Degree for the matrices of the preconditioner alone.
const PRECONDITIONER_DEGREE: usize = 2;

/// The stress `2 η(g) D(u)` with `g = sqrt(2 D:D)` at a velocity of all nodes.
#[derive(Clone, Copy)]
pub struct ViscousStress<'a> {
    pub mesh: &'a TetMesh,
    pub law: &'a dyn ViscosityLaw,
    /// Velocity `u` of each node, background flow included.
    pub velocity: &'a [Vector3<f64>],
}

/// `2 D` of a velocity gradient, and the shear rate `sqrt(2 D:D)`.
#[inline(always)]
pub fn shear(gradient: &Matrix3<f64>) -> (Matrix3<f64>, f64) {
    let twice = gradient + gradient.transpose();
    (twice, (0.5 * twice.dot(&twice)).sqrt())
}

/// `η' / g`, the factor of `(2 D:D(w)) (2 D:D(v))` in the derivative of the stress.
///
/// Multiplied by `g^2` it stays bounded for `g -> 0`, where the product is zero.
#[inline(always)]
pub fn thinning(law: &dyn ViscosityLaw, shear_rate: f64) -> f64 {
    if shear_rate > 0.0 {
        let factor = law.derivative(shear_rate) / shear_rate;
        // For rates whose square underflows the product with both rates is zero.
        if factor.is_finite() { factor } else { 0.0 }
    } else {
        0.0
    }
}

/// Largest factor on a shear rate in a step of [`FrozenViscosity`].
///
/// Where a yield stress makes the exponent small the linear estimate may be off by any factor;
/// beside a sphere in a ball of ten radii the rates of power laws down to an index of 0.3 differ by
/// `10^(2 / 0.3 - 2)` from those of a Newtonian flow, half of which is a factor of 220.
const MAX_RATE_FACTOR: f64 = 1e4;

/// Viscosity of a law for the first guess of its flow, at the shear rate `g` of a Newtonian one.
///
/// Where motions are prescribed the rate `g` is right, far from the bodies the stress `μ g`, which
/// balances the same loads. The viscosity is that at the geometric mean of `g` and of the rate that
/// the law has at this stress, by one step of Newton's method for the logarithm of the rate:
///
/// ```text
/// η(g (μ / η(g))^(1 / (2 m))),   m = d log(η g) / d log g
/// ```
///
/// It is no law, because it has no derivative: a step with it is one of Picard's method.
#[derive(Debug)]
pub struct FrozenViscosity<'a> {
    pub law: &'a dyn ViscosityLaw,
    /// Viscosity `μ` of the Newtonian flow.
    pub newtonian: f64,
}

impl ViscosityLaw for FrozenViscosity<'_> {
    fn viscosity(&self, shear_rate: f64) -> f64 {
        let viscosity = self.law.viscosity(shear_rate);
        let exponent = self.law.tangent_viscosity(shear_rate) / viscosity;
        let factor = (self.newtonian / viscosity).powf(0.5 / exponent);
        if factor.is_nan() {
            return viscosity;
        }
        (self.law).viscosity(shear_rate * factor.clamp(MAX_RATE_FACTOR.recip(), MAX_RATE_FACTOR))
    }

    fn derivative(&self, _: f64) -> f64 {
        0.0
    }

    fn potential(&self, shear_rate: f64) -> f64 {
        0.5 * self.viscosity(shear_rate) * shear_rate * shear_rate
    }
}

impl ViscousStress<'_> {
    /// The scalar matrices `∫ η ∇u:∇v` of this viscosity; `newtonian` are those of viscosity 1.
    ///
    /// The pressure mass matrix has the weight `1 / (2 η)`, by which it approximates the Schur
    /// complement: the form `∫ 2 η D(u):D(v)` of constant viscosity is `η ∫ ∇u:∇v` and `η ∫ (∇·u)
    /// (∇·v)`, so that gradients meet twice the viscosity of the scalar matrix.
    pub fn isotropic_matrices(
        &self,
        space: &TaylorHood,
        newtonian: &StokesMatrices,
    ) -> Result<FluidMatrices, StokesError> {
        let (mesh, velocity) = (self.mesh, self.velocity);
        let viscosity = |gradient: &Matrix3<f64>| self.law.viscosity(shear(gradient).1);
        let stiffness = space.assemble(mesh, DEGREE, |point, matrix: &mut [[f64; 10]; 10]| {
            let weight = point.weight * viscosity(&point.gradient(velocity));
            let gradients = &point.quadratic_gradients();
            for (row, gradient) in matrix.iter_mut().zip(gradients) {
                let weighted = gradient * weight;
                for (entry, gradient) in row.iter_mut().zip(gradients) {
                    *entry += weighted.dot(gradient);
                }
            }
        })?;
        let vertices = space.assemble(
            mesh,
            PRECONDITIONER_DEGREE,
            |point, matrix: &mut [[[f64; 2]; 4]; 4]| {
                let viscosity = viscosity(&point.gradient(velocity));
                point.add(matrix, |v, u| {
                    [
                        viscosity * v.gradient.dot(&u.gradient),
                        v.value * u.value / (2.0 * viscosity),
                    ]
                });
            },
        )?;
        let component = |number: usize| -> Csr { vertices.map(|values| values[number]) };
        Ok(FluidMatrices {
            stiffness,
            divergence: newtonian.divergence.clone(),
            pressure_mass: component(1),
            interpolation: newtonian.interpolation.clone(),
            vertex_stiffness: component(0),
        })
    }

    /// What the derivative of the stress has in addition to the scalar matrix, over all nodes.
    ///
    /// ```text
    /// ∫ η ∇w^T:∇v + c (η' / g) (2 D:D(w)) (2 D:D(v))
    /// ```
    ///
    /// It is the derivative for `c = 1`, a smaller part of the change of the viscosity otherwise.
    pub fn coupling(&self, space: &TaylorHood, c: f64) -> Result<CoupledOperator, StokesError> {
        let blocks: Csr33 = space.assemble(
            self.mesh,
            DEGREE,
            |point, matrix: &mut [[Matrix3<f64>; 10]; 10]| {
                let (twice, rate) = shear(&point.gradient(self.velocity));
                let viscosity = point.weight * self.law.viscosity(rate);
                let thinning = c * point.weight * thinning(self.law, rate);
                let gradients = &point.quadratic_gradients();
                let strained = gradients.map(|gradient| twice * gradient);
                // Block (j, i) is the transpose of block (i, j).
                for i in 0..10 {
                    let (gradient, strain) = (gradients[i] * viscosity, strained[i] * thinning);
                    for j in 0..=i {
                        for r in 0..3 {
                            for s in 0..3 {
                                let value =
                                    gradients[j][r] * gradient[s] + strain[r] * strained[j][s];
                                matrix[i][j][(r, s)] += value;
                                if j < i {
                                    matrix[j][i][(s, r)] += value;
                                }
                            }
                        }
                    }
                }
            },
        )?;
        Ok(CoupledOperator::symmetric(blocks)?)
    }

    /// Forces on the nodes that complete a scalar matrix to this stress.
    ///
    /// ```text
    /// f_i = -∫ (2 η D(u) - η_s ∇u') ∇N_i
    /// ```
    ///
    /// with the viscosity `η_s` that `scalar` has. `disturbance` is `u'`, the velocity without the
    /// background flow, which the scalar matrix multiplies.
    pub fn forces(
        &self,
        scalar: &ViscousStress,
        disturbance: &[Vector3<f64>],
    ) -> Result<Vec<Vector3<f64>>, StokesError> {
        let form = |point: &fem::PointValues<'_>, load: &mut [Vector3<f64>; 10]| {
            let (twice, rate) = shear(&point.gradient(self.velocity));
            let (_, rate_of_scalar) = shear(&point.gradient(scalar.velocity));
            let missing = twice * self.law.viscosity(rate)
                - point.gradient(disturbance) * scalar.law.viscosity(rate_of_scalar);
            point.add_load(load, |v| -(missing * v.gradient));
        };
        Ok(fem::assemble_load(self.mesh, DEGREE, form)?)
    }

    /// Stiffness of the pressure in narrow gaps and channels with this permeability per cell, at
    /// viscosity 1.
    pub fn pressure_stiffness(
        &self,
        space: &TaylorHood,
        permeability: &[f64],
    ) -> Result<Csr, StokesError> {
        let form = |point: &fem::PointValues<'_>, matrix: &mut [[f64; 4]; 4]| {
            let (_, rate) = shear(&point.gradient(self.velocity));
            let mobility = permeability[point.cell] / self.law.viscosity(rate);
            point.add(matrix, |q, p| mobility * q.gradient.dot(&p.gradient));
        };
        Ok(space.assemble(self.mesh, PRECONDITIONER_DEGREE, form)?)
    }

    /// Mean viscosity `∫ η g^2 / ∫ g^2`; the viscosity at rest where nothing moves.
    pub fn mean_viscosity(&self) -> Result<f64, StokesError> {
        let [weighted, weight] = fem::integrate(self.mesh, PRECONDITIONER_DEGREE, |point| {
            let (_, rate) = shear(&point.gradient(self.velocity));
            [self.law.viscosity(rate) * rate * rate, rate * rate]
        })?;
        Ok(if weight > 0.0 {
            weighted / weight
        } else {
            self.law.viscosity(0.0)
        })
    }

    /// Derivatives of `∫ W(g) - ∫ p ∇·u` along `change` at this velocity and at its end.
    ///
    /// `W` is the potential of the law, whose derivative is the stress.
    pub fn slopes(
        &self,
        change: &[Vector3<f64>],
        pressure: &[f64],
        step: f64,
    ) -> Result<[f64; 2], StokesError> {
        Ok(fem::integrate(self.mesh, DEGREE, |point| {
            let (start, change) = (point.gradient(self.velocity), point.gradient(change));
            let (twice_change, _) = shear(&change);
            let source = point.value(pressure) * change.trace();
            [0.0, step].map(|step| {
                let (twice, rate) = shear(&(start + change * step));
                0.5 * self.law.viscosity(rate) * twice.dot(&twice_change) - source
            })
        })?)
    }

    /// Change of `∫ W(g) - ∫ p ∇·u` over `step` times `change`.
    pub fn change_of_energy(
        &self,
        change: &[Vector3<f64>],
        pressure: &[f64],
        step: f64,
    ) -> Result<f64, StokesError> {
        Ok(fem::integrate(self.mesh, DEGREE, |point| {
            let (start, change) = (point.gradient(self.velocity), point.gradient(change));
            let [before, after] = [start, start + change * step]
                .map(|gradient| self.law.potential(shear(&gradient).1));
            after - before - step * point.value(pressure) * change.trace()
        })?)
    }

    /// Root of the mean square of the shear rate, weighted by its square.
    pub fn root_mean_square_rate(&self) -> Result<f64, StokesError> {
        let [weighted, weight] = fem::integrate(self.mesh, PRECONDITIONER_DEGREE, |point| {
            let (_, rate) = shear(&point.gradient(self.velocity));
            let square = rate * rate;
            [square * square, square]
        })?;
        Ok(if weight > 0.0 {
            (weighted / weight).sqrt()
        } else {
            0.0
        })
    }

    /// Mean of `|d log η / d log g|`, weighted by the dissipation: zero for a Newtonian fluid.
    pub fn mean_exponent(&self) -> Result<f64, StokesError> {
        let [weighted, weight] = fem::integrate(self.mesh, PRECONDITIONER_DEGREE, |point| {
            let (_, rate) = shear(&point.gradient(self.velocity));
            let square = rate * rate;
            let slope = thinning(self.law, rate).abs() * square * square;
            [slope, self.law.viscosity(rate) * square]
        })?;
        Ok(if weight > 0.0 { weighted / weight } else { 0.0 })
    }

    /// Dissipation `∫ η g^2` in the part of the fluid that the mesh covers.
    pub fn dissipation(&self) -> Result<f64, StokesError> {
        self.power_of(&|rate| self.law.viscosity(rate))
    }

    /// The same with another viscosity `c(g)`.
    pub fn power_of(&self, coefficient: &(dyn Fn(f64) -> f64 + Sync)) -> Result<f64, StokesError> {
        Ok(fem::integrate(self.mesh, DEGREE, |point| {
            let (_, rate) = shear(&point.gradient(self.velocity));
            coefficient(rate) * rate * rate
        })?)
    }

    /// Power of the stress in the motion `test` of the boundary, `∫ 2 η D(u):D(v) - ∫ p ∇·v`.
    pub fn power(&self, pressure: &[f64], test: &[Vector3<f64>]) -> Result<f64, StokesError> {
        Ok(self.slopes(test, pressure, 0.0)?[0])
    }

    /// Force of a body on the fluid by the integral of the stress over its facets.
    ///
    /// `pressure` is without that of the background flow, which has no force.
    pub fn force(&self, tag: u16, pressure: &[f64]) -> Result<Vector3<f64>, StokesError> {
        Ok(fem::integrate_facets(self.mesh, tag, DEGREE, |facet| {
            let (twice, rate) = shear(&facet.point.gradient(self.velocity));
            let traction = twice * facet.normal * self.law.viscosity(rate);
            traction - facet.normal * facet.point.value(pressure)
        })?)
    }
}

#[cfg(test)]
mod tests {
    use linalg::LinearOperator;
    use mesh::LinearTets;
    use rheology::Law;

    use super::*;

    fn laws() -> [Law; 6] {
        [
            Law::Newtonian { viscosity: 2.0 },
            Law::Carreau {
                zero_shear_viscosity: 1.0,
                infinite_shear_viscosity: 0.1,
                relaxation_time: 2.0,
                index: 0.4,
            },
            Law::CarreauYasuda {
                zero_shear_viscosity: 1.0,
                infinite_shear_viscosity: 0.0,
                relaxation_time: 2.0,
                index: 0.4,
                transition: 1.2,
            },
            Law::Cross {
                zero_shear_viscosity: 1.0,
                infinite_shear_viscosity: 0.1,
                relaxation_time: 2.0,
                index: 0.3,
            },
            Law::PowerLaw {
                consistency: 1.5,
                index: 1.6,
                regularisation: 1e-2,
            },
            Law::HerschelBulkley {
                yield_stress: 0.3,
                consistency: 1.0,
                index: 0.6,
                regularisation: 0.1,
            },
        ]
    }

    /// Scalar matrix and coupling together are the derivative of the stress, whose forces are the
    /// derivative of the energy.
    #[test]
    fn matrices_are_derivatives_of_the_stress_and_forces_of_the_energy() {
        let mesh = &TetMesh::straight(LinearTets::cube(1)).unwrap();
        let space = TaylorHood::new(mesh).unwrap();
        let newtonian = space.matrices(mesh).unwrap();
        let field = |seed: f64| -> Vec<Vector3<f64>> {
            let value = |x: &Vector3<f64>| {
                let phase = x.x + 2.3 * x.y - 1.7 * x.z + seed;
                Vector3::new(
                    phase.sin(),
                    (1.3 * phase).cos(),
                    (0.7 * phase + x.x * x.z).sin(),
                )
            };
            mesh.points().iter().map(value).collect()
        };
        let (velocity, change) = (field(0.0), field(1.0));
        let moved = |step: f64| -> Vec<Vector3<f64>> {
            velocity
                .iter()
                .zip(&change)
                .map(|(u, w)| u + step * w)
                .collect()
        };
        let no_pressure = vec![0.0; mesh.n_vertices()];
        for law in laws() {
            let at = ViscousStress {
                mesh,
                law: &law,
                velocity: &velocity,
            };
            let forces = |velocity: &[Vector3<f64>]| {
                let stress = ViscousStress {
                    mesh,
                    law: &law,
                    velocity,
                };
                stress.forces_of(&|rate| law.viscosity(rate)).unwrap()
            };
            let matrices = at.isotropic_matrices(&space, &newtonian).unwrap();
            let coupling = at.coupling(&space, 1.0).unwrap();
            let measured = CoupledOperator::new(coupling.matrix().clone()).unwrap();
            assert!(measured.is_symmetric());
            let flat: Vec<f64> = change.iter().flatten().copied().collect();
            let mut product = vec![0.0; flat.len()];
            coupling.apply(&flat, &mut product);
            // The error of the central difference is of the order of the square of the step.
            let step = 1e-4;
            let [before, after] = [-step, step].map(moved);
            let pairs = forces(&after).into_iter().zip(forces(&before));
            let mut largest = 0.0_f64;
            for (node, ((after, before), coupled)) in
                pairs.zip(product.as_chunks::<3>().0).enumerate()
            {
                let row = matrices.stiffness.outer_view(node).unwrap();
                let scalar: Vector3<f64> = row.iter().map(|(j, k)| *k * change[j]).sum();
                let derivative = scalar + Vector3::from(*coupled);
                let difference = (before - after) / (2.0 * step);
                largest = largest.max((derivative - difference).norm());
            }
            assert!(largest < 1e-6, "{law:?}: {largest:e}");
            // the energy, and its slope at both ends
            let change_of_energy =
                |step: f64| at.change_of_energy(&change, &no_pressure, step).unwrap();
            let difference = (change_of_energy(step) - change_of_energy(-step)) / (2.0 * step);
            let [slope, _] = at.slopes(&change, &no_pressure, 1.0).unwrap();
            assert!(
                (difference - slope).abs() < 1e-6,
                "{law:?}: {difference} {slope}"
            );
            let on_nodes = forces(&velocity);
            let power: f64 = on_nodes.iter().zip(&change).map(|(f, w)| -f.dot(w)).sum();
            assert!(
                (power - slope).abs() < 1e-12 * power.abs().max(1.0),
                "{law:?}"
            );
            // convex: it lies above its tangent, and the slope increases
            assert!(change_of_energy(1.0) > slope, "{law:?}");
            let [start, end] = at.slopes(&change, &no_pressure, 1.0).unwrap();
            assert!(end > start, "{law:?}");
        }
    }
}
