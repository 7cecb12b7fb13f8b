//! `report.html`: a run as one page that needs no network.
//!
//! Tables, bars and texts are static HTML. Scripts draw the moving parts from the numbers of
//! `data.rs`: `view3d.js` draws the bodies, `slice.js` the flow in a plane, and `plots.js` the
//! curves over time, among them those of `inertia.rs`. `player.js` controls the time that all of
//! them show.

mod data;
mod inertia;
mod record;
mod tables;
mod track;

pub use record::RunRecord;

use std::path::PathBuf;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::error::PictureError;
use swimmer::Folder;
use tables::{escaped, for_script};

/// Name of the file.
pub const REPORT_PAGE: &str = "report.html";

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPTS: [&str; 5] = [
    include_str!("player.js"),
    include_str!("colours.js"),
    include_str!("slice.js"),
    include_str!("view3d.js"),
    include_str!("plots.js"),
];

impl RunRecord {
    /// The page as HTML; equal records give equal text.
    ///
    /// # Errors
    /// A scene that cannot be written as text.
    pub fn page(&self) -> Result<String, PictureError> {
        let scene_text = match &self.scene_text {
            Some(text) => text.clone(),
            None => self.scene.to_toml()?,
        };
        let data = for_script(&data::page_data(self)?.to_string());
        let map = self.map.as_ref().map_or(String::new(), |svg| {
            format!(
                "<section aria-labelledby=\"map-title\"><h2 id=\"map-title\">Curvature map</h2>\n<p>Displacement per area of a small stroke, \
                 anticlockwise; the black curve is the gait.</p>\n<div class=\"scroll\" \
                 tabindex=\"0\" role=\"group\" aria-label=\"curvature map\"><img class=\"map\" \
                 alt=\"Maps of the curvature over two joints with the gait as a closed curve\" \
                 src=\"data:image/svg+xml;base64,{}\"></div></section>",
                STANDARD.encode(svg)
            )
        });
        let parts = [
            ("name", escaped(&self.name)),
            ("style", STYLE.to_owned()),
            ("lead", tables::lead(self)),
            ("results", tables::results(self)),
            ("budget", tables::error_budget(self)),
            ("map", map),
            ("cost", tables::cost(self)),
            ("scene", escaped(&scene_text)),
            ("data", data),
            ("scripts", SCRIPTS.join("\n")),
        ];
        Ok(tables::filled(TEMPLATE, &parts))
    }

    /// Writes the page into a folder and returns its path.
    ///
    /// # Errors
    /// Those of [`RunRecord::page`]; [`PictureError::Swim`] if the file cannot be written.
    pub fn write_page(&self, folder: &Folder) -> Result<PathBuf, PictureError> {
        let page = self.page()?;
        Ok(folder.write(REPORT_PAGE, |file| file.write_all(page.as_bytes()))?)
    }
}
