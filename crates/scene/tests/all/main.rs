//! All tests of scene files, in one binary.

mod built;
mod contact_paths;
mod copies;
mod damaged;
mod deformations;
mod documented;
mod edits;
mod examples;
mod files;
mod gaits;
mod hostile;
mod laws;
mod malformed;
mod overrides;
mod surface_frames;
mod surfaces;
mod thermal_noise;
