//! Trial states of an importer's solver, beyond stops, kinks and limits: the equations go on smoothly there, lead back, and have
//! finite values for all finite states. Such states are refused where a host accepts them.

use std::f64::consts::PI;

use pneumatic_servo::co_simulation::Direction;
use pneumatic_servo::conformance::Random;
use pneumatic_servo::friction::LAWS;
use pneumatic_servo::model::{Model, Setup};
use pneumatic_servo::model_exchange::Exchange;
use pneumatic_servo::models::{self, pneumatic_servo_cylinder};
use pneumatic_servo::variables::Table;

fn setup(model: &'static Model, law: &str) -> Setup {
    Setup::new(model).set("friction.law", law).expect("a law")
}

fn laws() -> impl Iterator<Item = &'static str> {
    LAWS.items.iter().map(|(_, name, _)| *name)
}

/// A limit of a state of the cylinder: which state, the limit, whether it is an upper one, and what is said of a state that
/// is as far again beyond it where a host accepts it: nothing, where only numbers would overflow further out.
type Edge = (&'static str, f64, bool, &'static str);

/// Behind the pistons, of 2.01 and 1.73 cm2, are 5 cm3: down to a ten thousandth of that volume the equations of the
/// cylinder hold.
fn edges() -> [Edge; 8] {
    let [clearance_a, clearance_b] = [0.0, 0.006].map(|rod| 5e-6 / (PI / 4.0 * (0.016 * 0.016 - rod * rod)));
    [
        ("position", -clearance_a * (1.0 - 1e-4), false, "the volume of chamber A vanishes"),
        ("position", 0.5 + clearance_b * (1.0 - 1e-4), true, "the volume of chamber B vanishes"),
        ("chamberA.pressure", 1.0, false, "chamberA.pressure falls to 0"),
        ("chamberB.pressure", 1.0, false, "chamberB.pressure falls to 0"),
        ("chamberA.temperature", 1.0, false, "chamberA.temperature falls to 0"),
        ("chamberB.temperature", 1.0, false, "chamberB.temperature falls to 0"),
        ("velocity", 1e8, true, ""),
        ("valve.spool", -3e10, false, ""),
    ]
}

/// Distance between a limit and the point where the equations lose their meaning, or the limit itself: twice as far as they
/// go on.
fn width(name: &str, limit: f64) -> f64 {
    if name == "position" { 1e-4 * (limit.abs() % 0.5) } else { limit.abs() }
}

/// A model at states that a solver tries.
struct Tried {
    exchange: Box<dyn Exchange>,
    table: &'static Table,
    start: Vec<f64>,
}

impl Tried {
    fn new(setup: &Setup) -> Self {
        let exchange = setup.exchange(0.0).expect("parameters that fit").expect("a model with states");
        let table = setup.table();
        let mut start = vec![0.0; table.number_of_states()];
        exchange.states(&mut start);
        Self { exchange, table, start }
    }

    /// The number of a state.
    fn number(&self, name: &str) -> usize {
        let reference = self.table.find(name).expect("a variable").variable.reference;
        self.table.states().position(|state| state == reference).expect("a state")
    }

    /// Tries another value of a state.
    fn go(&mut self, number: usize, value: f64) {
        let mut states = self.start.clone();
        states[number] = value;
        self.exchange.set_states(&states);
    }

    fn rates(&self) -> Vec<f64> {
        let mut rates = vec![f64::NAN; self.start.len()];
        self.exchange.rates(&mut rates).expect("an answer");
        rates
    }

    fn values(&self) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.table.computed().count()];
        self.exchange.values(&mut values);
        values
    }

    /// Derivatives of all computed variables by a state.
    fn slopes(&self, number: usize) -> Vec<f64> {
        let mut seeds = vec![0.0; self.start.len()];
        seeds[number] = 1.0;
        let inputs = vec![0.0; self.table.inputs().count()];
        let mut slopes = self.values();
        let direction = Direction { time: 0.0, inputs: &inputs, states: &seeds, parameters: &[] };
        self.exchange.directional_derivative(direction, &mut slopes);
        slopes
    }
}

