//! The number of threads that the environment asks for.

use crate::error::SwimError;

/// Largest number of threads in any case, more than any machine of today has processors.
const MAX_THREADS: usize = 1024;

/// Refuses a number of threads in the environment that would take all memory of the machine.
///
/// The pool of rayon starts as many threads as `RAYON_NUM_THREADS` says, before anything can report
/// an error. At most 1024, or twice the number of processors, are allowed; more never help.
///
/// # Errors
/// [`SwimError::NotApplicable`] with both numbers.
pub fn check_threads() -> Result<(), SwimError> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let limit = MAX_THREADS.max(processors.saturating_mul(2));
    // The second name is the old one, which rayon still reads.
    let names = ["RAYON_NUM_THREADS", "RAYON_RS_NUM_CPUS"];
    let values = names.map(|name| (name, std::env::var(name).unwrap_or_default()));
    values
        .iter()
        .try_for_each(|(name, value)| check(name, value, (processors, limit)))
}

fn check(name: &str, value: &str, (processors, limit): (usize, usize)) -> Result<(), SwimError> {
    // What is no number at all is ignored by rayon.
    let is_number = !value.is_empty() && value.bytes().all(|b| b.is_ascii_digit());
    if !is_number || value.parse().is_ok_and(|threads: usize| threads <= limit) {
        return Ok(());
    }
    Err(SwimError::NotApplicable {
        place: format!("the environment variable {name}"),
        problem: format!(
            "{value} threads are more than the limit of {limit}; this machine has {processors} \
             processors, and no larger number is faster: set it to {processors} or unset it"
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_threads_are_refused() {
        let check = |value| check("RAYON_NUM_THREADS", value, (2, 1024));
        for good in ["", "0", "1", "1024", "many"] {
            assert!(check(good).is_ok(), "{good}");
        }
        for bad in ["1025", "1000000", "99999999999999999999999"] {
            let message = check(bad).unwrap_err().to_string();
            assert!(
                message.contains(bad) && message.contains("limit of 1024"),
                "{message}"
            );
        }
    }
}
