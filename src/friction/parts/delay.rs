//! The velocity a moment ago.

use serde::{Deserialize, Serialize};

use crate::friction::law::Contact;
use crate::friction::parts::list::List;
use crate::numbers::{Scalar, Tangent, Varying};

/// No three points are within this fraction of the delay.
const RESOLUTION: usize = 64;
/// Points within the delay, one before it, and one at its end.
const CAPACITY: usize = 2 * RESOLUTION + 4;
/// Extra time that points are kept, as a fraction of the delay: too short for any more of them.
const SPARE: f64 = 0.25 / RESOLUTION as f64;
/// Distance of two points, as a fraction of the delay, below which rounding keeps them apart.
const ROUNDING: f64 = 1e-9;
/// Longest step of the solver as a fraction of the delay.
const LONGEST_STEP: f64 = 0.25;

/// A point of the motion. The velocity may jump there if it is prescribed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Point<S> {
    time: S,
    position: S,
    /// Velocity on arrival.
    before: S,
    /// Velocity on departure.
    after: S,
}

impl<S: Varying> Point<S> {
    fn new(contact: &Contact<S>) -> Self {
        let &Contact { time, position, velocity, .. } = contact;
        Self { time, position, before: velocity, after: velocity }
    }

    /// The velocity in m/s at a time in s between two points.
    fn between<T: Scalar<Held = S>>([from, to]: [Self; 2], time: T) -> T {
        let length = to.time - from.time;
        let mean = (to.position - from.position) / length;
        let share = (time - T::held(from.time)) / T::held(length);
        let rest = -share + 1.0;
        let bend = mean * 6.0 - (from.after + to.before) * 3.0;
        rest * T::held(from.after) + share * T::held(to.before) + share * rest * T::held(bend)
    }
}

/// A delay line of the velocity, which remembers points of the motion.
///
/// Between two points the velocity is the parabola that has their velocities and covers the path between their
/// positions: an error of third order in their distance, and none from kinks of the velocity at the points. Points are
/// the ends of accepted steps; of three within a 64th of the delay the middle one is dropped: faster motion is
/// smoothed, its path kept. Two points are at most a 32nd of the delay apart where steps are shorter
/// than a 64th, so that an oscillation of frequency `f` comes back with an error of at most
/// `0.0081*(2*pi*f*delay/32)^3 = 6.2e-5*(f*delay)^3` of its amplitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "", deserialize = ""))]
pub struct DelayLine<S: Varying> {
    points: List<Point<S>, CAPACITY>,
}

/// Longest step in s that the solver may take: the delayed time must not be beyond the last point.
pub fn max_step(delay: f64) -> f64 {
    if delay > 0.0 { LONGEST_STEP * delay } else { f64::INFINITY }
}

impl<H: Varying> DelayLine<H> {
    /// A line on which the velocity has always been the present one.
    pub fn new(contact: &Contact<H>) -> Self {
        Self { points: List::new([Point::new(contact)]) }
    }

    /// The velocity in m/s a delay before the contact's time.
    pub fn velocity<S: Scalar<Held = H>>(&self, contact: &Contact<S>, delay: Tangent) -> S {
        if delay <= 0.0 {
            return contact.velocity;
        }
        let time = contact.time - delay;
        let Some(next) = self.points.iter().position(|point| point.time.value() > time.value()) else {
            return self.points.last().map_or(S::zero(), |point| S::held(point.after));
        };
        if next == 0 {
            return S::held(self.points[0].before);
        }
        let [from, to] = [self.points[next - 1], self.points[next]];
        let velocity = Point::between([from, to], time);
        if !H::VARIES || (to.time - from.time).value() > ROUNDING * delay.value {
            return velocity;
        }
        // Where the delay is a multiple of the steps, two points may differ by rounding alone. The velocity between such points is the
        // velocity at either; its slope is taken between the points around both.
        let around = [next.saturating_sub(2), (next + 1).min(self.points.len() - 1)];
        Point::between(around.map(|place| self.points[place]), time).chain(velocity.value(), 1.0)
    }

    /// Takes in the present point.
    pub fn follow(&mut self, contact: &Contact<H>, delay: Tangent) {
        let delay = delay.value;
        let point = Point::new(contact);
        let count = self.points.len();
        match &mut *self.points {
            [.., last] if last.time.value() >= point.time.value() => last.after = point.after,
            [.., before, last]
                if count == CAPACITY || (point.time - before.time).value() < delay / RESOLUTION as f64 =>
            {
                *last = point
            }
            _ => self.points.push(point),
        }
        // Points are kept a little longer than they are needed: steps that divide the delay would otherwise end just where a point
        // is forgotten, and there the line has no derivative by the time of that point.
        let begin = contact.time.value() - delay * (1.0 + SPARE);
        let oldest = self.points.iter().skip(1).take_while(|next| next.time.value() <= begin).count();
        self.points.remove(0..oldest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::law::Drive;
    use crate::numbers::Real;

    const DELAY: Tangent = Tangent::still(5e-3);

    fn contact(time: f64, position: f64, velocity: f64) -> Contact<Real> {
        Contact { time, position, velocity, applied: 0.0, level: 1.0, drive: Drive::Force }.still()
    }

    fn velocity(line: &DelayLine<Real>, contact: &Contact<Real>) -> f64 {
        line.velocity(contact, DELAY).value
    }

    /// Largest deviation from the delayed motion `x = 1 - cos(w*t)` for steps of a size.
    fn worst(w: f64, step: f64) -> f64 {
        let motion = |time: f64| contact(time, 1.0 - (w * time).cos(), w * (w * time).sin());
        let mut line = DelayLine::new(&motion(0.0));
        let mut worst = 0.0f64;
        for index in 1..2000 {
            let time = f64::from(index) * step;
            line.follow(&motion(time), DELAY);
            for share in [0.0, 0.3, 0.7] {
                let now = motion(time + share * step);
                let expected = motion((now.time.value - DELAY.value).max(0.0)).velocity.value;
                worst = worst.max((velocity(&line, &now) - expected).abs());
            }
        }
        worst
    }

    /// The error of a parabola with the right mean is at most 0.0081 times the third derivative and step cubed.
    #[test]
    fn smooth_motion_comes_back_with_an_error_of_third_order() {
        let w: f64 = 100.0;
        for step in [1e-3, 2e-4, 1e-4] {
            assert!(worst(w, step) < 0.0081 * w.powi(4) * step.powi(3) + 1e-9, "{}", worst(w, step));
        }
    }

    #[test]
    fn steps_of_any_size_fit_and_the_line_stays_short() {
        let widest = 2.0 * DELAY.value / RESOLUTION as f64;
        assert!(worst(100.0, 1e-6) < 0.0081 * 1e8 * widest.powi(3) + 1e-9);
    }

    /// The velocity of a prescribed motion may jump; the path tells nothing wrong before or after.
    #[test]
    fn jump_comes_back_as_a_jump() {
        let mut line = DelayLine::new(&contact(0.0, 0.0, 1.0));
        line.follow(&contact(1e-3, 1e-3, 1.0), DELAY);
        line.follow(&contact(1e-3, 1e-3, -1.0), DELAY);
        line.follow(&contact(2e-3, 0.0, -1.0), DELAY);
        assert_eq!(velocity(&line, &contact(DELAY.value + 0.9e-3, 0.0, 0.0)), 1.0);
        assert_eq!(velocity(&line, &contact(DELAY.value + 1.1e-3, 0.0, 0.0)), -1.0);
    }
}
