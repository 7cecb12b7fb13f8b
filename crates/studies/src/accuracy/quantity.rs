//! A quantity with the errors and costs of all methods.

use anyhow::Result;

use crate::chart::{LogLog, Series, Style, pareto_front};
use crate::page::Page;

/// One computed value.
#[derive(Clone, Debug)]
pub struct Point {
    /// Name of the curve.
    pub method: String,
    /// Parameter along the curve: an element size, an order or a tolerance.
    pub choice: String,
    /// Element size, for points of a series of meshes.
    pub size: Option<f64>,
    /// Dofs of the largest system; zero for models without a mesh.
    pub dofs: usize,
    /// Wall-clock seconds from the scene to the value, mesh generation included.
    pub seconds: f64,
    /// Relative error of the answer against the exact value.
    pub error: f64,
    /// The same of the value before the estimated discretisation error was subtracted; `None` for
    /// methods without this correction.
    pub uncorrected: Option<f64>,
    /// Relative error bar of the answer, if there is one.
    pub bar: Option<f64>,
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
    /// Observed order of an error in the element size, from the next coarser mesh to that of a
    /// point.
    ///
    /// It is `ln(e_1 / e_2) / ln(h_1 / h_2)`; `None` for the coarsest mesh and for points without
    /// such an error or size.
    pub fn order(&self, number: usize, error: impl Fn(&Point) -> Option<f64>) -> Option<f64> {
        let fine = &self.points[number];
        let size = fine.size?;
        let coarser = self.points.iter().filter_map(|p| {
            let coarser = (p.method == fine.method).then_some(p.size?)?;
            (coarser > size).then_some((coarser, p))
        });
        let (coarse_size, coarse) = coarser.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((error(coarse)? / error(fine)?).ln() / (coarse_size / size).ln())
    }

    /// Least and largest factor by which the correction reduces the smallest error that meshes of
    /// given element sizes reach in equal seconds.
    pub fn gains_at_equal_seconds(&self) -> Option<[f64; 2]> {
        let meshes = || (self.points.iter()).filter_map(|p| Some((p, p.size.and(p.uncorrected)?)));
        let best = |seconds: f64, error: &dyn Fn(&Point, f64) -> f64| {
            let affordable = meshes().filter(|(p, _)| p.seconds <= seconds);
            affordable.fold(f64::INFINITY, |best, (p, before)| {
                best.min(error(p, before))
            })
        };
        let gains = meshes().map(|(at, _)| {
            best(at.seconds, &|_, before| before) / best(at.seconds, &|p, _| p.error)
        });
        gains.fold(None, |range: Option<[f64; 2]>, gain| {
            let [least, largest] = range.unwrap_or([gain; 2]);
            Some([least.min(gain), largest.max(gain)])
        })
    }

    /// Adds the charts of the error over seconds and over dofs to a page.
    ///
    /// Models without a mesh have zero dofs, and are left out of the second.
    pub fn add_charts(&self, page: &mut Page) -> Result<()> {
        let seconds = self.chart("seconds", |p| p.seconds);
        let dofs = self.chart("dofs", |p| p.dofs as f64);
        let name = format!("accuracy-{}", self.key);
        page.chart(format!("{name}-dofs"), "error against dofs", &dofs)?;
        page.chart(name, "error against seconds", &seconds)
    }

    /// Chart of the error over a cost: one curve per method, another one of the uncorrected values,
    /// and the Pareto front.
    fn chart(&self, cost_name: &'static str, cost: impl Fn(&Point) -> f64) -> LogLog {
        let mut methods: Vec<&str> = Vec::new();
        for point in &self.points {
            if !methods.contains(&point.method.as_str()) {
                methods.push(&point.method);
            }
        }
        let points = |method: &str, error: &dyn Fn(&Point) -> Option<f64>| -> Vec<(f64, f64)> {
            let of_method = self.points.iter().filter(|p| p.method == method);
            let points = of_method.map(|p| Some((cost(p), error(p)?)));
            points.flatten().collect()
        };
        let curve =
            |method: &&str| Series::new(*method, points(method, &|p| Some(p.error)), Style::Curve);
        let mut series: Vec<Series> = methods.iter().map(curve).collect();
        // One line of the legend explains all of them.
        let mut name = "thin, dashed: before the correction";
        for (number, method) in methods.iter().enumerate() {
            let points = points(method, &|p| p.uncorrected);
            if !points.is_empty() {
                let name = std::mem::take(&mut name);
                series.push(Series::new(name, points, Style::Before(number)));
            }
        }
        let all: Vec<(f64, f64)> = self.points.iter().map(|p| (cost(p), p.error)).collect();
        let name = "Pareto front: no other point is both cheaper and better";
        series.push(Series::new(name, pareto_front(&all), Style::Front));
        LogLog::new(self.title.clone(), cost_name, "relative error", series)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Elements whose uncorrected errors have order 4 and whose answers have order 6.
    fn quantity() -> Quantity {
        let point = |size: f64| Point {
            method: "elements".into(),
            choice: format!("size {size}"),
            size: Some(size),
            dofs: 1000,
            seconds: size.powi(-3),
            error: 1e-2 * size.powi(6),
            uncorrected: Some(size.powi(4)),
            bar: None,
        };
        let multipoles = Point {
            method: "multipoles".into(),
            size: None,
            uncorrected: None,
            ..point(0.9)
        };
        Quantity {
            key: "drag",
            title: "drag".into(),
            points: vec![point(0.8), point(0.5), point(0.4), multipoles],
        }
    }

    #[test]
    fn orders_are_those_from_the_next_coarser_mesh() {
        let quantity = quantity();
        let orders = |number| {
            let error = quantity.order(number, |p| Some(p.error));
            error.zip(quantity.order(number, |p| p.uncorrected))
        };
        assert_eq!((orders(0), orders(3)), (None, None));
        for number in [1, 2] {
            let (corrected, uncorrected) = orders(number).expect("there is a coarser mesh");
            assert!((corrected - 6.0).abs() < 1e-9 && (uncorrected - 4.0).abs() < 1e-9);
        }
    }

    #[test]
    fn gains_are_those_of_the_best_affordable_meshes() {
        // Finer meshes take longer and are better in both respects: 100 / size^2.
        let [least, largest] = quantity()
            .gains_at_equal_seconds()
            .expect("there are meshes");
        assert!((least - 100.0 / 0.64).abs() < 1e-9 && (largest - 100.0 / 0.16).abs() < 1e-9);
    }

    #[test]
    fn charts_show_both_errors_of_corrected_methods() {
        let chart = quantity().chart("seconds", |p| p.seconds);
        let styles: Vec<Style> = chart.series.iter().map(|series| series.style).collect();
        let both = [Style::Curve, Style::Curve, Style::Before(0), Style::Front];
        assert_eq!(styles, both);
        assert!((chart.series[2].points[0].1 - 0.8_f64.powi(4)).abs() < 1e-12);
    }
}
