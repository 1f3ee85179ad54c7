//! Pulses of a driver, and armatures that follow them after a delay, at a constant speed.

use serde::{Deserialize, Serialize};

use crate::numbers::{Scalar, Tangent, Varying};
use crate::system::Sample;

/// A driver that turns the duty cycles of two coils into pulses of a fixed frequency.
///
/// ```text
/// period k:  from k/f on;  the duty cycles u that hold for it are taken at its beginning
/// coil on:   from k/f to k/f + u/f
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driver {
    /// Frequency `f` in Hz.
    pub frequency: Tangent,
    /// State of the armatures.
    pub armature: Armature,
}

/// Motion of an armature after its coil.
///
/// ```text
/// coil on  for longer than the opening delay: dy/dt = +1/travel until y = 1
/// coil off for longer than the closing delay: dy/dt = -1/travel until y = 0
/// ```
///
/// A pulse, or a pause, that is not longer does nothing. One that is as long as the delay but for some roundings is as long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Armature {
    /// Time in s that the coil must be on until the armature opens.
    pub opening_delay: Tangent,
    /// Time in s that the coil must be off until the armature closes.
    pub closing_delay: Tangent,
    /// Time in s from one end to the other.
    pub travel: Tangent,
}

/// Position of the driver in its period, and motion of the armatures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory<S> {
    /// Number of the period that begins next.
    next: u64,
    /// Duty cycles of the present period.
    duties: [S; 2],
    /// When the pulses of the present period end, unless they last on.
    falls: [Option<Moment<S>>; 2],
    motions: [Motion<S>; 2],
}

/// A moment, counted from the beginning of a period: what lies between two of them is known to some roundings of itself,
/// however late in a run they are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Moment<S> {
    /// Number of the period.
    period: u64,
    /// Time in s since its beginning.
    after: S,
}

/// An armature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Motion<S> {
    /// Whether it opens or is open.
    opens: bool,
    /// When it turns to the other end, if it does.
    turns: Option<Moment<S>>,
    /// When it arrives, if it moves.
    arrives: Option<Moment<S>>,
}

/// Next event.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Happening {
    Arrival(usize),
    Turn(usize),
    Period,
}

impl<S: Scalar> Default for Memory<S> {
    /// Both valves closed, before the first period.
    fn default() -> Self {
        let still = Motion { opens: false, turns: None, arrives: None };
        Self { next: 0, duties: [S::zero(); 2], falls: [None; 2], motions: [still; 2] }
    }
}

impl<S: Scalar> Moment<S> {
    /// The beginning of a period.
    fn beginning(period: u64) -> Self {
        Self { period, after: S::zero() }
    }

    /// The moment a duration in s later.
    fn later(self, duration: S) -> Self {
        Self { after: self.after + duration, ..self }
    }
}

impl<S: Scalar> Memory<S> {
    /// Duty cycles of the present period.
    pub fn duties(&self) -> [S; 2] {
        self.duties
    }

    /// Whether an armature is on its way.
    pub fn is_moving(&self) -> bool {
        self.motions.iter().any(|motion| motion.arrives.is_some())
    }

    /// Whether a driver can have left it.
    pub fn is_sound(&self) -> bool {
        let moments = self.motions.iter().flat_map(|motion| [motion.turns, motion.arrives]).chain(self.falls);
        let is_later = |moment: Moment<S>| moment.after.value() >= 0.0 && moment.after.value().is_finite();
        self.duties.iter().all(|duty| (0.0..=1.0).contains(&duty.value())) && moments.flatten().all(is_later)
    }
}

impl Driver {
    /// When something happens next.
    pub fn next<S: Varying>(&self, memory: &Memory<S>) -> Sample<S> {
        self.next_happening(memory).0
    }

    /// Time in s of a moment.
    fn time<S: Scalar>(&self, moment: Moment<S>) -> S {
        moment.after + moment.period as f64 / self.frequency
    }

    /// Whether one moment is before another by more than rounding.
    fn is_before<S: Scalar>(&self, first: Moment<S>, second: Moment<S>) -> bool {
        /// Roundings of the voltage, the duty cycle, the times computed from it, and their difference. The first two are of
        /// the size of a whole period, however short the pulse.
        const ROUNDINGS: f64 = 8.0;
        let frequency = self.frequency.value;
        let periods = (second.period as f64 - first.period as f64) / frequency;
        let [first, second] = [first, second].map(|moment| moment.after.value());
        let magnitude = 1.0 / frequency + periods.abs() + first + second;
        periods + (second - first) > ROUNDINGS * f64::EPSILON * magnitude
    }

