//! The velocity a moment ago.

use serde::{Deserialize, Serialize};

use super::Contact;
use super::list::List;
use crate::scalar::Scalar;

/// Points that the line keeps per delay.
const RESOLUTION: usize = 64;
/// Points within the delay, one before it, one at its end, and one that replaces another.
const CAPACITY: usize = RESOLUTION + 4;
/// Longest step of the solver as a fraction of the delay.
const LONGEST_STEP: f64 = 0.25;

/// A point of the motion. The velocity may jump there if it is prescribed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Point {
    time: f64,
    position: f64,
    /// Velocity on arrival.
    before: f64,
    /// Velocity on departure.
    after: f64,
}

impl Point {
    fn new(contact: &Contact<f64>) -> Self {
        let &Contact { time, position, velocity, .. } = contact;
        Self { time, position, before: velocity, after: velocity }
    }
}

/// A delay line of the velocity, which remembers points of the motion.
///
/// Between two points the velocity is the parabola that has their velocities and covers the path between their
/// positions: an error of third order in their distance, and none from kinks of the velocity at the points. Points are
/// the ends of accepted steps, except that points closer than a 64th of the delay to the one before the last are
/// replaced by their successor: what is faster than that is smoothed, its path kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DelayLine {
    points: List<Point, CAPACITY>,
}

impl DelayLine {
    /// A line on which the velocity has always been the present one.
    pub fn new(contact: &Contact<f64>) -> Self {
        Self { points: List::new([Point::new(contact)]) }
    }

    /// Longest step in s that the solver may take: the delayed time must not be beyond the last point.
    pub fn max_step(delay: f64) -> f64 {
        if delay > 0.0 { LONGEST_STEP * delay } else { f64::INFINITY }
    }

    /// The velocity in m/s a delay before the contact's time.
    pub fn velocity<S: Scalar>(&self, contact: &Contact<S>, delay: f64) -> S {
        if delay <= 0.0 {
            return contact.velocity;
        }
        let time = contact.time - delay;
        let Some(next) = self.points.iter().position(|point| point.time > time.value()) else {
            return S::constant(self.points.last().map_or(0.0, |point| point.after));
        };
        if next == 0 {
            return S::constant(self.points[0].before);
        }
        let (from, to) = (self.points[next - 1], self.points[next]);
        let length = to.time - from.time;
        let mean = (to.position - from.position) / length;
        let share = (time - from.time) / length;
        let rest = -share + 1.0;
        rest * from.after + share * to.before + share * rest * (6.0 * mean - 3.0 * (from.after + to.before))
    }

    /// Takes in the present point.
    pub fn follow(&mut self, contact: &Contact<f64>, delay: f64) {
        let point = Point::new(contact);
        let count = self.points.len();
        match &mut *self.points {
            [.., last] if last.time >= point.time => last.after = point.velocity(),
            [.., before, last] if last.time - before.time < delay / RESOLUTION as f64 => *last = point,
            _ if count < CAPACITY => self.points.push(point),
            _ => {}
        }
        let oldest = self.points.iter().skip(1).take_while(|next| next.time <= contact.time - delay).count();
        self.points.remove_first(oldest);
    }
}
