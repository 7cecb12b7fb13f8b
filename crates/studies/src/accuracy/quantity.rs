//! A quantity with the errors and costs of all methods.

use crate::chart::{LogLog, Series, Style, pareto_front};

/// One computed value.
#[derive(Clone, Debug)]
pub struct Point {
    /// Name of the curve.
    pub method: String,
    /// Parameter along the curve: an element size, an order or a tolerance.
    pub choice: String,
    /// Dofs of the largest system; zero for models without a mesh.
    pub dofs: usize,
    /// Wall-clock seconds from the scene to the value, mesh generation included.
    pub seconds: f64,
    /// Relative error against the exact value.
    pub error: f64,
    /// Estimated relative error, if the value came with an estimate.
    pub claimed: Option<f64>,
}

/// A quantity with all its points.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Name on the command line and in file names.
    pub key: &'static str,
    /// Description with the exact value.
    pub title: String,
    pub points: Vec<Point>,
}

impl Quantity {
    /// Chart of the error over a cost: one curve per method, and the Pareto front.
    pub fn chart(&self, cost_name: &str, cost: impl Fn(&Point) -> f64) -> LogLog {
        let mut methods: Vec<&str> = Vec::new();
        for point in &self.points {
            if !methods.contains(&point.method.as_str()) {
                methods.push(&point.method);
            }
        }
        let mut series: Vec<Series> = methods
            .into_iter()
            .map(|method| Series {
                name: method.to_owned(),
                points: self
                    .points
                    .iter()
                    .filter(|p| p.method == method)
                    .map(|p| (cost(p), p.error))
                    .collect(),
                style: Style::Curve,
            })
            .collect();
        let all: Vec<(f64, f64)> = self.points.iter().map(|p| (cost(p), p.error)).collect();
        series.push(Series {
            name: "Pareto front: no other point is both cheaper and better".into(),
            points: pareto_front(&all),
            style: Style::Front,
        });
        LogLog {
            title: self.title.clone(),
            x: cost_name.into(),
            y: "relative error".into(),
            series,
        }
    }
}
