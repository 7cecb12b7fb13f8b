//! What integrals sum and matrices store: numbers, vectors, matrices, and values at nodes.

use mesh::Vec3;
use nalgebra::Matrix3;

mod sealed {
    /// Only this crate implements [`Quantity`](super::Quantity).
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for mesh::Vec3 {}
    impl Sealed for nalgebra::Matrix3<f64> {}
    impl<const N: usize> Sealed for [f64; N] {}
    impl<const M: usize, const N: usize> Sealed for [[f64; M]; N] {}
}

/// A quantity that integrals sum: a number, a vector or a matrix.
///
/// `f64`, [`Vec3`] and `Matrix3<f64>`, or arrays `[f64; N]` and `[[f64; M]; N]` (`N` rows) for
/// another number of components.
pub trait Quantity: Copy + Send + Sync + sealed::Sealed {
    /// Entry of a sparse matrix of these quantities: `f64`, `[f64; N]`, or `[[f64; M]; N]` by rows.
    type Stored: Copy + Send + Sync;

    /// Zero.
    fn zero() -> Self;

    /// `self <- self + factor value`.
    fn add_scaled(&mut self, factor: f64, value: &Self);

    /// Sum of the squares of all components.
    fn norm_squared(&self) -> f64;

    /// Zero as an entry of a matrix.
    fn stored_zero() -> Self::Stored;

    /// `entry <- entry + self`.
    fn add_to(&self, entry: &mut Self::Stored);
}

impl Quantity for f64 {
    type Stored = f64;

    fn zero() -> Self {
        0.0
    }

    #[inline]
    fn add_scaled(&mut self, factor: f64, value: &Self) {
        *self += factor * value;
    }

    fn norm_squared(&self) -> f64 {
        self * self
    }

    fn stored_zero() -> f64 {
        0.0
    }

    fn add_to(&self, entry: &mut f64) {
        *entry += self;
    }
}

impl Quantity for Vec3 {
    type Stored = [f64; 3];

    fn zero() -> Self {
        Self::zeros()
    }

    #[inline]
    fn add_scaled(&mut self, factor: f64, value: &Self) {
        add_scaled_components(self.as_mut_slice(), factor, value.as_slice());
    }

    fn norm_squared(&self) -> f64 {
        nalgebra::Matrix::norm_squared(self)
    }

    fn stored_zero() -> [f64; 3] {
        [0.0; 3]
    }

    fn add_to(&self, entry: &mut [f64; 3]) {
        for c in 0..3 {
            entry[c] += self[c];
        }
    }
}

impl Quantity for Matrix3<f64> {
    type Stored = [[f64; 3]; 3];

    fn zero() -> Self {
        Self::zeros()
    }

    #[inline]
    fn add_scaled(&mut self, factor: f64, value: &Self) {
        add_scaled_components(self.as_mut_slice(), factor, value.as_slice());
    }

    fn norm_squared(&self) -> f64 {
        nalgebra::Matrix::norm_squared(self)
    }

    fn stored_zero() -> [[f64; 3]; 3] {
        [[0.0; 3]; 3]
    }

    fn add_to(&self, entry: &mut [[f64; 3]; 3]) {
        for c in 0..3 {
            for d in 0..3 {
                entry[c][d] += self[(c, d)];
            }
        }
    }
}

impl<const N: usize> Quantity for [f64; N] {
    type Stored = Self;

    fn zero() -> Self {
        [0.0; N]
    }

    #[inline]
    fn add_scaled(&mut self, factor: f64, value: &Self) {
        add_scaled_components(self, factor, value);
    }

    fn norm_squared(&self) -> f64 {
        self.iter().map(|x| x * x).sum()
    }

    fn stored_zero() -> Self {
        [0.0; N]
    }

    fn add_to(&self, entry: &mut Self) {
        entry.add_scaled(1.0, self);
    }
}

impl<const M: usize, const N: usize> Quantity for [[f64; M]; N] {
    type Stored = Self;