/// The carriage moves at the start.
fn moving(law: &str) -> Tried {
    Tried::new(&setup(&pneumatic_servo_cylinder::MODEL, law).set("velocity0", 0.1).expect("a velocity"))
}

#[test]
fn rates_go_on_smoothly_beyond_the_limits_of_the_states() {
    for law in ["None", "LuGre", "GMS"] {
        for (name, limit, is_upper, _) in edges() {
            let mut tried = moving(law);
            let number = tried.number(name);
            let step = if is_upper { 1e-6 } else { -1e-6 } * width(name, limit);
            let [within, beyond] = [0.0, step].map(|distance| {
                tried.go(number, limit + distance);
                (tried.values(), tried.slopes(number))
            });
            for (place, variable) in tried.table.computed().enumerate() {
                let told = format!("{law}: {} beyond {name} = {limit}", variable.name);
                let [value, slope] = [within.0[place], within.1[place]];
                let change = (beyond.0[place] - value).abs();
                assert!(
                    change <= 1e-3 * value.abs() + 2.0 * (slope * step).abs(),
                    "{told}: {value} {}",
                    beyond.0[place]
                );
                let bend = (beyond.1[place] - slope).abs();
                assert!(
                    bend <= 1e-4 * slope.abs().max(1e-6 * value.abs()).max(1e-5),
                    "{told}: {slope} {}",
                    beyond.1[place]
                );
            }
        }
    }
}

/// The further away, the more: the state itself is led back, a position by its velocity.
#[test]
fn states_beyond_their_limits_are_led_back() {
    for law in laws() {
        for (name, limit, is_upper, _) in edges() {
            let mut tried = moving(law);
            let number = tried.number(name);
            let side = if is_upper { 1.0 } else { -1.0 };
            let led = match name {
                "position" => tried.number("velocity"),
                "valve.spool" => tried.number("valve.spoolVelocity"),
                _ => number,
            };
            let mut before = f64::NEG_INFINITY;
            for share in [0.1, 1.0, 3.0, 1e3, 1e6, 1e290] {
                tried.go(number, limit + side * share * limit.abs());
                let inward = -side * tried.rates()[led];
                assert!(inward >= before, "{law}: {name} at {share}: {inward} after {before}");
                assert!(inward > 0.0 || share < 1.0, "{law}: {name} at {share}: {inward}");
                before = inward;
            }
        }
    }
}

#[test]
fn slopes_beyond_the_limits_are_those_of_differences() {
    for (name, limit, is_upper, _) in edges() {
        let mut tried = moving("LuGre");
        let number = tried.number(name);
        let width = width(name, limit);
        let beyond = limit + if is_upper { width } else { -width };
        let step = 1e-5 * width;
        let [before, after] = [-step, step].map(|distance| {
            tried.go(number, beyond + distance);
            tried.values()
        });
        tried.go(number, beyond);
        for ((variable, slope), (before, after)) in
            tried.table.computed().zip(tried.slopes(number)).zip(before.iter().zip(&after))
        {
            let difference = (after - before) / (2.0 * step);
            let bound = 1e-7 * difference.abs() + 1e-15 * (after.abs() + (slope * beyond).abs()) / step;
            assert!((slope - difference).abs() <= bound, "{} by {name}: {slope}, not {difference}", variable.name);
        }
    }
}

#[test]
fn states_beyond_their_limits_are_refused_where_a_host_accepts_them() {
    for (name, limit, is_upper, refusal) in edges().into_iter().filter(|(.., refusal)| !refusal.is_empty()) {
        let mut tried = moving("Stribeck");
        let number = tried.number(name);
        tried.go(number, limit - if is_upper { 1e-12 } else { -1e-12 } * limit.abs());
        assert_eq!(tried.exchange.accept_step(), Ok(()), "{name}");
        tried.go(number, limit + if is_upper { limit.abs() } else { -limit.abs().max(2.0) });
        let before = (tried.exchange.save(), tried.values());
        let errors = [tried.exchange.accept_step(), tried.exchange.update().map(|_| ()), tried.exchange.admit()];
        for error in errors {
            let text = error.expect_err("states without a meaning").to_string();
            assert_eq!(text, format!("at t = 0 s the equations have no meaning at the given states: {refusal}"));
        }
        assert_eq!((tried.exchange.save(), tried.values()), before, "{name}");
        tried.go(number, tried.start[number]);
        assert_eq!(tried.exchange.accept_step(), Ok(()), "{name}");
    }
}

