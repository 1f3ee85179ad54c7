//! Properties of every friction law: alone, and in the friction bench.

use std::f64::consts::TAU;

use super::{Random, run};
use crate::friction::{Contact, Drive, Event, FrictionLaw, Indicators, MAX_STATES, StateKind, Stiction};
use crate::model::Plant;
use crate::model::{Model, Setup};
use crate::models::friction_bench;
use crate::numbers::{Dual, Real, Scalar};
use crate::system::UNUSED;
use crate::variables::{Kind, Meaning, Tunable};

/// Claims about a law besides the promises of every law.
#[derive(Clone, Copy, Debug, Default)]
pub struct Claims {
    /// Mirrored motion gives mirrored friction.
    pub odd: bool,
    /// Upper bound of the returned energy in J: the largest stored energy with its defaults at a load factor of [`MOST`].
    pub stored: Option<f64>,
}

/// The lowest load factor under which energies are compared.
pub const LEAST: f64 = 0.1;
/// The highest one.
pub const MOST: f64 = 1.9;

/// The friction bench with the laws of a catalogue.
pub fn bench<L: FrictionLaw>() -> &'static Model {
    const { &friction_bench::model::<L>() }
}

/// The friction bench under a law and a drive, for example `PrescribedMotion`.
///
/// # Panics
/// When the catalogue has no such law.
pub fn benched<L: FrictionLaw>(law: &str, drive: &str) -> Setup {
    let of = |setup: Setup, name: &str, item: &str| {
        setup.set(name, item).unwrap_or_else(|error| panic!("the friction bench: {error}"))
    };
    of(of(Setup::new(bench::<L>()), "friction.law", law), "bench.drive", drive)
}

/// Checks all promises of a law of a catalogue, with its defaults, and the claims about it.
///
/// # Panics
/// When a promise is not kept, or the catalogue has no such law.
pub fn law<L: FrictionLaw>(law: &str, claims: Claims) {
    derivatives::<L>(law);
    unchanged::<L>(law);
    yields::<L>(law);
    if claims.odd {
        mirrored::<L>(law);
    }
    if let Some(stored) = claims.stored {
        // A break within a piece of the path is counted in the middle of it: 11 N along a tenth of a micrometre.
        let rounding = if stored > 0.0 { 2e-6 } else { 1e-12 };
        passive(&benched::<L>(law, "PrescribedMotion"), stored + rounding);
    }
    for drive in ["PrescribedMotion", "Free"] {
        run(&benched::<L>(law, drive));
    }
    // Stick-slip on a spring stiff enough to see some cycles.
    run(&benched::<L>(law, "SpringPull").set("spring.stiffness", 2e3).expect("a stiffness"));
}

/// A law of a catalogue with its defaults.
fn default_law<L: FrictionLaw>(law: &str) -> L {
    let id = L::table().iter().find_map(|variable| match variable.kind {
        Kind::Enumeration(laws) if variable.meaning == Some(Meaning::FrictionLaw) => laws.id(law),
        _ => None,
    });
    let id = id.unwrap_or_else(|| panic!("the catalogue has no law {law}"));
    let table = L::table_within("friction", 0, id);
    let values: Vec<_> = table.iter().filter_map(|variable| variable.start).map(Tunable::still).collect();
    L::read(&values).unwrap_or_else(|error| panic!("the defaults of {law}: {}", error.within("friction")))
}

/// Variables of the equations: velocity, position, applied force, level, then the states.
const DIRECTIONS: usize = 4 + MAX_STATES;

/// Names of these variables.
fn names<L: FrictionLaw>(law: &L) -> Vec<String> {
    let named: Vec<_> = L::named_states("", 0).into_iter().filter(|state| state.law == law.id()).collect();
    let state = |number: usize| match law.state_kind() {
        StateKind::Named => named[number].name.clone(),
        StateKind::Deflection => "deflection".to_owned(),
        StateKind::Force => format!("elementForce[{}]", number + 1),
    };
    let motion = ["velocity", "position", "applied force", "load factor"].map(str::to_owned);
    motion.into_iter().chain((0..law.states()).map(state)).collect()
}

/// The point of a draw in words: its values other than 0.
fn point(names: &[String], at: &[f64]) -> String {
    let told = names.iter().zip(at).filter(|(_, value)| **value != 0.0);
    told.map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ")
}

/// The beginning of the memory of a law in words, which may be long.
fn shortly(memory: &impl std::fmt::Debug) -> String {
    const LENGTH: usize = 160;
    let text = format!("{memory:?}");
    if text.chars().count() > LENGTH { text.chars().take(LENGTH).chain("...".chars()).collect() } else { text }
}