    /// The next happening. Of several at one time arrivals come first, so that a period finds the armatures where they are,
    /// and turns last, since a period that begins with a pulse ends a pause which is not longer than the delay.
    fn next_happening<S: Varying>(&self, memory: &Memory<S>) -> (Sample<S>, Happening) {
        let beginning = Moment::<S>::beginning(memory.next);
        let mut first = (Sample::periodic(self.time(beginning), 1.0 / self.frequency.value), Happening::Period);
        for (valve, motion) in memory.motions.iter().enumerate() {
            let turn = motion.turns.filter(|turn| self.is_before(*turn, beginning));
            for (moment, happening) in [(turn, Happening::Turn(valve)), (motion.arrives, Happening::Arrival(valve))] {
                let Some(time) = moment.map(|moment| self.time(moment)) else { continue };
                if time.value() <= first.0.time.value() {
                    first = (Sample::exact(time), happening);
                }
            }
        }
        first
    }

    /// Lets the next thing happen: moves openings to their ends, and takes the duty cycles where a period begins.
    pub fn happen<S: Varying>(&self, openings: &mut [S; 2], duties: [S; 2], memory: &mut Memory<S>) {
        match self.next_happening(memory).1 {
            Happening::Period => self.begin(duties, memory),
            Happening::Turn(valve) => {
                let (motion, opening) = (&mut memory.motions[valve], &mut openings[valve]);
                motion.opens = !motion.opens;
                let closes = memory.falls[valve].map(|fall| fall.later(S::along(self.armature.closing_delay)));
                let turn = std::mem::replace(&mut motion.turns, closes.filter(|_| motion.opens));
                let end = S::of(f64::from(motion.opens));
                let duration = (end - *opening).abs() * self.armature.travel;
                motion.arrives = turn.filter(|_| duration.value() > 0.0).map(|turn| turn.later(duration));
                if motion.arrives.is_none() {
                    *opening = end;
                }
            }
            Happening::Arrival(valve) => {
                let motion = &mut memory.motions[valve];
                (openings[valve], motion.arrives) = (S::of(f64::from(motion.opens)), None);
            }
        }
    }

    /// Begins a period with duty cycles.
    fn begin<S: Varying>(&self, duties: [S; 2], memory: &mut Memory<S>) {
        let beginning = Moment::beginning(memory.next);
        (memory.next, memory.duties) = (memory.next + 1, duties);
        memory.falls = duties.map(|duty| (duty.value() < 1.0).then(|| beginning.later(duty / self.frequency)));
        let Armature { opening_delay, closing_delay, .. } = self.armature;
        let [opening_delay, closing_delay] = [opening_delay, closing_delay].map(S::along);
        for ((motion, duty), fall) in memory.motions.iter_mut().zip(duties).zip(memory.falls) {
            let has_pulse = duty.value() > 0.0;
            // A coil that has been on through all of the last period has a turn pending, or none.
            let pending = motion.turns.map(|turn| if self.is_before(beginning, turn) { turn } else { beginning });
            let turn_after = |delay: S| pending.unwrap_or_else(|| beginning.later(delay));
            motion.turns = match (has_pulse, motion.opens) {
                (true, true) => fall.map(|fall| fall.later(closing_delay)),
                (true, false) => {
                    let turn = turn_after(opening_delay);
                    fall.is_none_or(|fall| self.is_before(turn, fall)).then_some(turn)
                }
                (false, true) => Some(turn_after(closing_delay)),
                (false, false) => None,
            };
        }
    }

