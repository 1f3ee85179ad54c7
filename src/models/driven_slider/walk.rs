//! The slider between two harmonic attractors: a convolution and a random walk.
//!
//! ```text
//! stuck:       v_d*cos(w*t), the velocity of the tray
//! stick-free:  v_sf = 2*v_d/(w*t_mx)^2*A*cos(w*t - phi)          [m/s]
//!              A = sqrt(a^2 + b^2),  tan(phi) = b/a,  a = 1 - cos(w*t_mx),  b = w*t_mx - sin(w*t_mx)
//!              t_mx = flightFactor*v_d/(mu_dyn*g)                 [s]
//! walk:        n' = n + sgn(n_sf - n) with probability chi, n + sgn(n_tray - n) otherwise; the velocity is n*dv
//!              dv = mu_dyn*g*dt,   chi = (mu_stat - mu_dyn)/mu_stat*v_d*w/g
//! ```
//!
//! The stick-free velocity is the tray's, convolved with the velocity of a slider that comes to rest on a tray at rest.
//! The walk chooses one of the two attractors by chance at every time step `dt` and moves towards it by at most `dv`.
//!
//! # Validity
//! The source prints the walk with the attractors exchanged and its second jump as `rnd(chi)`, which contradicts the
//! limits it states in words: a vanishing `chi` follows the tray, `chi > 1` the stick-free attractor. This is the
//! walk of the words, with jumps of one as the source takes them. In each limit the attractor is followed as far as a
//! slope of `mu_dyn*g` allows.
//!
//! # Source
//! Harmonically driven slider: Markovian dynamics between two limiting attractors, eqs. 1 to 7.

use serde::{Deserialize, Serialize};

use crate::mechanics::GRAVITY;
use crate::numbers::random;
use crate::numbers::{Number, Real, Scalar, sign};
use crate::variables::Tunable;

/// A harmonic velocity in m/s: `amplitude*cos(w*t - phase)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// Amplitude in m/s.
    pub amplitude: Tunable,
    /// Angular frequency in rad/s.
    pub frequency: Tunable,
    /// Phase delay in rad.
    pub phase: Tunable,
}

impl Harmonic {
    /// Velocity in m/s at a time in s.
    pub fn at<S: Scalar>(&self, time: S) -> S {
        (time * self.frequency - self.phase).cos() * self.amplitude
    }

    /// Its convolution with the deceleration of a slider over a flight time in s.
    pub fn stick_free(&self, flight_time: Tunable) -> Self {
        let angle = flight_time * self.frequency;
        let half = (angle * 0.5).sin();
        let a = half * 2.0 * half;
        // Below 0.01 the difference of angle and sine is taken from its series, exact to rounding there.
        let b = if angle.value < 0.01 {
            angle * angle * angle / 6.0 * (-angle * angle / 20.0 + 1.0)
        } else {
            angle - angle.sin()
        };
        if angle.value == 0.0 {
            return *self;
        }
        let length = (a * a + b * b).sqrt();
        let ratio = length * 2.0 / (angle * angle);
        let turn = |i: usize| (a.value * b.slopes[i] - b.value * a.slopes[i]) / (length.value * length.value);
        let phase = Tunable { value: libm::atan2(b.value, a.value), slopes: std::array::from_fn(turn) };
        Self { amplitude: self.amplitude * ratio, phase: self.phase + phase, ..*self }
    }
}

/// The random walk for given parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walk {
    /// The attractor of the stuck slider.
    pub tray: Harmonic,
    /// The attractor of the slider that never sticks.
    pub free: Harmonic,
    /// Probability of a move towards the stick-free attractor.
    pub chi: Tunable,
    /// Time step in s.
    pub time_step: Tunable,
    /// Velocity step in m/s.
    pub velocity_step: Tunable,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Where the walk is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Number of the next time step since time 0.
    next: f64,
    /// Velocity in velocity steps.
    velocity: f64,
    generator: u64,
}

impl State {
    /// The state of no walk.
    pub const AT_REST: Self = Self { next: 0.0, velocity: 0.0, generator: 0 };

    /// Whether a state is one of a walk.
    pub fn is_finite(&self) -> bool {
        self.next.is_finite() && self.velocity.is_finite()
    }
}

impl Walk {
    /// The walk of a slider with a static and a dynamic friction coefficient between two attractors.
    pub fn new([tray, free]: [Harmonic; 2], [statics, dynamic]: [Tunable; 2], time_step: Tunable, seed: u64) -> Self {
        let chi = (statics - dynamic) / statics * tray.amplitude * tray.frequency / GRAVITY;
        Self { tray, free, chi, time_step, velocity_step: dynamic * GRAVITY * time_step, seed }
    }

    /// The start of a walk on the tray.
    pub fn start(&self, time: f64) -> State {
        State { next: self.number_after(time), velocity: self.steps(&self.tray, time), generator: self.seed }
    }

    /// Time in s of the next step.
    pub fn next_step(&self, state: &State) -> f64 {
        state.next * self.time_step.value
    }

