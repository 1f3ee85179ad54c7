//! Four on/off valves, whose coils are switched one by one at any time.

use serde::{Deserialize, Serialize};

use super::pulses::Armature;
use crate::numbers::{Scalar, Tangent, Varying};
use crate::pneumatics::actuation::COILS;
use crate::system::Sample;

/// Number of coils whose valves feed a chamber: their openings are continuous states.
const FEEDING: usize = 2;

/// Motion of the armatures. The valves that feed the chambers, the first and the third, have states for their openings; the
/// openings of those that vent them follow from the time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory<S> {
    valves: [Valve<S>; COILS],
}

/// A valve with its armature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Valve<S> {
    /// Whether it opens or is open.
    opens: bool,
    /// Opening where it rests, or where its motion began.
    opening: S,
    /// Time in s at which its motion began.
    since: S,
    /// Time in s at which it turns to the other end, if it does: its coil is switched and the delay has not passed.
    turns: Option<S>,
    /// Time in s at which it arrives, if it moves.
    arrives: Option<S>,
}

/// Next event.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Happening {
    Arrival(usize),
    Turn(usize),
}

impl<S: Scalar> Default for Memory<S> {
    /// All valves closed, and their coils off.
    fn default() -> Self {
        let closed = Valve { opens: false, opening: S::zero(), since: S::zero(), turns: None, arrives: None };
        Self { valves: [closed; COILS] }
    }
}

impl<S: Scalar> Valve<S> {
    fn is_coil_on(&self) -> bool {
        self.opens != self.turns.is_some()
    }

    /// Rate of the opening in 1/s.
    fn rate(&self, armature: &Armature) -> Tangent {
        match (self.arrives.is_some(), self.opens) {
            (false, _) => Tangent::still(0.0),
            (true, true) => 1.0 / armature.travel,
            (true, false) => -1.0 / armature.travel,
        }
    }
}

impl<S: Varying> Memory<S> {
    /// Lets the coils follow their commands at a time in s. A coil that is switched back within its delay does nothing, and
    /// neither does one that is switched back as its delay ends.
    pub fn command(&mut self, armature: &Armature, time: S, coils: [bool; COILS]) {
        for (valve, is_on) in self.valves.iter_mut().zip(coils) {
            if is_on == valve.is_coil_on() {
                continue;
            }
            let delay = if is_on { armature.opening_delay } else { armature.closing_delay };
            valve.turns = match valve.turns {
                Some(_) => None,
                None => Some(time + S::along(delay)),
            };
        }
    }

    /// Openings at a time in s of the valves that vent the chambers.
    pub fn venting<T: Scalar<Held = S>>(&self, armature: &Armature, time: T) -> [T; FEEDING] {
        [1, 3].map(|place| {
            let valve: &Valve<S> = &self.valves[place];
            let opening = T::held(valve.opening);
            match valve.arrives {
                None => opening,
                Some(_) => opening + (time - T::held(valve.since)) * T::along(valve.rate(armature)),
            }
        })
    }

    /// Rates in 1/s of the openings of the valves that feed the chambers.
    pub fn rates(&self, armature: &Armature) -> [Tangent; FEEDING] {
        [0, 2].map(|place: usize| self.valves[place].rate(armature))
    }

    /// Whether an armature is on its way.
    pub fn is_moving(&self) -> bool {
        self.valves.iter().any(|valve| valve.arrives.is_some())
    }

    /// When something happens next.
    pub fn next(&self) -> Sample<S> {
        self.next_happening().map_or_else(Sample::never, |(sample, _)| sample)
    }

