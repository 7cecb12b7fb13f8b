//! `swimmers.csv`: one row per swimmer of a run with several.

use scene::Scene;

use super::trajectory::quoted;
use crate::swimmers::SwimmerOutcome;

/// Results of swimmers as comma-separated values with a header.
///
/// Columns: `swimmer` (the name of its first body), the mean displacement of its moving bodies
/// `dx`, `dy`, `dz` with its error bar `error`, empty if it was not estimated, the rotation vector
/// of its root `rx`, `ry`, `rz` in radians with its error bar `rotation_error`, and its `work` on
/// the fluid with its error bar `work_error`, both empty where it is known in total only
/// ([`SwimmerOutcome`]).
pub fn swimmers_csv(scene: &Scene, swimmers: &[SwimmerOutcome]) -> String {
    let mut text = "swimmer,dx,dy,dz,error,rx,ry,rz,rotation_error,work,work_error\n".to_owned();
    for swimmer in swimmers {
        let known = |number: Option<f64>| number.map_or(String::new(), |number| number.to_string());
        let [d, r] = [swimmer.displacement, swimmer.rotation];
        text += &format!(
            "{},{},{},{},{},{},{},{},{},{},{}\n",
            quoted(swimmer.name(scene)),
            d.x,
            d.y,
            d.z,
            known(swimmer.error_estimate.estimated()),
            r.x,
            r.y,
            r.z,
            known(swimmer.rotation_error.estimated()),
            known(swimmer.work),
            known(swimmer.work_error.and_then(|bars| bars.estimated())),
        );
    }
    text
}
