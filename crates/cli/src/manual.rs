//! `swim completions` and `swim man`: what the shell and `man` know about the command.

use std::path::Path;

use clap::CommandFactory;
use clap_complete::Shell;
use swimmer::SwimError;

use super::arguments::Arguments;
use super::error::CliError;
use super::text::entry;

/// The completions of a shell.
pub fn completions(shell: Shell) -> String {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "swim", &mut script);
    String::from_utf8_lossy(&script).into_owned()
}

/// Writes the manual pages into a folder, one per subcommand.
pub fn pages(out: &Path) -> Result<String, CliError> {
    std::fs::create_dir_all(out)
        .and_then(|()| clap_mangen::generate_to(Arguments::command(), out))
        .map_err(|source| SwimError::Write {
            path: out.to_owned(),
            source,
        })?;
    Ok(entry("manual pages", out.display()))
}
