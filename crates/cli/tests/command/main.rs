//! The `swim` command as a user meets it.

mod book;
mod design;
mod help;
mod output;
mod pictures;
mod printed;
mod resume;