    /// Takes the step that is due.
    pub fn step(&self, state: &mut State) {
        let time = self.next_step(state);
        let attractor = if random::uniform(&mut state.generator) <= self.chi.value { &self.free } else { &self.tray };
        state.velocity += sign(self.steps(attractor, time) - state.velocity);
        state.next = (state.next + 1.0).max(self.number_after(time));
    }

    /// Velocity in m/s.
    pub fn velocity(&self, state: &State) -> Tunable {
        self.velocity_step * state.velocity
    }

    /// The velocity of an attractor, rounded to velocity steps.
    fn steps(&self, attractor: &Harmonic, time: f64) -> f64 {
        libm::round(attractor.at(Real::of(time)).value / self.velocity_step.value)
    }

    fn number_after(&self, time: f64) -> f64 {
        libm::floor(time / self.time_step.value * (1.0 + f64::EPSILON)) + 1.0
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const fn still(value: f64) -> Tunable {
        Tunable::still(value)
    }

    const TRAY: Harmonic = Harmonic { amplitude: still(0.04), frequency: still(TAU * 20.0), phase: still(0.0) };

    #[test]
    fn state_with_one_value_that_is_not_finite_is_no_walk() {
        assert!(State::AT_REST.is_finite());
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(!State { next: bad, ..State::AT_REST }.is_finite());
            assert!(!State { velocity: bad, ..State::AT_REST }.is_finite());
        }
    }

    /// The integral that defines the convolution, by Simpson's rule.
    fn convolved(flight_time: f64, time: f64) -> f64 {
        const PARTS: usize = 2000;
        let integrand = |s: f64| (1.0 - s / flight_time) * TRAY.at(Real::of(time - s)).value;
        let h = flight_time / PARTS as f64;
        let weight = |i: usize| if i == 0 || i == PARTS { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
        2.0 / flight_time * (0..=PARTS).map(|i| weight(i) * integrand(i as f64 * h)).sum::<f64>() * h / 3.0
    }

    #[test]
    fn stick_free_velocity_is_the_convolution() {
        for flight_time in [1e-6, 6e-5, 1e-3, 0.0127, 0.05, 0.3] {
            let free = TRAY.stick_free(still(flight_time));
            for time in [0.0, 0.003, 0.017] {
                let error = free.at(Real::of(time)).value - convolved(flight_time, time);
                assert!(error.abs() < 1e-10, "{flight_time} s: {error}");
            }
        }
    }

    #[test]
    fn without_flight_the_slider_stays_with_the_tray_and_in_endless_flight_it_rests() {
        assert_eq!(TRAY.stick_free(still(0.0)), TRAY);
        assert!(TRAY.stick_free(still(1e4)).amplitude.value < 1e-7);
    }

    /// Runs two seconds; returns the largest distance from an attractor in velocity steps after the first.
    fn distance(walk: &Walk, attractor: &Harmonic) -> f64 {
        let mut state = walk.start(0.0);
        let mut largest = 0.0f64;
        while walk.next_step(&state) < 2.0 {
            let time = walk.next_step(&state);
            walk.step(&mut state);
            if time > 1.0 {
                largest = largest.max(
                    (walk.velocity(&state) - attractor.at(Real::of(time)).value).value.abs() / walk.velocity_step.value,
                );
            }
        }
        largest
    }

    /// Steps are at whole multiples of 0.1 ms, whenever a run starts; one that is due at its start is over.
    #[test]
    fn first_step_is_the_next_multiple_of_the_time_step() {
        let walk = Walk::new([TRAY, TRAY.stick_free(still(0.02))], [0.4, 0.3].map(still), still(1e-4), 1);
        for (time, next) in
            [(0.0, 1.0), (0.5e-4, 1.0), (1e-4, 2.0), (0.0123, 124.0), (0.012_345, 124.0), (2.0, 20_001.0)]
        {
            assert_eq!(walk.start(time).next, next, "from {time} s");
        }
    }

    /// Rounding is half a step, and the walk is at most a step behind.
    #[test]
    fn vanishing_chi_follows_the_tray() {
        let tray = Harmonic { amplitude: still(0.02), ..TRAY };
        let walk = Walk::new([tray, tray.stick_free(still(0.02))], [0.32, 0.32].map(still), still(1e-4), 1);
        assert_eq!(walk.chi.value, 0.0);
        assert!(distance(&walk, &walk.tray) <= 1.5);
        assert!(distance(&walk, &walk.free) > 5.0);
    }

    /// With `mu_dyn = 1.5` the stick-free attractor of a tray at 1.35 g is not too steep to be followed.
    #[test]
    fn chi_above_one_follows_the_stick_free_attractor() {
        let tray = Harmonic { amplitude: 1.35 * GRAVITY / TRAY.frequency, ..TRAY };
        let walk = Walk::new(
            [tray, tray.stick_free(tray.amplitude / (1.5 * GRAVITY))],
            [15.0, 1.5].map(still),
            still(1e-4),
            1,
        );
        assert!(walk.chi.value > 1.0);
        assert!(distance(&walk, &walk.free) <= 1.5);
        assert!(distance(&walk, &walk.tray) > 5.0);
    }
}
