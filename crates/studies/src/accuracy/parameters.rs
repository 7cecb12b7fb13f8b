//! Parameters that the study varies, and the overrides of a scene that set them.

/// Element sizes on the spheres.
pub fn sizes(quick: bool) -> &'static [f64] {
    if quick {
        &[0.8, 0.5]
    } else {
        &[0.8, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15]
    }
}

/// Target errors of adapted meshes.
pub fn targets(quick: bool) -> &'static [f64] {
    if quick {
        &[1e-2]
    } else {
        &[1e-2, 3e-3, 1e-3, 3e-4, 1e-4]
    }
}

/// Kinds of meshes: name, geometry, and whether symmetry planes are used.
pub const MESHES: [[&str; 3]; 3] = [
    ["finite elements, curved", "curved", "auto"],
    ["whole fluid, curved", "curved", "off"],
    ["whole fluid, straight", "straight", "off"],
];

/// Overrides of a scene for a kind of mesh with elements of `size` on the spheres.
pub fn mesh_overrides(geometry: &str, symmetry: &str, size: f64) -> [String; 3] {
    [
        format!("fem.surface_size={size}"),
        format!("fem.geometry={geometry}"),
        format!("fem.symmetry={symmetry}"),
    ]
}

/// Overrides of a scene for axisymmetric elements with a tolerance.
pub fn axisymmetric_overrides(tolerance: f64) -> [String; 2] {
    [
        "model.kind=axisymmetric".to_owned(),
        format!("model.tolerance={tolerance:e}"),
    ]
}
