//! The `swim` command as a user meets it.

mod design;
mod output;
mod pictures;
mod printed;
mod resume;
