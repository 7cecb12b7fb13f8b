//! `swim view`: the page of a run.

use std::path::Path;

use swimmer::SwimError;
#[cfg(feature = "plots")]
use swimmer::output::{Folder, RunRecord};

use super::text::{entry, warn};

/// Writes the page of an earlier run again.
#[cfg(feature = "plots")]
pub fn view(path: &Path, open: bool, movie: bool) -> Result<String, SwimError> {
    let (record, folder) = (RunRecord::read(path)?, Folder::create(path)?);
    record.write_page(&folder)?;
    let movie = match movie {
        true => movie_entry(&record, &folder)?,
        false => String::new(),
    };
    if open {
        open_page(path);
    }
    Ok(page_entry(path) + &movie)
}

/// Writes the movie of a run, and says where it is.
#[cfg(feature = "plots")]
pub fn write_movie(path: &Path) -> Result<String, SwimError> {
    movie_entry(&RunRecord::read(path)?, &Folder::create(path)?)
}

#[cfg(feature = "plots")]
fn movie_entry(record: &RunRecord, folder: &Folder) -> Result<String, SwimError> {
    let file = record.write_movie(folder)?;
    Ok(entry("movie", &file.display().to_string()))
}

#[cfg(not(feature = "plots"))]
pub fn view(path: &Path, _: bool, _: bool) -> Result<String, SwimError> {
    Err(without_plots("swim view", path))
}

#[cfg(not(feature = "plots"))]
pub fn write_movie(path: &Path) -> Result<String, SwimError> {
    Err(without_plots("--movie", path))
}

/// The error for pictures and pages that this program cannot write.
#[cfg(not(feature = "plots"))]
pub fn without_plots(words: &str, path: &Path) -> SwimError {
    SwimError::NotApplicable {
        place: format!("{words} {}", path.display()),
        problem: "this program was built without the feature `plots`".to_owned(),
    }
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