    /// Rates in 1/s of the openings.
    pub fn rates<S: Scalar>(&self, memory: &Memory<S>) -> [Tangent; 2] {
        memory.motions.map(|motion: Motion<S>| match (motion.arrives.is_some(), motion.opens) {
            (false, _) => Tangent::still(0.0),
            (true, true) => 1.0 / self.armature.travel,
            (true, false) => -1.0 / self.armature.travel,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;

    /// 10 Hz; opens 20 ms after the coil is on, closes 30 ms after it is off, moves for 10 ms.
    const DRIVER: Driver = Driver { frequency: still(10.0), armature: armature(0.02, 0.03, 0.01) };

    const fn still(value: f64) -> Tangent {
        Tangent::still(value)
    }

    /// With delays of opening and closing, and a travel, in s.
    const fn armature(opening_delay: f64, closing_delay: f64, travel: f64) -> Armature {
        Armature { opening_delay: still(opening_delay), closing_delay: still(closing_delay), travel: still(travel) }
    }

    /// Times in ms and openings after everything that happens before a time in s, for a duty cycle.
    fn course(driver: Driver, duty: impl Fn(f64) -> f64, end: f64) -> Vec<(f64, [f64; 2])> {
        let (mut memory, mut openings) = (Memory::<Real>::default(), [Real::of(0.0); 2]);
        let (mut last, mut course) = (0.0, Vec::new());
        loop {
            let time = driver.next(&memory).time.value;
            if time > end {
                return course;
            }
            let rates = driver.rates(&memory);
            openings.iter_mut().zip(rates).for_each(|(opening, rate)| *opening = *opening + rate * (time - last));
            driver.happen(&mut openings, [duty(time), -duty(time)].map(|it| Real::of(it.max(0.0))), &mut memory);
            last = time;
            course.push(((time * 1e3).round(), openings.map(|opening| (opening.value * 1e9).round() / 1e9)));
        }
    }

    /// A pulse of 60 ms: on at 0, open from 20 to 30, off at 60, closed from 90 to 100.
    #[test]
    fn armature_follows_its_coil_after_a_delay() {
        let (shut, open) = ([0.0; 2], [1.0, 0.0]);
        let expected = [(0.0, shut), (20.0, shut), (30.0, open), (90.0, open), (100.0, shut), (100.0, shut)];
        assert_eq!(course(DRIVER, |_| 0.6, 0.1), expected);
        let other = course(DRIVER, |_| -0.6, 0.1);
        assert_eq!(other[2], (30.0, [0.0, 1.0]));
    }

    /// A pulse shorter than the opening delay opens nothing; a pause shorter than the closing delay closes nothing.
    #[test]
    fn short_pulse_and_short_pause_do_nothing() {
        assert!(course(DRIVER, |_| 0.19, 1.0).iter().all(|(_, openings)| *openings == [0.0; 2]));
        let long = course(DRIVER, |_| 0.71, 1.0);
        assert!(long.iter().skip(2).all(|(_, openings)| *openings == [1.0, 0.0]), "{long:?}");
    }

    /// A delay longer than a period: only a coil that is on without a pause opens, and only a long pause closes.
    #[test]
    fn delay_may_be_longer_than_a_period() {
        let armature = armature(0.25, 0.15, 0.01);
        let driver = Driver { armature, ..DRIVER };
        assert!(course(driver, |_| 0.9, 1.0).iter().all(|(_, openings)| *openings == [0.0; 2]));
        let found = course(driver, |time| if time < 0.35 { 1.0 } else { 0.0 }, 0.7);
        let moved: Vec<f64> = found.windows(2).filter(|pair| pair[0].1 != pair[1].1).map(|pair| pair[1].0).collect();
        assert_eq!(moved, [260.0, 560.0], "{found:?}");
        let cut = course(driver, |time| if time < 0.15 { 1.0 } else { 0.49 }, 1.0);
        assert!(cut.iter().all(|(_, openings)| *openings == [0.0; 2]), "{cut:?}");
    }

    /// Where the pulse ends while the armature is on its way, it goes on to the end of the delay, and turns back there.
    #[test]
    fn armature_turns_back_on_its_way() {
        let driver = Driver { armature: armature(0.02, 0.002, 0.01), ..DRIVER };
        let found = course(driver, |_| 0.21, 0.05);
        let expected = [(0.0, 0.0), (20.0, 0.0), (23.0, 0.3), (26.0, 0.0)];
        assert_eq!(found.iter().map(|(time, [first, _])| (*time, *first)).collect::<Vec<_>>(), expected);
    }

    /// Where the next pulse begins while the armature is on its way back, it turns from where it is, and has only that far to go.
    #[test]
    fn armature_that_opens_again_on_its_way_back_arrives_sooner() {
        let armature = armature(0.002, 0.0, 0.04);
        let found = course(Driver { armature, ..DRIVER }, |_| 0.9, 0.115);
        let expected = [(0.0, 0.0), (2.0, 0.0), (42.0, 1.0), (90.0, 1.0), (100.0, 0.75), (102.0, 0.7), (114.0, 1.0)];
        assert_eq!(found.iter().map(|(time, [first, _])| (*time, *first)).collect::<Vec<_>>(), expected);
    }

    /// It arrives at the very instant at which its coil lets it go: quite open by then, and as long on its way back. Binary
    /// fractions of a second, so that both are equal to the last bit.
    #[test]
    fn armature_that_turns_back_as_it_arrives_has_been_open() {
        let armature = armature(1.0 / 64.0, 0.0, 1.0 / 64.0);
        let found = course(Driver { frequency: still(8.0), armature }, |_| 0.25, 0.1);
        let expected = [(0.0, 0.0), (16.0, 0.0), (31.0, 1.0), (31.0, 1.0), (47.0, 0.0)];
        assert_eq!(found.iter().map(|(time, [first, _])| (*time, *first)).collect::<Vec<_>>(), expected);
    }

    /// No pulse at 0; one that never ends at 1; the sign decides which valve.
    #[test]
    fn ends_of_the_duty_cycle_have_no_pulses() {
        assert_eq!(course(DRIVER, |_| 0.0, 0.95).len(), 10);
        assert_eq!(course(DRIVER, |_| 1.0, 0.95).len(), 12);
        let swapped = course(DRIVER, |time| if time < 0.5 { 1.0 } else { -1.0 }, 0.95);
        assert_eq!(swapped.last(), Some(&(900.0, [0.0, 1.0])));
    }

    #[test]
    fn armature_without_travel_jumps() {
        let driver = Driver { armature: armature(0.0, 0.0, 0.0), ..DRIVER };
        let found = course(driver, |_| 0.5, 0.06);
        assert_eq!(found.iter().map(|(_, [first, _])| *first).collect::<Vec<_>>(), [0.0, 1.0, 0.0]);
    }

    /// At 9.5 V the pause is as long as the default closing delay, and at 5.5 V the pulse as the opening delay: neither does
    /// anything, in no period of a long run. A pause as long as the delay that no pulse ends is longer.
    #[test]
    fn pulse_or_pause_as_long_as_its_delay_does_nothing() {
        let armature = armature(1e-3, 1e-3, 4e-4);
        let driver = Driver { frequency: still(100.0), armature };
        for volts in [9.5, 0.5] {
            let duty: f64 = (volts - 5.0) / 5.0;
            let open = if duty > 0.0 { [1.0, 0.0] } else { [0.0, 1.0] };
            let found = course(driver, |_| duty, 20.0);
            assert!(found.iter().skip(3).all(|(_, openings)| *openings == open), "{volts} V: {:?}", &found[..20]);
        }
        for volts in [5.5, 4.5] {
            let found = course(driver, |_| (volts - 5.0) / 5.0, 20.0);
            assert!(found.iter().all(|(_, openings)| *openings == [0.0; 2]), "{volts} V: {:?}", &found[..20]);
        }
        for last in 1..200 {
            let end = f64::from(last) * 0.01;
            let found = course(driver, |time| if time < end - 1e-3 { 0.9 } else { 0.0 }, end + 0.02);
            let closed: Vec<_> = found.iter().skip(3).filter(|(_, openings)| *openings == [0.0; 2]).collect();
            assert_eq!(closed[0].0, f64::from(last) * 10.0, "{closed:?}");
        }
    }

    /// Whichever way the voltage for it is rounded, also one that is next to 5 V.
    #[test]
    fn pulse_or_pause_of_any_length_is_as_long_as_a_delay_but_for_rounding() {
        for (frequency, tenths) in
            [0.1, 0.3, 30.0, 50.0, 80.0, 100.0, 125.0, 300.0].iter().flat_map(|f| (1..=30).map(move |t| (f, t)))
        {
            let delay = f64::from(tenths) * 1e-4;
            let driver = |[opening_delay, closing_delay]: [f64; 2]| Driver {
                frequency: still(*frequency),
                armature: armature(opening_delay, closing_delay, 0.0),
            };
            let end = 0.5 + 2.0 / frequency;
            let duty = |pulse: f64| ((5.0 + 5.0 * pulse) - 5.0) / 5.0;
            let pause = course(driver([0.0, delay]), |_| duty(1.0 - delay * frequency), end);
            assert!(
                pause.iter().skip(1).all(|(_, openings)| *openings == [1.0, 0.0]),
                "{frequency} Hz, pause of {delay} s"
            );
            let pulse = course(driver([delay, 0.0]), |_| duty(delay * frequency), end);
            assert!(pulse.iter().all(|(_, openings)| *openings == [0.0; 2]), "{frequency} Hz, pulse of {delay} s");
        }
    }

    #[test]
    fn memories_that_no_driver_leaves_are_not_sound() {
        let with = |duty: f64| Memory { duties: [Real::of(duty), Real::of(0.0)], ..Memory::default() };
        let sound = with(0.5);
        assert!(sound.is_sound() && with(1.0).is_sound());
        let motion = |motion: Motion<Real>| Memory { motions: [sound.motions[0], motion], ..sound };
        let still = sound.motions[1];
        let [never, early] = [f64::NAN, -1e-3].map(|after| Some(Moment { period: 1, after: Real::of(after) }));
        for memory in [
            with(1.1),
            with(-0.1),
            with(f64::NAN),
            Memory { falls: [None, never], ..sound },
            Memory { falls: [early, None], ..sound },
            motion(Motion { turns: never, ..still }),
            motion(Motion { arrives: never, ..still }),
        ] {
            assert!(!memory.is_sound(), "{memory:?}");
        }
    }
}