/// A solver that diverges goes on until its states are no numbers.
#[test]
fn states_far_out_are_accepted_in_every_model() {
    for model in models::ALL.iter().filter(|model| model.table().number_of_states() > 0) {
        for law in laws() {
            let mut tried = Tried::new(&setup(model, law));
            let velocity = tried.table.computed().position(|it| it.name.to_lowercase().ends_with("velocity"));
            let reference = tried.table.computed().nth(velocity.expect("a velocity")).expect("a variable").reference;
            let number = tried.table.states().position(|state| state == reference).unwrap_or(1);
            tried.go(number, 1e200);
            assert_eq!(tried.exchange.accept_step(), Ok(()), "{} {law}", model.name);
            tried.exchange.update().unwrap_or_else(|error| panic!("{} {law}: {error}", model.name));
            assert!(tried.rates().iter().all(|rate| rate.is_finite()), "{} {law}", model.name);
            let saved = tried.exchange.save();
            assert_eq!(tried.exchange.restore(&saved), Ok(()), "{} {law}", model.name);
        }
    }
}

/// Every finite state of a solver has finite rates and values; states and rates agree with their variables.
#[test]
fn every_finite_vector_of_states_has_an_answer() {
    let mut random = Random(7);
    let mut wild = || {
        let size = [0.0, 1e-12, 1.0, 1e3, 1e9, 1e30, 1e300, f64::MAX][random.between(0.0, 8.0) as usize];
        if random.next() < 0.0 { -size } else { size }
    };
    for model in models::ALL.iter().filter(|model| model.table().number_of_states() > 0) {
        for law in laws() {
            let mut tried = Tried::new(&setup(model, law));
            for round in 0..40 {
                let mut states = tried.start.clone();
                // One at a time, and all at once.
                if round < states.len() {
                    states[round] = wild();
                } else {
                    states.fill_with(&mut wild);
                }
                tried.exchange.set_states(&states);
                tried.exchange.states(&mut states);
                let (rates, values) = (tried.rates(), tried.values());
                let indicators = {
                    let mut indicators = vec![f64::NAN; model.indicators().len()];
                    tried.exchange.indicators(&mut indicators);
                    indicators
                };
                let told = || format!("{} {law}: {states:?}", model.name);
                assert!(rates.iter().chain(&values).chain(&indicators).all(|number| number.is_finite()), "{}", told());
                for (place, variable) in tried.table.computed().enumerate() {
                    let number = tried.table.states().position(|state| Some(state) == variable.derivative_of);
                    if let Some(number) = number {
                        assert_eq!(values[place], rates[number], "{} {}", told(), variable.name);
                    }
                }
            }
        }
    }
}

/// The carriage moves to either stop and back, and into a cushion: a solver sees an indicator fall, and after an update it
/// is positive on the other side. Nothing else happens there, and no event is counted.
#[test]
fn stops_and_cushions_have_indicators_at_which_nothing_else_happens() {
    let mut setup = setup(&pneumatic_servo_cylinder::MODEL, "LuGre");
    for (name, value) in [("hoseA.length", 0.5), ("hoseB.length", 0.5), ("cushion.length", 0.02)] {
        setup.change(name, value).expect("an option");
    }
    let mut tried = Tried::new(&setup);
    let place = |name: &str| setup.model().indicators().iter().position(|it| it.name == name).expect("an indicator");
    let events = tried.table.computed().position(|variable| variable.name == "solver.events").expect("a counter");
    let number = tried.number("position");
    let ends = [("cylinder.stopA", 0.0), ("cylinder.stopB", 0.5), ("cushionA.entry", 0.02), ("cushionB.entry", 0.48)];
    for (name, end) in ends {
        let look = |tried: &Tried| {
            let mut indicators = vec![f64::NAN; setup.model().indicators().len()];
            tried.exchange.indicators(&mut indicators);
            indicators[place(name)]
        };
        let (rates, side) = (tried.rates(), if end < 0.25 { 1.0 } else { -1.0 });
        assert!((look(&tried) - 0.25e3 - if name.ends_with("entry") { -20.0 } else { 0.0 }).abs() < 1e-6, "{name}");
        for (distance, next) in [(-1e-5, 1e-2), (1e-5, 1e-2)] {
            tried.go(number, end + side * distance);
            assert!((look(&tried) + next).abs() < 1e-6, "{name}: {}", look(&tried));
            let update = tried.exchange.update().expect("an update");
            assert!(!update.changes_states && (look(&tried) - next).abs() < 1e-6, "{name}: {}", look(&tried));
            assert_eq!(tried.values()[events], 0.0, "{name}");
        }
        // Within rounding of the place nothing changes sides.
        tried.go(number, end);
        assert!(look(&tried) > 0.0 && tried.exchange.update().is_ok() && look(&tried) > 0.0, "{name}");
        tried.go(number, tried.start[number]);
        assert_eq!(tried.rates(), rates, "{name}");
    }
}

