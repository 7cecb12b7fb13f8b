//! Time of a stroke without a mesh and of one phase by finite elements.

use criterion::{Criterion, criterion_group, criterion_main};
use swimmer::{Method, Outcome, Scene, choose, simulate};

/// The three-sphere swimmer with arms of 10 radii that move to these lengths in turn.
fn three_spheres(settings: &str, phases: &[(&str, f64)]) -> Scene {
    let phases: String = phases
        .iter()
        .map(|(joint, length)| format!("{{ link = \"{joint}\", length = {length} }}, "))
        .collect();
    let text = format!(
        r#"
        {settings}
        bodies = [
            {{ name = "l", radius = 1, position = [-10, 0, 0] }},
            {{ name = "c", radius = 1, position = [0, 0, 0] }},
            {{ name = "r", radius = 1, position = [10, 0, 0] }},
        ]
        links = [{{ name = "left", body = "l", to = "c" }}, {{ name = "right", body = "r", to = "c" }}]
        gait.phases = [{phases}]
        "#
    );
    Scene::parse(&text).expect("a valid scene")
}

fn run(scene: &Scene) -> Outcome {
    let mut model = choose(scene).expect("a supported scene").model;
    simulate(scene, model.as_mut(), Method::Collocation, &mut ()).expect("a stroke")
}

fn strokes(criterion: &mut Criterion) {
    let stroke = [
        ("left", 6.0),
        ("right", 6.0),
        ("left", 10.0),
        ("right", 10.0),
    ];
    let multipole = three_spheres(
        "model = { kind = \"multipole\", tolerance = 1e-8 }",
        &stroke,
    );
    let elements = three_spheres(
        "domain = { kind = \"ball\", radius = 40 }\n\
         model.kind = \"fem\"\nfem.surface_size = 0.8",
        &stroke[..1],
    );
    let mut group = criterion.benchmark_group("three spheres");
    group.bench_function("stroke by multipoles", |b| b.iter(|| run(&multipole)));
    group
        .sample_size(10)
        .bench_function("phase by finite elements", |b| b.iter(|| run(&elements)));
    group.finish();
}

criterion_group!(benches, strokes);
criterion_main!(benches);
