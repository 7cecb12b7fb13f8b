//! `swim run --sensitivities`: derivatives of the net displacement.

use std::path::Path;

use design::sensitivities::{self as runs, Sensitivity};
use swimmer::Scene;
use swimmer::output::Folder;

use super::design_files::write;
use super::error::CliError;
use super::progress::DesignSpinner;
use super::text::with_uncertainty;

/// Computes the sensitivities and writes `sensitivities.csv`.
pub fn sensitivities(scene: &Scene, out: &Path, quiet: bool) -> Result<Vec<Sensitivity>, CliError> {
    let found = runs::sensitivities(scene, &mut DesignSpinner::new(quiet))?;
    let mut csv = "parameter,value,derivative,error\n".to_owned();
    for sensitivity in &found {
        let (parameter, derivative) = (&sensitivity.parameter, sensitivity.derivative);
        // Quotes in a quoted field are doubled.
        let name = parameter.name.replace('"', "\"\"");
        csv += &format!(
            "\"{name}\",{:?},{derivative:?},{:?}\n",
            parameter.value, sensitivity.error
        );
    }
    write(&Folder::create(out)?, "sensitivities.csv", &csv)?;
    Ok(found)
}

/// The sensitivities as text.
pub fn describe_sensitivities(found: &[Sensitivity]) -> String {
    let mut text = "\nderivative of the net displacement by\n".to_owned();
    for sensitivity in found {
        let parameter = &sensitivity.parameter;
        text += &format!(
            "  {:<38} {}\n",
            format!("{} = {}", parameter.name, parameter.value),
            with_uncertainty(sensitivity.derivative, sensitivity.error)
        );
    }
    text
}
