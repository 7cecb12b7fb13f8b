//! `swim run --sensitivities`: derivatives of the net displacement.

use std::path::Path;

use swimmer::output::Folder;
use swimmer::{Scene, SwimError, sensitivities as runs};

use super::design_files::write;
use super::design_progress::Progress;
use super::text::with_uncertainty;

/// Computes the sensitivities, writes `sensitivities.csv`, and describes them.
pub fn sensitivities(scene: &Scene, out: &Path) -> Result<String, SwimError> {
    let found = runs::sensitivities(scene, &mut Progress::new())?;
    let mut csv = "parameter,value,derivative,error\n".to_owned();
    let mut text = "\nderivative of the net displacement by\n".to_owned();
    for sensitivity in &found {
        let (parameter, derivative) = (&sensitivity.parameter, sensitivity.derivative);
        // Quotes in a quoted field are doubled.
        let name = parameter.name.replace('"', "\"\"");
        csv += &format!(
            "\"{name}\",{:?},{derivative:?},{:?}\n",
            parameter.value, sensitivity.error
        );
        text += &format!(
            "  {:<38} {}\n",
            format!("{} = {}", parameter.name, parameter.value),
            with_uncertainty(derivative, sensitivity.error)
        );
    }
    write(&Folder::create(out)?, "sensitivities.csv", &csv)?;
    Ok(text)
}