/// A solver sees a switch turn. After the update at that event it stays on within its hysteresis, where it was off before.
#[test]
fn switches_at_the_ends_have_indicators() {
    let mut setup = setup(&pneumatic_servo_cylinder::MODEL, "Stribeck");
    setup.change("sensor.endDistance[1]", 0.02).expect("a distance");
    let mut tried = Tried::new(&setup);
    let number = tried.number("position");
    let switch = tried.table.computed().position(|variable| variable.name == "sensor.end[1]").expect("a switch");
    let place = setup.model().indicators().iter().position(|it| it.name == "sensor.end1.turn").expect("an indicator");
    let mut seen = |position: f64| {
        tried.go(number, position);
        let mut indicators = vec![f64::NAN; setup.model().indicators().len()];
        tried.exchange.indicators(&mut indicators);
        let has_turned = indicators[place] < 0.0;
        tried.exchange.update().expect("an update");
        (has_turned, tried.values()[switch])
    };
    for (position, expected) in [
        (0.0205, (true, 0.0)),
        (0.0199, (true, 1.0)),
        (0.0205, (true, 1.0)),
        (0.0211, (true, 0.0)),
        (0.03, (false, 0.0)),
    ] {
        assert_eq!(seen(position), expected, "at {position} m");
    }
}

#[test]
fn saved_states_know_the_sides_of_kinks() {
    let setup = setup(&pneumatic_servo_cylinder::MODEL, "Stribeck");
    let mut one = Tried::new(&setup);
    one.go(one.number("position"), -1e-4);
    one.exchange.update().expect("an update");
    let mut other = Tried::new(&setup);
    other.exchange.restore(&one.exchange.save()).expect("a state of the same model");
    let [seen, again] = [&one, &other].map(|tried| {
        let mut indicators = vec![f64::NAN; setup.model().indicators().len()];
        tried.exchange.indicators(&mut indicators);
        indicators
    });
    assert_eq!(seen, again);
    assert!(seen.iter().all(|indicator| *indicator > 0.0), "{seen:?}");
}

/// Co-simulation crosses no kink: its indicator is the distance.
#[test]
fn kinks_are_shown_as_distances_with_the_solver_inside() {
    let setup = setup(&pneumatic_servo_cylinder::MODEL, "Stribeck").set("position0", 0.4).expect("a position");
    let mut run = setup.set("valveVoltage", 8.0).expect("a voltage").start(0.0).expect("a run");
    run.advance_to(1.0).expect("a step");
    let [at_a, at_b, rest @ ..] = {
        let mut indicators = [f64::NAN; 10];
        run.simulation().indicators(&mut indicators);
        [indicators[6], indicators[7], indicators[8], indicators[9]]
    };
    let position = run.get("position").expect("a variable");
    assert!(position > 0.5 && position < 0.501, "it leans on the stop: {position}");
    assert_eq!([at_a, at_b], [position, position - 0.5]);
    assert_eq!(rest, [1.0, 1.0], "there is no cushion");
}