/// States drawn around those that a run starts with, as far away as their magnitude and within their range.
fn draw_states<L: FrictionLaw>(law: &L, contact: &Contact<f64>, random: &mut Random, states: &mut [f64]) {
    let mut start = [Real::of(0.0); MAX_STATES];
    law.start_states(&contact.still(), &mut start[..states.len()]);
    for (state, value) in states.iter_mut().enumerate() {
        let ([low, high], start, scale) = (law.range_of(state), start[state].value, law.scale_of(state));
        *value = random.between(low.max(start - scale), high.min(start + scale));
    }
}

/// The rates of the states and the friction force.
fn evaluate<L: FrictionLaw, S: Scalar>(law: &L, drive: Drive, memory: &L::Memory<S::Held>, at: &[S]) -> Vec<S> {
    let contact =
        Contact { time: S::constant(0.1), velocity: at[0], position: at[1], applied: at[2], level: at[3], drive };
    let mut rates = vec![S::zero(); law.states()];
    let force = law.force(&contact, &at[4..4 + law.states()], memory, &mut rates);
    rates.push(force);
    rates
}

/// The same in plain numbers.
fn plain<L: FrictionLaw>(law: &L, drive: Drive, memory: &L::Memory<Real>, at: &[f64; DIRECTIONS]) -> Vec<f64> {
    evaluate(law, drive, memory, &Real::all(at)).into_iter().map(Real::value).collect()
}

/// Derivatives of force and rates by dual numbers equal differences, in random motion and the modes that it reaches.
/// Central differences with steps of 1e-6 of each variable are good to 1e-5 of the derivative, plus rounding.
///
/// # Panics
/// When one is another, or the law uses an event that it does not declare.
pub fn derivatives<L: FrictionLaw>(name: &str) {
    let law = default_law::<L>(name);
    let names = names(&law);
    let mut random = Random(u64::from(name.len() as u32));
    for round in 0..200 {
        let drive = if round % 4 == 0 { Drive::Motion } else { Drive::Force };
        let mut at = [0.0; DIRECTIONS];
        at[..4].copy_from_slice(&[random.spread(1e-5, 0.5), 0.25, 8.0 * random.next(), 1.2 + 0.5 * random.next()]);
        let mut contact = Contact { time: 0.1, velocity: at[0], position: at[1], applied: at[2], level: at[3], drive };
        draw_states(&law, &contact, &mut random, &mut at[4..4 + law.states()]);
        let mut memory = law.start(&contact.still::<Real>());
        for _ in 0..20 {
            let (mut indicators, mut states) = (Indicators::<Real>::default(), Real::all(&at));
            law.indicators(&contact.still(), &states[4..], &memory, &mut indicators);
            for event in Event::ALL.into_iter().filter(|event| !law.events().contains(event)) {
                assert_eq!(indicators[event].value, UNUSED, "{name} does not declare {event:?}");
            }
            let Some(event) = indicators.due() else { break };
            let mut velocity = Real::of(contact.velocity);
            law.switch(event, &contact.still(), &mut velocity, &mut states[4..], &mut memory);
            (at, contact.velocity) = (states.map(Real::value), velocity.value);
        }
        at[0] = contact.velocity;
        let seeded: Vec<_> = at.iter().enumerate().map(|(i, value)| Dual::<DIRECTIONS>::variable(*value, i)).collect();
        let exact = evaluate(&law, drive, &memory, &seeded);
        let used = 4 + law.states();
        for direction in (0..used).filter(|direction| at[*direction] != 0.0) {
            let step = 1e-6 * at[direction].abs();
            let [above, below] = [step, -step].map(|shift| {
                let mut shifted = at;
                shifted[direction] += shift;
                plain(&law, drive, &memory, &shifted)
            });
            for (row, dual) in exact.iter().enumerate() {
                let difference = (above[row] - below[row]) / (2.0 * step);
                let scale = if row < law.states() { law.scale_of(row) } else { law.state_scale() };
                let rounding = 1e-15 * (above[row].abs() + 1e3 * scale + 10.0 * f64::from(row == law.states())) / step;
                let allowed = 1e-5 * dual.slope[direction].abs() + 4.0 * rounding;
                assert!(
                    (dual.slope[direction] - difference).abs() <= allowed,
                    "{name}: the derivative of {} by {} is {} by dual numbers and {difference} by differences, which may differ \
                     by {allowed:.1e}, at time = 0.1, {}, in {}",
                    names.get(4 + row).map_or("the friction force".to_owned(), |state| format!("der({state})")),
                    names[direction],
                    dual.slope[direction],
                    point(&names, &at),
                    shortly(&memory),
                );
            }
        }
    }
}

