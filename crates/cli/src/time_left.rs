//! The time that countable work still takes.

/// Seconds of work before which there is no estimate, and the shortest time in which one follows
/// what is measured.
const PATIENCE: f64 = 2.0;

/// Time in which an estimate follows what is measured, relative to that of the work so far: one
/// part that takes longer than the others before it then moves the estimate slowly.
const FOLLOWING_TIME: f64 = 0.2;

/// Estimates the seconds left of work in parts, from the time that the parts before took.
///
/// Between two looks the estimate decreases by the time that went by, and moves towards what is
/// measured: `e^(-t/τ)` of the difference stays after the time `t`, with `τ` a fifth of the time so
/// far. The number then does not depend on how often it is looked at, and does not jump when a part
/// takes longer than others or when more parts are found.
#[derive(Clone, Copy, Debug, Default)]
pub struct TimeLeft {
    /// The first look: seconds, and parts done.
    first: Option<(f64, f64)>,
    /// The last estimate: when it was made, and the seconds left then.
    last: Option<(f64, f64)>,
    /// Parts done at the last look.
    done: f64,
}

impl TimeLeft {
    /// Seconds left at the time `now`, in seconds, when `done` of `all` parts are done; none in the
    /// first two seconds, before a part is done, and when all are.
    ///
    /// The first look is at the beginning of the work, with the parts that are known already. Fewer
    /// parts than before are other work, which begins.
    pub fn at(&mut self, now: f64, done: f64, all: f64) -> Option<f64> {
        if done < self.done {
            *self = Self::default();
        }
        self.done = done;
        let (begun, before) = *self.first.get_or_insert((now, done));
        let elapsed = now - begun;
        if elapsed < PATIENCE || done <= before || done >= all {
            return None;
        }
        let measured = elapsed / (done - before) * (all - done);
        let left = match self.last {
            None => measured,
            Some((at, left)) => {
                let expected = (left - (now - at)).max(0.0);
                let time = PATIENCE.max(FOLLOWING_TIME * elapsed);
                measured + (expected - measured) * (-(now - at) / time).exp()
            }
        };
        self.last = Some((now, left));
        Some(left)
    }
}

/// A time left in words, with as many digits as it can have: `about 40 s left`.
pub fn about(seconds: f64) -> String {
    // Steps of about a tenth, in which people count.
    let step = match seconds {
        s if s < 10.0 => 1.0,
        s if s < 60.0 => 5.0,
        s if s < 120.0 => 30.0,
        s if s < 600.0 => 60.0,
        s if s < 3600.0 => 300.0,
        _ => 1800.0,
    };
    let rounded = ((seconds / step).ceil() * step).max(1.0);
    let words = match rounded {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    };
    format!("about {words} left")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parts of the same length: the estimate is exact, from whatever part is known already.
    #[test]
    fn equal_parts_have_an_exact_estimate() {
        for known in [0.0, 3.0] {
            let mut left = TimeLeft::default();
            assert_eq!(left.at(10.0, known, 20.0), None);
            for part in 1..17 {
                let (now, done) = (10.0 + 3.0 * f64::from(part), known + f64::from(part));
                let found = left.at(now, done, 20.0).unwrap();
                assert!((found - 3.0 * (20.0 - done)).abs() < 1e-9, "{found}");
            }
            assert_eq!(left.at(70.0, 20.0, 20.0), None);
        }
    }

    #[test]
    fn there_is_none_before_a_part_or_two_seconds() {
        let mut left = TimeLeft::default();
        assert_eq!(left.at(0.0, 0.0, 9.0), None);
        assert_eq!(left.at(1.9, 4.0, 9.0), None);
        assert_eq!(left.at(100.0, 4.0, 9.0), Some(125.0));
        // Other work.
        assert_eq!(left.at(101.0, 0.0, 9.0), None);
        assert_eq!(left.at(102.9, 5.0, 9.0), None);
        assert_eq!(left.at(106.0, 5.0, 9.0), Some(4.0));
    }

    /// Parts of 0.1 to 10 s in any order, looked at after each, and the number of all parts doubles
    /// in between: apart from the time that went by, the number changes by less than a tenth
    /// between looks that are less than a fiftieth of the time so far apart.
    #[test]
    fn the_number_does_not_jump_when_parts_differ_or_more_are_found() {
        let mut random = 1_u64;
        for _ in 0..50 {
            let mut left = TimeLeft::default();
            let (mut now, mut last) = (0.0, None::<(f64, f64)>);
            left.at(now, 0.0, 200.0);
            for part in 1..400_u32 {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                let share = (random >> 11) as f64 / 2_f64.powi(53);
                now += 10_f64.powf(2.0 * share - 1.0);
                let all = if part < 150 { 200.0 } else { 400.0 };
                let found = left.at(now, f64::from(part), all);
                if let (Some((at, before)), Some(found)) = (last, found) {
                    let gone = now - at;
                    let expected = (before - gone).max(0.0);
                    let measured = now / f64::from(part) * (all - f64::from(part));
                    if gone < 0.02 * now {
                        let change = (found - expected).abs();
                        assert!(change < 0.1 * measured.max(expected), "{change} {found}");
                    }
                }
                last = found.map(|found| (now, found));
            }
        }
    }

    /// The same moments of work give the same number, however often it is looked at in between.
    #[test]
    fn frequent_looks_do_not_speed_up_the_number() {
        let estimate = |looks: u32| {
            let mut left = TimeLeft::default();
            left.at(0.0, 0.0, 100.0);
            left.at(50.0, 50.0, 100.0);
            // From now on parts take four times as long.
            let mut found = 0.0;
            for look in 1..=looks {
                let gone = 8.0 * f64::from(look) / f64::from(looks);
                found = left.at(50.0 + gone, 50.0 + gone / 4.0, 100.0).unwrap();
            }
            found
        };
        let (once, often) = (estimate(1), estimate(100));
        // What is measured changes in between, from 50 to 53.5.
        assert!((once - often).abs() < 3.5, "{once} {often}");
    }

    /// After a third of the time the estimate has followed: `(1/3)^5` of 100 s is left.
    #[test]
    fn an_estimate_follows_what_is_found() {
        let mut left = TimeLeft::default();
        let mut found = None;
        for part in 0..=150 {
            let all = if part <= 50 { 100.0 } else { 200.0 };
            found = left.at(f64::from(part), f64::from(part), all);
        }
        assert!((found.unwrap() - 50.0).abs() < 0.5, "{found:?}");
    }

    #[test]
    fn words_are_rounded() {
        for (seconds, words) in [
            (0.2, "about 1 s left"),
            (7.4, "about 8 s left"),
            (36.0, "about 40 s left"),
            (61.0, "about 90 s left"),
            (1000.0, "about 20 min left"),
            (8000.0, "about 2.5 h left"),
        ] {
            assert_eq!(about(seconds), words);
        }
    }
}
