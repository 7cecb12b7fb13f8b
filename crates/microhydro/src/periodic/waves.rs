//! The part of Ewald's sums over waves: smooth flows of all sources, by their Fourier series.

use std::f64::consts::PI;

use nalgebra::{Complex, Vector3, Vector6};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::source::{Source, six_of};

/// Waves that are treated together by vector instructions; columns are padded to multiples of them.
const LANES: usize = 8;

/// The waves of a box up to a wave number: one of each pair of opposite wave vectors.
pub(super) struct Waves {
    size: Vector3<f64>,
    /// Largest number of a wave along each axis.
    most: [i32; 3],
    columns: Vec<Column>,
}

/// Waves with the same numbers along x and y.
struct Column {
    number: [i32; 2],
    k: [f64; 2],
    /// Number of the first one along z.
    first: i32,
    /// For each wave `k_z`, `k²` and `2 H(k)/(k² V)`, which is zero where the column is padded.
    along: Vec<f64>,
    squared: Vec<f64>,
    weight: Vec<f64>,
}

/// The waves at a place: `exp(2πi m x/L)` for `m` from 0, and along z for all `m` from the smallest
/// one.
pub(super) struct Phases {
    across: [Vec<Complex<f64>>; 2],
    along: [Vec<f64>; 2],
}

/// Flows of the waves of one column: real and imaginary parts of three components.
pub(super) struct Flow(Vec<f64>);

/// A source at a place with these phases, of a sphere with the square of its radius over six.
pub(super) struct Placed<'a> {
    pub phases: &'a Phases,
    pub size: f64,
    pub source: Source,
}

/// Amplitudes of a source on a column, as functions of `k_z`, `k²` and `c = 1 - a²k²/6`:
/// `c F - k² L + i (t + t' k_z + c (s + s' k_z))`.
struct Amplitude {
    force: [f64; 3],
    dipole: [f64; 3],
    torque: [[f64; 3]; 2],
    stresslet: [[f64; 3]; 2],
}

impl Waves {
    /// Numbers of waves along the axes up to this wave number.
    pub fn most(size: &Vector3<f64>, largest: f64) -> [f64; 3] {
        [0, 1, 2].map(|axis| (largest * size[axis] / (2.0 * PI)).floor())
    }

    /// The waves up to a wave number for Hasimoto's splitting.
    pub fn new(size: &Vector3<f64>, splitting: f64, largest: f64) -> Self {
        let most = Self::most(size, largest).map(|m| m as i32);
        let unit = size.map(|edge| 2.0 * PI / edge);
        let [x, y, z] = most;
        let numbers = (0..=x).flat_map(|i| (-y..=y).map(move |j| [i, j]));
        let column = |number: [i32; 2]| {
            let k = [0, 1].map(|axis| f64::from(number[axis]) * unit[axis]);
            let lowest = match number.cmp(&[0, 0]) {
                std::cmp::Ordering::Less => return None,
                std::cmp::Ordering::Equal => 1,
                std::cmp::Ordering::Greater => -z,
            };
            let squares = |m: i32| k[0] * k[0] + k[1] * k[1] + (f64::from(m) * unit.z).powi(2);
            let mut inside = (lowest..=z).filter(|&m| squares(m) <= largest * largest);
            let first = inside.next()?;
            let last = inside.next_back().unwrap_or(first);
            let count = (last - first + 1) as usize;
            let numbers = (first..).take(count.next_multiple_of(LANES));
            let squared: Vec<f64> = numbers.clone().map(squares).collect();
            let weight = squared.iter().enumerate().map(|(entry, squared)| {
                let part = squared / (4.0 * splitting * splitting);
                match entry < count {
                    true => 2.0 * (1.0 + part) * (-part).exp() / (squared * size.product()),
                    false => 0.0,
                }
            });
            Some(Column {
                number,
                k,
                first,
                along: numbers.map(|m| f64::from(m) * unit.z).collect(),
                weight: weight.collect(),
                squared,
            })
        };
        Self {
            size: *size,
            most,
            columns: numbers.filter_map(column).collect(),
        }
    }

