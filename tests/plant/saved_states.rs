//! Saved states can be restored by the run that wrote them, at any clock, and by no other.

use pneumatic_servo::co_simulation::Simulation;
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::Plant;
use pneumatic_servo::model::{Seeds, Setup, Start};
use pneumatic_servo::models::{self, friction_bench, pneumatic_servo_cylinder as cylinder};

use pneumatic_servo::conformance::Random;

/// A plant under a law, its clock at a time in s.
fn start(model: &str, law: &str, time: f64) -> Plant {
    let setup = Setup::new(models::find(model).expect("a model"));
    setup.set("friction.law", law).expect("a law").start(time).expect("defaults")
}

/// Brings a plant to times in s, with a saved state at each that it must take, as must another plant whose clock began
/// elsewhere; returns how many there were.
fn saves(plant: &mut Plant, other: &mut Plant, times: impl Iterator<Item = f64>) -> usize {
    let start = plant.time();
    let mut count = 0;
    for time in times {
        plant.advance_to(time).unwrap_or_else(|error| panic!("from {start} s: {error}"));
        assert_eq!(plant.time(), time);
        let saved = plant.save();
        for plant in [&mut *plant, &mut *other] {
            plant.restore(&saved).unwrap_or_else(|error| panic!("from {start} s at {time} s: {error}"));
            assert_eq!((plant.time(), plant.save()), (time, saved.clone()), "from {start} s");
        }
        count += 1;
    }
    count
}

/// Clocks from -1e9 to 1e9 s, of all magnitudes. A late clock that counts from its start is rounded twice, which the
/// smallest clocks show: their difference is rounded, too.
#[test]
fn saved_states_are_taken_whatever_the_clock_says() {
    let mut random = Random(36);
    for (model, law) in [
        ("FrictionBench", "Stribeck"),
        ("PneumaticServoCylinder", "LuGre"),
        ("Festoon", "BlimanSorine"),
        ("DrivenSlider", "Stribeck"),
        ("VibroImpact", "Coulomb"),
    ] {
        let mut other = start(model, law, 17.3);
        let mut count = 0;
        for _ in 0..10 {
            let begin = random.spread(1e-3, 1e9);
            let times: Vec<f64> = (0..20).map(|_| random.between(0.0, 2.0)).collect();
            let mut time = begin;
            let times = times.into_iter().map(|step| {
                time += step;
                time
            });
            count += saves(&mut start(model, law, begin), &mut other, times);
        }
        assert_eq!(count, 200, "{model}");
    }
}

/// The smallest clocks, before and behind 0.
#[test]
fn saved_states_are_taken_where_the_clock_changes_its_sign() {
    let mut random = Random(5);
    let mut other = start("FrictionBench", "Stribeck", 0.0);
    for _ in 0..200 {
        let begin = -random.between(0.0, 4.0);
        let mut times: Vec<f64> = (0..50).map(|_| random.between(0.0, 5.0)).collect();
        times.sort_by(f64::total_cmp);
        assert_eq!(saves(&mut start("FrictionBench", "Stribeck", begin), &mut other, times.into_iter()), 50);
    }
}

/// A mass pulled by a spring, which sticks and slips, its clock at a time in s.
fn stick_slip(time: f64) -> Box<dyn Simulation> {
    let table = friction_bench::MODEL.table();
    let changed = [("friction.law", 7.0), ("bench.drive", 1.0), ("driveVelocity", 0.01), ("spring.stiffness", 1e4)];
    let value = |name: &str, start: Option<f64>| {
        changed.iter().find(|(changed, _)| *changed == name).map_or(start.expect("a start value"), |(_, value)| *value)
    };
    let parameters: Vec<f64> = table.parameters().map(|it| value(&it.name, it.start)).collect();
    let inputs: Vec<f64> = table.inputs().map(|it| value(&it.name, it.start)).collect();
    let start = Start { time, parameters: &parameters, inputs: &inputs, tolerance: None, seeds: Seeds::NONE };
    (friction_bench::MODEL.functions.start)(&start).expect("legal values")
}

