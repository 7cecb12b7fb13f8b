//! `swim view`: the page of a run.

use std::path::Path;

use pictures::RunRecord;
use swimmer::Folder;

use super::error::CliError;
use super::text::{entry, warn};

/// Writes the page of an earlier run again.
pub fn view(path: &Path, open: bool, movie: bool) -> Result<String, CliError> {
    let (record, folder) = (RunRecord::read(path)?, Folder::create(path)?);
    record.write_page(&folder)?;
    let movie = match movie {
        true => movie_entry(&record, &folder)?,
        false => String::new(),
    };
    if open {
        open_page(path);
    }
    let missing = (record.missing_flow()).map_or(String::new(), |why| entry("not shown", why));
    Ok(page_entry(path) + &missing + &movie)
}

/// Writes the movie of a run, and says where it is.
pub fn write_movie(path: &Path) -> Result<String, CliError> {
    movie_entry(&RunRecord::read(path)?, &Folder::create(path)?)
}

fn movie_entry(record: &RunRecord, folder: &Folder) -> Result<String, CliError> {
    let file = record.write_movie(folder)?;
    Ok(entry("movie", file.display()))
}

/// The line that says where the page is.
pub fn page_entry(folder: &Path) -> String {
    match page(folder) {
        Some(page) => entry("report", page.display()),
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

fn page(folder: &Path) -> Option<std::path::PathBuf> {
    Some(folder.join(pictures::REPORT_PAGE)).filter(|page| page.exists())
}
