//! Machine and day on which figures were measured.

pub use swimmer::output::processor;

/// Today as `year-month-day`, in universal time.
pub fn today() -> String {
    let now = jiff::Timestamp::now();
    now.to_zoned(jiff::tz::TimeZone::UTC).date().to_string()
}

#[cfg(test)]
mod tests {
    use super::today;

    #[test]
    fn dates_have_year_month_and_day() {
        let today = today();
        let parts: Vec<usize> = today.split('-').map(str::len).collect();
        assert_eq!(parts, [4, 2, 2], "{today}");
    }
}
