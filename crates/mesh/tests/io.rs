//! Mesh files: what is read is what was written, and whatever is malformed is an error with a place.

mod shapes;

mod io {
    mod dialects;
    mod encode;
    mod malformed;
    mod real_files;
    mod vtu_files;
}
