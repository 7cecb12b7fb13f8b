//! Optimal strokes of three spheres against exact values by multipoles.
//!
//! Energies are `E T` in units of the viscosity and the cube of the radius.

use std::time::Instant;
use swimmer::design::*;
use swimmer::models::{ShapeGeometry, ShapeSpace};
use swimmer::{Scene, choose};

/// Three equal spheres of radius 1 on a line, with the table over these arms.
fn table(arm: f64, ranges: [(f64, f64); 2], tolerance: f64) -> ShapeGeometry {
    let scene = Scene::parse(&format!(
        "model = {{ kind = \"multipole\", tolerance = 1e-10 }}\n\
         bodies = [{{ name = \"l\", radius = 1, position = [-{arm}, 0, 0] }}, \
         {{ name = \"c\", radius = 1, position = [0, 0, 0] }}, \
         {{ name = \"r\", radius = 1, position = [{arm}, 0, 0] }}]\n\
         links = [{{ name = \"a\", body = \"l\", to = \"c\" }}, \
         {{ name = \"b\", body = \"r\", to = \"c\" }}]\n"
    ))
    .unwrap();
    let mut model = choose(&scene).unwrap().model;
    let space = ShapeSpace::tabulate(&scene, model.as_mut(), &ranges, tolerance).unwrap();
    space.geometry().unwrap()
}

fn options(start: Option<Vec<f64>>, terms: usize) -> SearchOptions {
    SearchOptions {
        start,
        terms,
        tolerance: 1e-6,
    }
}

#[test]
fn explore() {
    let clock = Instant::now();
    let t = table(6.0, [(2.5, 9.5), (2.5, 9.5)], 1e-7);
    println!(
        "table {:?} {} {:?}",
        clock.elapsed(),
        t.points(),
        t.degrees()
    );
    let least = LeastEnergy {
        measure: DisplacementMeasure::Length,
        displacement: 0.2,
    };
    for terms in [6, 12, 24] {
        let clock = Instant::now();
        let o = optimise(
            &t,
            &least,
            t.ranges(),
            &options(Some(vec![6.0, 6.0]), terms),
            &mut (),
        )
        .unwrap();
        println!(
            "ADL {terms}: {} {} it {} err {:.1e} {:?} limits {}",
            o.totals.energy,
            o.period_energy_product,
            o.iterations,
            o.refinement_error,
            clock.elapsed(),
            o.at_limits
        );
    }
    let t = table(10.0, [(6.0, 10.0), (6.0, 10.0)], 1e-7);
    println!("table {} {:?}", t.points(), t.degrees());
    for terms in [4, 8, 16] {
        let clock = Instant::now();
        let least = LeastEnergy {
            measure: DisplacementMeasure::Length,
            displacement: 0.0799026702,
        };
        let o = optimise(&t, &least, t.ranges(), &options(None, terms), &mut ()).unwrap();
        println!(
            "box {terms}: {} {} it {} err {:.1e} {:?} limits {}",
            o.totals.energy,
            o.period_energy_product,
            o.iterations,
            o.refinement_error,
            clock.elapsed(),
            o.at_limits
        );
        let clock = Instant::now();
        let o = optimise(
            &t,
            &HighestEfficiency {
                measure: DisplacementMeasure::Length,
            },
            t.ranges(),
            &options(None, terms),
            &mut (),
        )
        .unwrap();
        println!(
            "eff {terms}: {} {} it {} err {:.1e} {:?} d {} {}",
            o.totals.energy,
            o.period_energy_product,
            o.iterations,
            o.refinement_error,
            clock.elapsed(),
            o.totals.displacement.x,
            o.cost
        );
        let clock = Instant::now();
        let o = optimise(
            &t,
            &LargestDisplacement {
                measure: DisplacementMeasure::Length,
                scale: 0.1,
            },
            t.ranges(),
            &options(None, terms),
            &mut (),
        );
        match o {
            Ok(o) => println!(
                "far {terms}: {} {} it {} err {:.1e} {:?} d {} {}",
                o.totals.energy,
                o.period_energy_product,
                o.iterations,
                o.refinement_error,
                clock.elapsed(),
                o.totals.displacement.x,
                o.cost
            ),
            Err(e) => println!("far {e}"),
        }
    }
}