/// A step to an event, or to one or two places of the clock beside it, ends on the event but for rounding.
#[test]
fn saved_states_are_taken_at_events() {
    let (mut random, mut events) = (Random(1), 0);
    for round in 0..300 {
        let begin = if round % 3 == 0 { random.spread(1e-3, 1e9) } else { -random.between(0.0, 0.5) };
        let mut first = stick_slip(begin);
        for _ in 0..6 {
            let before = first.save();
            assert!(first.advance_to_event(begin + 10.0).expect("a run"), "it sticks and slips");
            let event = first.time();
            for places in -2..=2 {
                let end = (0..i32::abs(places))
                    .fold(event, |time, _| if places > 0 { time.next_up() } else { time.next_down() });
                let mut other = stick_slip(begin);
                other.restore(&before).expect("a state of the same model");
                if end > before.time {
                    other.advance(end).expect("a step");
                    let saved = other.save();
                    other.restore(&saved).unwrap_or_else(|error| panic!("from {begin} s at {end} s: {error}"));
                    events += 1;
                }
            }
            first.update().expect("an event");
        }
    }
    assert!(events > 8_000, "{events}");
}

/// The size of a run that is compiled is a matter of the library: what a state is saved with is not. States that were saved
/// with all places are taken, too.
#[test]
fn saved_states_hold_the_states_that_are_integrated_and_no_others() {
    let table = cylinder::MODEL.table();
    let inputs: Vec<f64> = table.inputs().filter_map(|it| it.start).collect();
    let place = |name| table.parameters().position(|it| it.name == name).expect("a parameter");
    let (law, vessel) = (place("friction.law"), place("supply.volume"));
    let mut padded = 0;
    for (item, volume) in LAWS.items.iter().flat_map(|item| [(item, 0.0), (item, 1e-4)]) {
        let mut parameters: Vec<f64> = table.parameters().filter_map(|it| it.start).collect();
        (parameters[law], parameters[vessel]) = (item.0.into(), volume);
        let start = Start { time: 0.0, parameters: &parameters, inputs: &inputs, tolerance: None, seeds: Seeds::NONE };
        let run = || (cylinder::MODEL.functions.start)(&start).expect("defaults");
        let (mut first, mut second) = (run(), run());
        first.advance(0.05).expect("a step");
        let saved = first.save();
        let places: Vec<_> = (0..table.number_of_states()).filter_map(|state| first.state_index(state)).collect();
        assert_eq!(saved.states.len(), places.len(), "{}", item.1);
        // Places are compiled along behind the states of the law, which are those between two of the gas and position.
        let all = places.iter().max().expect("states") + 1;
        let mut with_all = saved.clone();
        let first_free = (0..all).find(|place| !places.contains(place));
        if let Some(free) = first_free {
            with_all.states.splice(free..free, vec![0.0; all - places.len()]);
            assert!(second.restore(&with_all).is_err(), "{}: states that are not integrated", item.1);
            padded += 1;
        }
        second.restore(&saved).expect("a state of the same run");
        assert_eq!(second.save(), saved, "{}", item.1);
        first.advance(0.06).expect("a step");
        second.advance(0.06).expect("a step");
        assert_eq!(second.save(), first.save(), "{}", item.1);
    }
    assert!(padded > 0, "no law leaves a place free");
}

/// The clock that hosts use at 1.7e9 s resolves 0.24 us: a state whose clock is a microsecond off is none of a run.
#[test]
fn saved_state_with_another_clock_is_refused() {
    for begin in [-3.7, 0.0, 1.0, 1.7e9] {
        let mut plant = start("FrictionBench", "Stribeck", begin);
        plant.advance_to(begin + 1.0).expect("a step");
        let mut saved = postcard::to_allocvec(&plant.save()).expect("plain data");
        for (shift, is_taken) in [(0.0, true), (1e-6, false), (-1e-6, false), (1.0, false)] {
            // The clock comes first.
            saved[..8].copy_from_slice(&(begin + 1.0 + shift).to_le_bytes());
            let shifted = postcard::from_bytes(&saved).expect("a saved state");
            assert_eq!(plant.restore(&shifted).is_ok(), is_taken, "{shift} s at {begin} s");
        }
    }
}