    /// The waves at a place.
    pub fn phases(&self, x: &Vector3<f64>) -> Phases {
        let angle = |axis: usize| 2.0 * PI * (x[axis] / self.size[axis]).fract();
        let wave = |axis: usize, m: i32| Complex::cis(f64::from(m) * angle(axis));
        let [_, _, z] = self.most;
        let along: Vec<_> = (-z..=z + LANES as i32).map(|m| wave(2, m)).collect();
        Phases {
            across: [0, 1].map(|axis| (0..=self.most[axis]).map(|m| wave(axis, m)).collect()),
            along: [
                along.iter().map(|p| p.re).collect(),
                along.iter().map(|p| p.im).collect(),
            ],
        }
    }

    /// Flows of the sources, with their weights.
    pub fn flows(&self, sources: &[Placed]) -> Vec<Flow> {
        let columns = self.columns.par_iter();
        columns.map(|column| self.flow(column, sources)).collect()
    }

    fn flow(&self, column: &Column, sources: &[Placed]) -> Flow {
        let count = column.along.len();
        let mut flow = vec![0.0; 6 * count];
        Arch::new().dispatch(OfSources {
            waves: self,
            column,
            sources,
            sums: &mut flow,
        });
        // The solenoidal part times the weight.
        for entry in 0..count {
            let k = [column.k[0], column.k[1], column.along[entry]];
            for part in 0..2 {
                let place = |axis: usize| (3 * part + axis) * count + entry;
                let sum: f64 = (0..3).map(|axis| k[axis] * flow[place(axis)]).sum();
                let along = sum / column.squared[entry];
                for axis in 0..3 {
                    let value = &mut flow[place(axis)];
                    *value = (*value - k[axis] * along) * column.weight[entry];
                }
            }
        }
        Flow(flow)
    }

    /// Velocity and angular velocity of a sphere at a place with these phases, with the square of
    /// its radius over six: the sum of `(1 - a²k²/6) Re u` and of `Re(i k × u)/2` for all waves.
    pub fn at(&self, phases: &Phases, size: f64, flows: &[Flow]) -> Vector6<f64> {
        let lanes = Arch::new().dispatch(AtPlace {
            waves: self,
            phases,
            size,
            flows,
        });
        let [ux, uy, uz, wx, wy, wz] = lanes.map(|lane| lane.iter().sum::<f64>());
        six_of(Vector3::new(ux, uy, uz), Vector3::new(wx, wy, wz) * -0.5)
    }

    /// The phases of the waves of a column along z.
    fn of_column<'p>(&self, phases: &'p Phases, column: &Column) -> [&'p [f64]; 2] {
        let first = (column.first + self.most[2]) as usize;
        let part = |numbers: &'p Vec<f64>| &numbers[first..first + column.along.len()];
        phases.along.each_ref().map(part)
    }
}

/// The sums of sources on a column, with the vector instructions of the processor.
struct OfSources<'a> {
    waves: &'a Waves,
    column: &'a Column,
    sources: &'a [Placed<'a>],
    sums: &'a mut [f64],
}

impl WithSimd for OfSources<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for placed in self.sources {
            let amplitude = Amplitude::new(&placed.source, self.column.k);
            let base = placed.phases.of_column(self.column).conj();
            let along = self.waves.of_column(placed.phases, self.column);
            amplitude.add(base, along, placed.size, self.column, self.sums);
        }
    }
}

/// The sums of all waves at a place, in lanes.
struct AtPlace<'a> {
    waves: &'a Waves,
    phases: &'a Phases,
    size: f64,
    flows: &'a [Flow],
}

impl WithSimd for AtPlace<'_> {
    type Output = [[f64; LANES]; 6];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let mut lanes = [[0.0; LANES]; 6];
        for (column, flow) in self.waves.columns.iter().zip(self.flows) {
            let base = self.phases.of_column(column);
            let along = self.waves.of_column(self.phases, column);
            column.sum(base, along, self.size, flow, &mut lanes);
        }
        lanes
    }
}

impl Phases {
    /// The phase of a column along x and y.
    fn of_column(&self, column: &Column) -> Complex<f64> {
        let factor = |axis: usize| {
            let number = column.number[axis];
            let found = self.across[axis][number.unsigned_abs() as usize];
            if number < 0 { found.conj() } else { found }
        };
        factor(0) * factor(1)
    }
}