/// A law that follows a motion, and says that its force has not changed by that, gives the same force and rates as before.
///
/// # Panics
/// When it gives others.
pub fn unchanged<L: FrictionLaw>(name: &str) {
    let law = default_law::<L>(name);
    let mut random = Random(u64::from(name.len() as u32));
    for round in 0..400 {
        let drive = if round % 2 == 0 { Drive::Motion } else { Drive::Force };
        let [first, next] = [0.1, 0.101].map(|time| {
            let velocity = if random.next() < 0.5 { random.spread(1e-5, 0.5) } else { 0.0 };
            let (position, applied, level) = (0.25 + 1e-6 * random.next(), 8.0 * random.next(), 1.2);
            Contact { time, velocity, position, applied, level, drive }
        });
        let mut at = [0.0; DIRECTIONS];
        at[..4].copy_from_slice(&[next.velocity, next.position, next.applied, next.level]);
        draw_states(&law, &next, &mut random, &mut at[4..4 + law.states()]);
        let before = law.start(&first.still::<Real>());
        let mut after = before.clone();
        if !law.follow(&next.still(), &Real::all(&at)[4..], &mut after) {
            let [as_before, found] = [&before, &after].map(|memory| plain(&law, drive, memory, &at));
            let names = names(&law);
            assert_eq!(
                found,
                as_before,
                "{name} says that force and rates have not changed after a step to time = {}, {}: now, and before",
                next.time,
                point(&names, &at),
            );
        }
    }
}

/// A contact that is held exactly starts to slide when it breaks away: the force against sliding at the velocity 0 does not exceed
/// the applied force that has overcome the contact. Otherwise break-away and stop follow each other without end.
///
/// # Panics
/// When friction pushes a contact back that has just broken away.
pub fn yields<L: FrictionLaw>(name: &str) {
    let law = default_law::<L>(name);
    if law.stiction() != Stiction::Exact {
        return;
    }
    for (level, direction) in [0.1, 0.5, 1.0, 1.9].into_iter().flat_map(|level| [(level, 1.0), (level, -1.0)]) {
        let under = |force: f64| {
            let (time, position, velocity, drive) = (0.1, 0.25, 0.0, Drive::Force);
            Contact { time, position, velocity, applied: direction * force, level, drive }.still::<Real>()
        };
        let mut memory = law.start(&under(0.0));
        let mut z = [Real::of(0.0); MAX_STATES];
        let z = &mut z[..law.states()];
        law.start_states(&under(0.0), z);
        let due = |force: f64, z: &[Real]| {
            let mut indicators = Indicators::default();
            law.indicators(&under(force), z, &memory, &mut indicators);
            indicators.due()
        };
        // The least force that overcomes the contact, between 1 uN and 1 GN.
        let (mut held, mut broken) = (0.0, 1e-6);
        while due(broken, z).is_none() && broken < 1e9 {
            (held, broken) = (broken, 2.0 * broken);
        }
        while broken - held > 1e-12 * broken {
            let middle = 0.5 * (held + broken);
            *(if due(middle, z).is_none() { &mut held } else { &mut broken }) = middle;
        }
        let Some(event) = due(broken, z) else { continue };
        let mut velocity = Real::of(0.0);
        law.switch(event, &under(broken), &mut velocity, z, &mut memory);
        let mut rates = [Real::of(0.0); MAX_STATES];
        let against = direction * law.force(&under(broken), z, &memory, &mut rates[..z.len()]).value;
        assert!(
            against <= broken * (1.0 + 1e-9),
            "{name} at the load factor {level}: the contact breaks away under {broken} N, and slides against {against} N, so \
             that break-away and stop follow each other without end"
        );
    }
}

/// Compared variables of mirrored motions.
const SHOWN: [&str; 3] = ["frictionForce", "position", "velocity"];

