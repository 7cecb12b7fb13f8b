//! Gaits that can have a periodic state in a fluid with inertia.

use std::f64::consts::PI;

use rigid::Joint;

use crate::error::SceneError;
use crate::gait::spans;
use crate::scene::Scene;

/// Relative difference from a whole number of periods that is rounding of the numbers of a file.
const WHOLE_PERIODS: f64 = 1e-9;

impl Scene {
    /// Refuses a periodic start in a fluid with inertia if a cycle of the gait does not repeat the
    /// one before: if its last shape is not the first one, if joints make whole turns, which the
    /// velocity of the fluid remembers, or if loads have another period.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] of `gait.periodic`.
    pub fn check_periodic_flow(&self) -> Result<(), SceneError> {
        let refuse = |problem: String| {
            let key = "gait.periodic".to_owned();
            Err(SceneError::BadValue {
                place: self.place(&key),
                problem,
                key,
            })
        };
        let joints = self.articulation.joints();
        let shape = self.articulation.initial_shape();
        let cycle = spans(&self.gait, shape)?.take(self.gait.phases.len());
        let end = cycle.last().map_or(shape.to_vec(), |span| span.to);
        if let Some((joint, change)) = self.shape_changes(shape, &end).first() {
            return refuse(format!(
                "needs a gait that closes: over a cycle the value of \"{}\" changes by {change}; \
                 add a phase that brings it back",
                joints[*joint].name
            ));
        }
        let turns = |(joint, (from, to)): &(&Joint, (&f64, &f64))| {
            // What closes has whole turns or none.
            !joint.is_passive() && (*to - *from).abs() > PI
        };
        if let Some((joint, _)) = joints.iter().zip(shape.iter().zip(&end)).find(turns) {
            return refuse(format!(
                "is unsupported in a fluid with inertia for joints that make whole turns, as \
                 \"{}\" does; remove it and run several cycles",
                joint.name
            ));
        }
        let duration = self.gait.cycle_duration();
        let divides = |period: f64| {
            let count = duration / period;
            (count - count.round()).abs() <= WHOLE_PERIODS * count
        };
        match self.periods().find(|period| !divides(*period)) {
            Some(period) => refuse(format!(
                "needs loads and velocities that repeat with the gait, and one has the period \
                 {period}, which does not divide the cycle of {duration}; change a duration or the \
                 period, or remove gait.periodic"
            )),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Why a pair of spheres with these keys is refused; nothing if it is not.
    fn problem(force: &str, keys: &str) -> String {
        let text = format!(
            r#"
            {keys}
            gait.periodic = true
            fluid = {{ density = 1, inertia = "unsteady" }}
            domain = {{ kind = "ball", radius = 12 }}
            bodies = [
                {{ name = "a", radius = 1, position = [-2, 0, 0], force = {force} }},
                {{ name = "b", radius = 1, position = [2, 0, 0] }},
            ]
            "#
        );
        Scene::parse(&text).map_or_else(|error| error.to_string(), |_| String::new())
    }

    #[test]
    fn gaits_without_a_periodic_state_are_refused_at_reading() {
        let gait = |joint: &str, phases: &str| {
            let link = format!("{{ name = \"arm\", body = \"b\", to = \"a\", {joint} }}");
            problem(
                "[0, 0, 0]",
                &format!("links = [{link}]\ngait.phases = [{phases}]"),
            )
        };
        let slide = "joint = \"slide\"";
        let open = gait(slide, "{ link = \"arm\", length = 3.5 }");
        assert!(open.contains("\"arm\" changes by -0.5"), "{open}");
        let there_and_back = "{ link = \"arm\", length = 3.5 }, { link = \"arm\", length = 4 }";
        assert_eq!(gait(slide, there_and_back), "");
        let hinge = "joint = \"hinge\", axis = [0, 0, 1]";
        let whole = gait(hinge, "{ link = \"arm\", length = 6.283185307179586 }");
        assert!(whole.contains("whole turns, as \"arm\" does"), "{whole}");
    }

    #[test]
    fn loads_whose_periods_do_not_divide_the_cycle_are_refused_at_reading() {
        let loaded = |period: f64| {
            let force = format!("{{ amplitude = [1, 0, 0], period = {period} }}");
            problem(&force, "gait.phases = [{ duration = 1.2 }]")
        };
        assert_eq!(loaded(0.4), "");
        for period in [0.5, 2.4] {
            let problem = loaded(period);
            let expected = format!("{period}, which does not divide the cycle of 1.2");
            assert!(problem.contains(&expected), "{problem}");
        }
    }
}
