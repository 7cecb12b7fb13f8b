//! `swim view`: the page of a run.

use std::path::Path;

use swimmer::SwimError;

use super::text::{entry, warn};

/// Writes the page of an earlier run again.
#[cfg(feature = "plots")]
pub fn view(path: &Path, open: bool, movie: bool) -> Result<String, SwimError> {
    use swimmer::output::{Folder, RunRecord};

    RunRecord::read(path)?.write_page(&Folder::create(path)?)?;
    let movie = if movie {
        write_movie(path)?
    } else {
        String::new()
    };
    if open {
        open_page(path);
    }
    Ok(page_entry(path) + &movie)
}

/// Writes the movie of a run, and says where it is.
#[cfg(feature = "plots")]
pub fn write_movie(path: &Path) -> Result<String, SwimError> {
    use swimmer::output::{Folder, RunRecord};

    let file = RunRecord::read(path)?.write_movie(&Folder::create(path)?)?;
    Ok(entry("movie", &file.display().to_string()))
}

#[cfg(not(feature = "plots"))]
pub fn write_movie(path: &Path) -> Result<String, SwimError> {
    view(path, false, true)
}

#[cfg(not(feature = "plots"))]
pub fn view(path: &Path, _: bool, _: bool) -> Result<String, SwimError> {
    Err(SwimError::NotApplicable {
        place: format!("swim view {}", path.display()),
        problem: "this program was built without the feature `plots`".to_owned(),
    })
}

/// The line that says where the page is.
pub fn page_entry(folder: &Path) -> String {
    match page(folder) {
        Some(page) => entry("report", &page.display().to_string()),
        None => String::new(),
    }
}

/// Opens the page in the browser. A machine without one is worth a warning only.
pub fn open_page(folder: &Path) {
    let Some(page) = page(folder) else {
        return warn("there is no page to open: the program was built without the feature `plots`");
    };
    if let Err(error) = open::that_detached(&page) {
        warn(&format!("cannot open {}: {error}", page.display()));
    }
}

#[cfg(feature = "plots")]
fn page(folder: &Path) -> Option<std::path::PathBuf> {
    Some(folder.join(swimmer::output::REPORT_PAGE)).filter(|page| page.exists())
}

#[cfg(not(feature = "plots"))]
fn page(_: &Path) -> Option<std::path::PathBuf> {
    None
}