/// Mirrored motion gives mirrored friction. Every operation on mirrored numbers gives mirrored numbers; 1e-9 leaves room for sums
/// taken in another order.
///
/// # Panics
/// When it does not.
pub fn mirrored<L: FrictionLaw>(law: &str) {
    for drive in ["PrescribedMotion", "SpringPull", "Free"] {
        let mut setup = benched::<L>(law, drive);
        setup.change("driveVelocity", 0.0).expect("a velocity");
        setup.change("spring.stiffness", 1e3).expect("a stiffness");
        let start = || setup.start(0.0).unwrap_or_else(|error| panic!("{law}: {error}"));
        let mut runs = [(1.0, start()), (-1.0, start())];
        let mut random = Random(7);
        for step in 1..300 {
            let v = if step % 10 == 0 { 0.0 } else { random.spread(1e-5, 0.1) };
            let force = random.spread(1.0, 30.0);
            let end = f64::from(step) * 0.01;
            let [right, left] = runs.each_mut().map(|(side, run)| {
                set(run, "driveVelocity", *side * v);
                set(run, "appliedForce", *side * force);
                run.advance_to(end).unwrap_or_else(|error| panic!("{law} {drive}: {error}"));
                SHOWN.map(|name| *side * get(run, name))
            });
            for (name, (a, b)) in SHOWN.into_iter().zip(right.into_iter().zip(left)) {
                let allowed = 1e-9 * a.abs().max(1.0);
                assert!(
                    (a - b).abs() <= allowed,
                    "{law} in the drive {drive}: {name} is {a}, and {} under the mirrored motion, at {end} s; it may differ by \
                     {allowed:.1e}",
                    -b,
                );
            }
        }
    }
}

/// In a bench under prescribed motion, friction gives back no more energy than this, in J, however its load factor varies in space
/// and time.
///
/// # Panics
/// When it gives back more.
pub fn passive(setup: &Setup, stored: f64) {
    let given = Motion::of(setup).given_back();
    assert!(given < stored, "{}: friction gives back {given} J, and may give back {stored} J", super::described(setup));
}

fn set(run: &mut Plant, name: &str, value: f64) {
    run.set(name, value).unwrap_or_else(|error| panic!("the friction bench: {error}"));
}

fn get(run: &mut Plant, name: &str) -> f64 {
    run.get(name).unwrap_or_else(|error| panic!("the friction bench: {error}"))
}

/// A motion back and forth at speeds from 0.1 mm/s to 1 m/s, under a load factor with waves along the path and in time, with the
/// energy that friction takes: a sum that falls only where friction returns energy.
pub struct Motion {
    /// The bench.
    pub run: Plant,
    /// Random speeds and paths.
    pub random: Random,
    phase: f64,
    /// Work in J that friction has taken, and the most it had taken before.
    taken: f64,
    most: f64,
    /// The largest energy in J given back.
    given_back: f64,
}

impl Motion {
    /// In a bench under prescribed motion, which is at rest at first.
    ///
    /// # Panics
    /// When it does not start.
    pub fn of(setup: &Setup) -> Self {
        let still = setup.clone().set("driveVelocity", 0.0).expect("a velocity");
        let run = still.start(0.0).unwrap_or_else(|error| panic!("{}: {error}", super::described(setup)));
        Self { run, random: Random(7), phase: 0.0, taken: 0.0, most: 0.0, given_back: 0.0 }
    }

    /// Goes on at a velocity in m/s for a path in m.
    ///
    /// # Panics
    /// When a step fails.
    pub fn go(&mut self, velocity: f64, path: f64) {
        const PIECE: f64 = 1e-7;
        let pieces = (path / PIECE).ceil() as usize;
        let duration = PIECE / velocity.abs();
        for _ in 0..pieces {
            self.phase += 0.03;
            let waves = (TAU * get(&mut self.run, "position") / 5e-5).sin() + self.phase.sin();
            set(&mut self.run, "friction.level", 0.5 * (LEAST + MOST) + 0.25 * (MOST - LEAST) * waves);
            set(&mut self.run, "driveVelocity", velocity);
            let before = get(&mut self.run, "frictionForce");
            let end = self.run.time() + duration;
            self.run.advance_to(end).unwrap_or_else(|error| panic!("the friction bench: {error}"));
            let force = 0.5 * (before + get(&mut self.run, "frictionForce"));
            self.taken += force * velocity * duration;
            self.most = self.most.max(self.taken);
            self.given_back = self.given_back.max(self.most - self.taken);
        }
    }

    /// The largest energy in J given back in sixty reversals, here and there with less than a millimetre per second.
    ///
    /// # Panics
    /// When a step fails.
    pub fn given_back(mut self) -> f64 {
        for reversal in 0..60 {
            let speed = 10f64.powf(self.random.between(-4.0, 0.0));
            let path = self.random.between(1e-6, 4e-5);
            self.go(if reversal % 2 == 0 { speed } else { -speed }, path);
        }
        self.given_back
    }
}