    fn zero() -> Self {
        [[0.0; M]; N]
    }

    #[inline]
    fn add_scaled(&mut self, factor: f64, value: &Self) {
        for c in 0..N {
            self[c].add_scaled(factor, &value[c]);
        }
    }

    fn norm_squared(&self) -> f64 {
        self.iter().map(Quantity::norm_squared).sum()
    }

    fn stored_zero() -> Self {
        [[0.0; M]; N]
    }

    fn add_to(&self, entry: &mut Self) {
        entry.add_scaled(1.0, self);
    }
}

/// `sum <- sum + factor values`, in place: products of matrices by reference are not inlined.
#[inline(always)]
fn add_scaled_components(sum: &mut [f64], factor: f64, values: &[f64]) {
    for (sum, value) in sum.iter_mut().zip(values) {
        *sum += factor * value;
    }
}

/// Whether all components are finite.
pub(crate) fn is_finite<'a, T: Quantity + 'a>(values: impl IntoIterator<Item = &'a T>) -> bool {
    // Zero times a number that is not finite is NaN.
    let mut zero = T::zero();
    for value in values {
        zero.add_scaled(0.0, value);
    }
    zero.norm_squared() == 0.0
}

/// A nodal value of a field: a number, a 3-vector, or `[f64; N]` for `N` components.
pub trait Nodal: Quantity {
    /// Gradient `∂u_c/∂x_k` of such a field: [`Vec3`], `Matrix3<f64>` or `[[f64; 3]; N]`.
    type Gradient: Quantity;

    /// Number of components.
    const COMPONENTS: usize;

    /// Value with the components that `component` returns.
    fn from_components(component: impl FnMut(usize) -> f64) -> Self;

    /// The components.
    fn components(&self) -> &[f64];

    /// `sum <- sum + self ⊗ gradient`: the contribution of a shape function with this gradient.
    fn add_gradient(&self, gradient: &Vec3, sum: &mut Self::Gradient);
}

impl Nodal for f64 {
    type Gradient = Vec3;
    const COMPONENTS: usize = 1;

    fn from_components(mut component: impl FnMut(usize) -> f64) -> Self {
        component(0)
    }

    fn components(&self) -> &[f64] {
        std::slice::from_ref(self)
    }

    fn add_gradient(&self, gradient: &Vec3, sum: &mut Vec3) {
        *sum += gradient * *self;
    }
}

impl Nodal for Vec3 {
    type Gradient = Matrix3<f64>;
    const COMPONENTS: usize = 3;

    fn from_components(mut component: impl FnMut(usize) -> f64) -> Self {
        Self::from_fn(|c, _| component(c))
    }

    fn components(&self) -> &[f64] {
        self.as_slice()
    }

    fn add_gradient(&self, gradient: &Vec3, sum: &mut Matrix3<f64>) {
        *sum += self * gradient.transpose();
    }
}

impl<const N: usize> Nodal for [f64; N] {
    type Gradient = [[f64; 3]; N];
    const COMPONENTS: usize = N;

    fn from_components(component: impl FnMut(usize) -> f64) -> Self {
        std::array::from_fn(component)
    }

    fn components(&self) -> &[f64] {
        self
    }

    fn add_gradient(&self, gradient: &Vec3, sum: &mut [[f64; 3]; N]) {
        for c in 0..N {
            for k in 0..3 {
                sum[c][k] += self[c] * gradient[k];
            }
        }
    }
}

/// Gradient in a cell with these nodes and these gradients of the shape functions.
pub(crate) fn gradient_in_cell<T: Nodal>(
    nodes: &[u32],
    field: &[T],
    gradients: &[Vec3],
) -> T::Gradient {
    let mut sum = T::Gradient::zero();
    for (&node, gradient) in nodes.iter().zip(gradients) {
        field[node as usize].add_gradient(gradient, &mut sum);
    }
    sum
}
