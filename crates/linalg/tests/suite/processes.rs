//! Vectors that are divided between processes, which are threads here.

use std::sync::{Barrier, Mutex};
use std::thread;

use linalg::{Identity, KrylovParams, LinalgError, LinearOperator, SumOverProcesses, cg, fgmres};

const N: usize = 60;
const PROCESSES: usize = 3;

/// What the processes exchange: a vector, and the terms of sums.
struct Exchange {
    vector: Mutex<Vec<f64>>,
    terms: Mutex<Vec<Vec<f64>>>,
    barrier: Barrier,
}

/// Rows of the matrix with 3 on the diagonal and -1 beside it: every third one for a process.
///
/// Entries of other processes are zero.
struct Rows<'a> {
    process: usize,
    weights: Vec<f32>,
    exchange: &'a Exchange,
    sum: Box<SumOverProcesses<'a>>,
}

impl<'a> Rows<'a> {
    fn new(process: usize, exchange: &'a Exchange) -> Self {
        let sum = move |values: &mut [f64]| {
            exchange.terms.lock().expect("no panic")[process] = values.to_vec();
            exchange.barrier.wait();
            values.fill(0.0);
            for terms in exchange.terms.lock().expect("no panic").iter() {
                (values.iter_mut().zip(terms)).for_each(|(sum, term)| *sum += term);
            }
            exchange.barrier.wait();
        };
        Self {
            process,
            weights: weights(),
            exchange,
            sum: Box::new(sum),
        }
    }

    fn owns(&self, row: usize) -> bool {
        row % PROCESSES == self.process
    }
}

fn weights() -> Vec<f32> {
    (0..N).map(|i| 1.0 / (1 + i % 4) as f32).collect()
}

fn product(x: &[f64], row: usize) -> f64 {
    let at = |k: usize| x.get(k).copied().unwrap_or(0.0);
    3.0 * x[row] - at(row.wrapping_sub(1)) - at(row + 1)
}

impl LinearOperator for Rows<'_> {
    fn rows(&self) -> usize {
        N
    }

    fn cols(&self) -> usize {
        N
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        {
            let mut all = self.exchange.vector.lock().expect("no panic");
            (0..N)
                .filter(|&row| self.owns(row))
                .for_each(|row| all[row] = x[row]);
        }
        self.exchange.barrier.wait();
        let all = self.exchange.vector.lock().expect("no panic").clone();
        self.exchange.barrier.wait();
        for (row, y) in y.iter_mut().enumerate() {
            *y = if self.owns(row) {
                product(&all, row)
            } else {
                0.0
            };
        }
    }

    fn residual_weights(&self) -> Option<&[f32]> {
        Some(&self.weights)
    }

    fn sum_over_processes(&self) -> Option<&SumOverProcesses<'_>> {
        Some(&*self.sum)
    }

    fn is_symmetric(&self) -> bool {
        true
    }
}

/// The same matrix on one process.
struct Whole(Vec<f32>);

impl LinearOperator for Whole {
    fn rows(&self) -> usize {
        N
    }

    fn cols(&self) -> usize {
        N
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        (y.iter_mut().enumerate()).for_each(|(row, y)| *y = product(x, row));
    }

    fn residual_weights(&self) -> Option<&[f32]> {
        Some(&self.0)
    }
}

fn exchange() -> Exchange {
    Exchange {
        vector: Mutex::new(vec![0.0; N]),
        terms: Mutex::new(vec![Vec::new(); PROCESSES]),
        barrier: Barrier::new(PROCESSES),
    }
}

/// The first process has a right-hand side of zero, as processes far from all bodies do.
#[test]
fn fgmres_on_several_processes_takes_the_iterations_of_one() {
    let rhs: Vec<f64> = (0..N)
        .map(|i| {
            if i % PROCESSES == 0 {
                0.0
            } else {
                (i as f64).sin()
            }
        })
        .collect();
    let params = KrylovParams::default().with_rel_tol(1e-10).with_restart(10);
    let mut expected = vec![0.0; N];
    let on_one = fgmres(
        &Whole(weights()),
        &mut Identity(N),
        &rhs,
        &mut expected,
        &params,
    )
    .expect("convergence");
    let exchange = exchange();
    let solve = |process: usize| {
        let rows = Rows::new(process, &exchange);
        let own = |(row, b): (usize, &f64)| if rows.owns(row) { *b } else { 0.0 };
        let own: Vec<f64> = rhs.iter().enumerate().map(own).collect();
        let mut x = vec![0.0; N];
        let report = fgmres(&rows, &mut Identity(N), &own, &mut x, &params).expect("convergence");
        (report, x)
    };
    let solved: Vec<_> = thread::scope(|scope| {
        let solve = &solve;
        let threads: Vec<_> = (0..PROCESSES)
            .map(|process| scope.spawn(move || solve(process)))
            .collect();
        threads
            .into_iter()
            .map(|t| t.join().expect("no panic"))
            .collect()
    });
    for (process, (report, x)) in solved.iter().enumerate() {
        assert_eq!(report.iterations, on_one.iterations);
        let ratio = report.weighted_rel_residual / on_one.weighted_rel_residual;
        assert!((ratio - 1.0).abs() < 1e-4, "{ratio}");
        for (row, (x, expected)) in x.iter().zip(&expected).enumerate() {
            let expected = if row % PROCESSES == process {
                *expected
            } else {
                0.0
            };
            // The inverse is below one: rounding of a few additions.
            assert!(
                (x - expected).abs() < 1e-13,
                "{process} {row}: {x} {expected}"
            );
        }
    }
}

#[test]
fn other_methods_refuse_divided_vectors() {
    let exchange = exchange();
    let rows = Rows::new(0, &exchange);
    let params = KrylovParams::default();
    let found = cg(&rows, &mut Identity(N), &[1.0; N], &mut [0.0; N], &params);
    assert!(matches!(found, Err(LinalgError::SeveralProcesses { .. })));
}