    /// The next happening; of several at one time arrivals come first, so that an armature turns from where it is.
    fn next_happening(&self) -> Option<(Sample<S>, Happening)> {
        let places = || self.valves.iter().enumerate();
        let arrivals = places()
            .filter_map(|(place, valve)| valve.arrives.map(|time| (Sample::exact(time), Happening::Arrival(place))));
        let turns = places().filter_map(|(place, valve)| {
            // On a communication point at the end of the delay, but for rounding, the coil may still be switched back.
            let near = |time: S| Sample::near(time, ROUNDINGS * f64::EPSILON * time.value().abs());
            valve.turns.map(|time| (near(time), Happening::Turn(place)))
        });
        let earlier = |first: (Sample<S>, Happening), other: (Sample<S>, Happening)| {
            if other.0.time.value() < first.0.time.value() { other } else { first }
        };
        arrivals.chain(turns).reduce(earlier)
    }

    /// Lets the next thing happen: changes the openings of the valves that feed the chambers, and the motions of all.
    pub fn happen(&mut self, armature: &Armature, feeding: &mut [S; FEEDING]) {
        let Some((_, happening)) = self.next_happening() else { return };
        let (place, opening) = match happening {
            Happening::Turn(place) => (place, self.turn(armature, feeding, place)),
            Happening::Arrival(place) => {
                let valve = &mut self.valves[place];
                valve.arrives = None;
                (place, S::of(f64::from(valve.opens)))
            }
        };
        self.valves[place].opening = opening;
        if let Some(chamber) = fed_by(place) {
            feeding[chamber] = opening;
        }
    }

    /// Turns an armature to its other end, and returns the opening from which it moves.
    fn turn(&mut self, armature: &Armature, feeding: &[S; FEEDING], place: usize) -> S {
        let time = self.valves[place].turns.expect("an armature that turns");
        let opening = fed_by(place).map_or_else(|| self.venting(armature, time)[place / 2], |chamber| feeding[chamber]);
        let valve = &mut self.valves[place];
        (valve.opens, valve.since, valve.turns) = (!valve.opens, time, None);
        let end = S::of(f64::from(valve.opens));
        let duration = (end - opening).abs() * S::along(armature.travel);
        valve.arrives = (duration.value() > 0.0).then(|| time + duration);
        if valve.arrives.is_some() { opening } else { end }
    }

    /// Whether coils can have left it.
    pub fn is_sound(&self) -> bool {
        self.valves.iter().all(|valve| {
            let times = [Some(valve.since), valve.turns, valve.arrives].into_iter().flatten();
            // A motion that turns back begins where the time says, but for rounding.
            (-1e-9..=1.0 + 1e-9).contains(&valve.opening.value()) && times.map(S::value).all(f64::is_finite)
        })
    }
}

/// The chamber that the valve in a place feeds; the others vent one.
fn fed_by(place: usize) -> Option<usize> {
    place.is_multiple_of(2).then_some(place / 2)
}

