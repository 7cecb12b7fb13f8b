//! The `swim` command as a user meets it.

mod output;
mod printed;
mod resume;
