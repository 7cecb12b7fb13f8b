//! Mesh files: what is read is what was written, and whatever is malformed is an error with a place.

mod io {
    mod real_files;
}