/// Roundings of a time at which a delay ends: of the clocks of importer and run, their difference and the sum with the delay.
const ROUNDINGS: f64 = 8.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;

    /// Opens 20 ms after its coil is on, closes 30 ms after it is off, moves for 10 ms.
    const ARMATURE: Armature = armature(0.02, 0.03, 0.01);

    const fn armature(opening_delay: f64, closing_delay: f64, travel: f64) -> Armature {
        let still = Tangent::still;
        Armature { opening_delay: still(opening_delay), closing_delay: still(closing_delay), travel: still(travel) }
    }

    /// Times in ms and the opening of a valve after everything that happens where its coil is switched at times in s, first on.
    fn course(armature: Armature, place: usize, switched: &[f64]) -> Vec<(f64, f64)> {
        let (mut memory, mut feeding) = (Memory::<Real>::default(), [Real::of(0.0); FEEDING]);
        let (mut last, mut course, mut coils) = (0.0, Vec::new(), [false; COILS]);
        let moved = |memory: &Memory<Real>, feeding: [Real; FEEDING], duration: f64| {
            let rates = memory.rates(&armature);
            [0, 1].map(|chamber| feeding[chamber] + Real::of(rates[chamber].value * duration))
        };
        for end in switched.iter().copied().chain([1e3]) {
            while memory.next().is_before(end) {
                let time = memory.next().time.value;
                feeding = moved(&memory, feeding, time - last);
                last = time;
                memory.happen(&armature, &mut feeding);
                let venting: [Real; FEEDING] = memory.venting(&armature, Real::of(time));
                let opening = fed_by(place).map_or(venting[place / 2], |chamber| feeding[chamber]).value;
                let rounded = |value: f64, by: f64| (value * by).round() / by;
                course.push((rounded(time * 1e3, 1e6), rounded(opening, 1e9)));
            }
            feeding = moved(&memory, feeding, end - last);
            last = end;
            coils[place] = !coils[place];
            memory.command(&armature, Real::of(end), coils);
        }
        course
    }

    #[test]
    fn armature_follows_its_coil_after_a_delay() {
        for valve in 0..COILS {
            let found = course(ARMATURE, valve, &[0.0, 0.06]);
            assert_eq!(found, [(20.0, 0.0), (30.0, 1.0), (90.0, 1.0), (100.0, 0.0)], "{valve}");
        }
    }

    #[test]
    fn pulse_and_pause_that_are_not_longer_than_the_delay_do_nothing() {
        assert_eq!(course(ARMATURE, 0, &[0.01, 0.029]), []);
        assert_eq!(course(ARMATURE, 0, &[0.01, 0.03]), [], "as long as the delay");
        let pause = course(ARMATURE, 2, &[0.0, 0.05, 0.079]);
        assert_eq!(pause, [(20.0, 0.0), (30.0, 1.0)]);
        for tenths in 1..200 {
            let start = f64::from(tenths) * 0.1;
            assert_eq!(course(ARMATURE, 0, &[start, start + 0.02]), [], "from {start} s");
        }
    }

    /// Its coil is off from 21 ms on: it goes on to the end of the delay, and turns back there.
    #[test]
    fn armature_turns_back_on_its_way() {
        let found = course(armature(0.02, 0.002, 0.01), 1, &[0.0, 0.021]);
        assert_eq!(found, [(20.0, 0.0), (23.0, 0.3), (26.0, 0.0)]);
    }

    #[test]
    fn armature_without_travel_jumps() {
        assert_eq!(course(armature(0.0, 0.0, 0.0), 3, &[0.01, 0.02]), [(10.0, 1.0), (20.0, 0.0)]);
    }

    /// Both valves of a chamber on their way at the same time, each from its own beginning.
    #[test]
    fn armatures_move_side_by_side() {
        let (mut memory, mut feeding) = (Memory::<Real>::default(), [Real::of(0.0); FEEDING]);
        let armature = armature(0.0, 0.0, 0.01);
        memory.command(&armature, Real::of(0.0), [true, false, false, false]);
        memory.happen(&armature, &mut feeding);
        memory.command(&armature, Real::of(4e-3), [true, true, false, false]);
        memory.happen(&armature, &mut feeding);
        let [first, second]: [Real; FEEDING] = memory.venting(&armature, Real::of(7e-3));
        assert!((first.value - 0.3).abs() < 1e-12 && second.value == 0.0, "{first:?} {second:?}");
        assert_eq!(memory.rates(&armature).map(|rate| rate.value), [100.0, 0.0]);
        assert!((memory.next().time.value - 0.01).abs() < 1e-12);
    }

    #[test]
    fn memories_that_no_coils_leave_are_not_sound() {
        let sound = Memory::<Real>::default();
        assert!(sound.is_sound());
        let with = |valve: Valve<Real>| Memory { valves: [valve, sound.valves[1], sound.valves[2], sound.valves[3]] };
        let (closed, never) = (sound.valves[0], Some(Real::of(f64::NAN)));
        for memory in [
            with(Valve { opening: Real::of(1.1), ..closed }),
            with(Valve { opening: Real::of(f64::NAN), ..closed }),
            with(Valve { turns: never, ..closed }),
            with(Valve { arrives: never, ..closed }),
        ] {
            assert!(!memory.is_sound(), "{memory:?}");
        }
    }
}