impl Amplitude {
    fn new(source: &Source, [x, y]: [f64; 2]) -> Self {
        let [t, f] = [source.torque * 0.5, source.force];
        let mut amplitude = Self {
            force: f.into(),
            dipole: [0.0; 3],
            torque: [[y * t.z, -x * t.z, x * t.y - y * t.x], [-t.y, t.x, 0.0]],
            stresslet: [[0.0; 3]; 2],
        };
        if let Some((dipole, s)) = &source.slip {
            amplitude.dipole = (*dipole).into();
            amplitude.stresslet = [
                (s.column(0) * x + s.column(1) * y).into(),
                s.column(2).into(),
            ];
        }
        amplitude
    }

    /// Adds the source to the sums of a column.
    #[inline(always)]
    fn add(
        &self,
        base: Complex<f64>,
        [re, im]: [&[f64]; 2],
        size: f64,
        column: &Column,
        sums: &mut [f64],
    ) {
        let count = column.along.len();
        let (re, im) = (&re[..count], &im[..count]);
        let (along, squared) = (&column.along[..count], &column.squared[..count]);
        for axis in 0..3 {
            let (real, imaginary) = sums.split_at_mut(3 * count);
            let real = &mut real[axis * count..][..count];
            let imaginary = &mut imaginary[axis * count..][..count];
            let (force, dipole) = (self.force[axis], self.dipole[axis]);
            let [torque, slope] = self.torque.map(|t| t[axis]);
            let [stresslet, twist] = self.stresslet.map(|s| s[axis]);
            for k in 0..count {
                // The conjugate phase.
                let phase = (
                    base.re * re[k] + base.im * im[k],
                    base.im * re[k] - base.re * im[k],
                );
                let reduction = 1.0 - size * squared[k];
                let even = reduction * force - squared[k] * dipole;
                let odd = torque + slope * along[k] + reduction * (stresslet + twist * along[k]);
                real[k] += phase.0 * even - phase.1 * odd;
                imaginary[k] += phase.0 * odd + phase.1 * even;
            }
        }
    }
}

impl Column {
    /// Adds the velocities `c Re u` and `k × Im u` of the waves to the sums.
    #[inline(always)]
    fn sum(
        &self,
        base: Complex<f64>,
        [re, im]: [&[f64]; 2],
        size: f64,
        Flow(flow): &Flow,
        sums: &mut [[f64; LANES]; 6],
    ) {
        let count = self.along.len();
        let part = |number: usize| lanes(&flow[number * count..][..count]);
        let parts = [part(0), part(1), part(2), part(3), part(4), part(5)];
        let (re, im) = (lanes(&re[..count]), lanes(&im[..count]));
        let (along, squared) = (lanes(&self.along), lanes(&self.squared));
        let [x, y] = self.k;
        // Plain loops over lanes, which the compiler turns into vector instructions.
        for group in 0..along.len() {
            let (re, im) = (&re[group], &im[group]);
            let (z, squared) = (&along[group], &squared[group]);
            let mut imaginary = [[0.0; LANES]; 3];
            for axis in 0..3 {
                let (of_re, of_im) = (&parts[axis][group], &parts[axis + 3][group]);
                for lane in 0..LANES {
                    let phase_re = base.re * re[lane] - base.im * im[lane];
                    let phase_im = base.re * im[lane] + base.im * re[lane];
                    let real = phase_re * of_re[lane] - phase_im * of_im[lane];
                    imaginary[axis][lane] = phase_re * of_im[lane] + phase_im * of_re[lane];
                    sums[axis][lane] += (1.0 - size * squared[lane]) * real;
                }
            }
            let [a, b, c] = &imaginary;
            for lane in 0..LANES {
                sums[3][lane] += y * c[lane] - z[lane] * b[lane];
                sums[4][lane] += z[lane] * a[lane] - x * c[lane];
                sums[5][lane] += x * b[lane] - y * a[lane];
            }
        }
    }
}

/// A padded list in groups of lanes.
#[inline(always)]
fn lanes(list: &[f64]) -> &[[f64; LANES]] {
    list.as_chunks().0
}
