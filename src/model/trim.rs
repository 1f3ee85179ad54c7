//! Operating points: states and inputs at which a plant stays as it is, or moves on steadily.

use std::fmt;

use nalgebra::{DMatrix, DVector};

use super::{Plant, Saved};
use crate::numbers::pseudo_inverse;
use crate::session::Direction;
use crate::solver::StepError;
use crate::variables::{Kind, Place, SettingError, Variable, find};

/// Most steps of Newton's method from one start.
const NEWTON_STEPS: usize = 100;
/// Inputs that are tried, as distances from their values in nominal units.
const OFFSETS: [f64; 9] = [0.0, 0.1, -0.1, 0.2, -0.2, 0.4, -0.4, 0.8, -0.8];
/// Shares of the supply pressure that chambers are filled by.
const FILLED: [f64; 2] = [0.0, 0.5];
const SUPPLY: &str = "supplyPressure";
/// Largest speed, in nominal units, of a faster motion whose point leads to the point of a slower one.
const FASTEST: f64 = 10.0;
/// Step in s in which only a small mass comes to rest, and enough of them for the chambers to fill.
const SETTLING_STEP: f64 = 5e-5;
const SETTLING_STEPS: usize = 2000;
/// Steps after which a plant that settles is asked whether it rests.
const CHECKED: usize = 100;
/// Way in m on which friction forgets a rest, least speed there in m/s, and duration in s of the given speed.
const RUN_IN: f64 = 1e-3;
const RUN_IN_SPEED: f64 = 0.02;
const RUN_IN_TIME: f64 = 0.02;
/// Share of its start below which a pressure or temperature is not physical, though rates may vanish there.
const VACUUM: f64 = 0.01;
/// Largest rate at rest, in nominal units: far below what a run at the default tolerance resolves.
const TOLERANCE: f64 = 1e-9;
/// Singular values below this share of the largest belong to directions that change nothing.
const RANK: f64 = 1e-12;

/// What is given of an operating point.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// Continuous states and their values. Where the rate of a state is another state, as the velocity of a position, the state
    /// whose rate is given stays where it is, and moves on from there.
    pub states: &'a [(&'a str, f64)],
    /// Inputs that keep their values.
    pub inputs: &'a [&'a str],
    /// Inputs that are to be found.
    pub free: &'a [&'a str],
}

/// Why there is no operating point.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TrimError {
    /// A name or value is wrong.
    Setting(SettingError),
    /// None was found; the text names what does not come to rest.
    NotFound(String),
}

impl fmt::Display for TrimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Setting(error) => error.fmt(f),
            Self::NotFound(reason) => write!(f, "no operating point was found: {reason}"),
        }
    }
}

impl std::error::Error for TrimError {}

impl From<SettingError> for TrimError {
    fn from(error: SettingError) -> Self {
        Self::Setting(error)
    }
}

impl Plant {
    /// Moves a plant that has just been started to an operating point: those states and inputs that are not given are chosen such
    /// that the rates of all states vanish; but a state whose rate is given moves on.
    ///
    /// ```
    /// use pneumatic_servo::model::{Given, Setup};
    /// use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
    ///
    /// // The voltage for an upward motion at 5 cm/s.
    /// let setup = Setup::new(&MODEL).set("velocity0", 0.05)?.set("valve.hysteresis", 0.0)?;
    /// let mut plant = setup.start(0.0)?;
    /// plant.trim(Given { states: &[("velocity", 0.05)], inputs: &[], free: &["valveVoltage"] })?;
    /// assert!(plant.get("valveVoltage")? > 5.4);
    /// assert!(plant.get("acceleration")?.abs() < 1e-8);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`TrimError`]; the plant is somewhere else then.
    pub fn trim(&mut self, given: Given) -> Result<(), TrimError> {
        Point::new(self, given)?.find()
    }
}

/// A variable that is moved or read.
#[derive(Clone, Debug)]
struct Own {
    variable: &'static Variable,
    place: Place,
    /// Number among the continuous states.
    state: Option<usize>,
    /// Unit of the search.
    nominal: f64,
}

/// A state that moves on at a given rate.
#[derive(Clone, Copy, Debug)]
struct Carrier {
    /// The place of the state among those that are held, and of its rate.
    place: usize,
    rate: usize,
}

/// The search for an operating point.
struct Point<'a> {
    plant: &'a mut Plant,
    /// States that are held, and their given values.
    given: Vec<(Own, f64)>,
    /// The values that are held in this search, in the same order: a faster motion, perhaps.
    held: Vec<f64>,
    /// How many of the given states have been named.
    wanted: usize,
    carriers: Vec<Carrier>,
    /// Rates that are to vanish.
    moving: Vec<Own>,
    /// States and inputs that are to be found.
    free: Vec<Own>,
    free_inputs: usize,
    fixed_input: Option<Own>,
    /// Free pressures.
    chambers: Vec<usize>,
    /// Pressures and temperatures, and their least values.
    absolute: Vec<(Own, f64)>,
}

impl<'a> Point<'a> {
    fn new(plant: &'a mut Plant, asked: Given) -> Result<Self, TrimError> {
        let table = plant.table();
        let own = |name: &str| -> Result<Own, SettingError> {
            let entry = find(table, name)?;
            let nominal = entry.variable.nominal.filter(|nominal| *nominal != 0.0).unwrap_or(1.0);
            Ok(Own { variable: entry.variable, place: entry.place, state: entry.state, nominal })
        };
        let rate_of = |state: &Variable| {
            let rate = table.iter().find(|variable| variable.derivative_of == Some(state.reference));
            rate.expect("a continuous state has a rate")
        };
        let states: Vec<&'static Variable> = plant.states().collect();
        let mut given = Vec::new();
        for (name, value) in asked.states {
            if !states.iter().any(|state| state.name == *name) {
                let reason = "it is no continuous state of this run";
                return Err(SettingError::NotSettable { name: (*name).to_owned(), reason }.into());
            }
            given.push((own(name)?, *value));
        }
        let wanted = given.len();
        let place_of =
            |given: &[(Own, f64)], name: &str| given.iter().position(|(own, _)| own.variable.name.as_str() == name);
        let mut carriers = Vec::new();
        for state in &states {
            if let Some(rate) = place_of(&given[..wanted], &rate_of(state).name) {
                let place = match place_of(&given, &state.name) {
                    Some(place) => place,
                    None => {
                        given.push((own(&state.name)?, plant.get(&state.name)?));
                        given.len() - 1
                    }
                };
                carriers.push(Carrier { place, rate });
            }
        }
        let is_carried = |state: &Variable| place_of(&given[..wanted], &rate_of(state).name).is_some();
        let mut moving = Vec::new();
        for state in states.iter().filter(|state| !is_carried(state)) {
            moving.push(own(&rate_of(state).name)?);
        }
        let free_states = states.iter().filter(|state| place_of(&given, &state.name).is_none());
        let names = free_states.map(|state| state.name.as_str()).chain(asked.free.iter().copied());
        let free = names.map(own).collect::<Result<Vec<Own>, _>>()?;
        let is_supplied = table.find(SUPPLY).is_some();
        let is_pressure = |own: &Own| is_supplied && own.state.is_some() && unit(own.variable) == "Pa";
        let chambers = (0..free.len()).filter(|place| is_pressure(&free[*place])).collect();
        let mut absolute = Vec::new();
        for state in &states {
            let value = plant.get(&state.name)?;
            if (matches!(unit(state), "Pa" | "K")) && value > 0.0 {
                absolute.push((own(&state.name)?, VACUUM * value));
            }
        }
        let fixed_input = asked.inputs.first().map(|name| own(name)).transpose()?;
        let (held, free_inputs) = (given.iter().map(|(_, value)| *value).collect(), asked.free.len());
        Ok(Self { plant, given, held, wanted, carriers, moving, free, free_inputs, fixed_input, chambers, absolute })
    }

    /// The point of a slow motion lies in the gap just beyond the dead zone of the valve, which Newton's method misses easily. The
    /// point of a faster motion is found more easily, and leads there.
    fn find(&mut self) -> Result<(), TrimError> {
        let start = self.plant.save();
        let Err(reason) = self.search(&start) else { return Ok(()) };
        let speeds = self.carriers.iter().map(|carrier| {
            let (own, value) = &self.given[carrier.rate];
            value.abs() / own.nominal
        });
        let largest = speeds.fold(0.0, f64::max);
        for power in 1..10 {
            let times = 4f64.powi(power);
            if largest > 0.0 && times * largest <= FASTEST && self.follow(&start, times) {
                return Ok(());
            }
        }
        Err(TrimError::NotFound(reason))
    }

    /// Searches the point under the held values; tells why it was not found.
    ///
    /// Around a dead zone Newton's method finds the way only from a valve that is open to the right side, so that it starts from
    /// several inputs, with the chambers as they are, then half filled. The point of a motion is looked for by Newton's method
    /// alone first, which costs little, and what friction remembers is brought there then.
    fn search(&mut self, start: &Saved) -> Result<(), String> {
        let mut starts = Vec::new();
        for filled in if self.chambers.is_empty() { &FILLED[..1] } else { &FILLED } {
            let offsets = if self.free_inputs == 0 { &OFFSETS[..1] } else { &OFFSETS };
            starts.extend(offsets.iter().map(|offset| (*filled, *offset)));
        }
        if !self.carriers.is_empty() {
            for (filled, offset) in &starts {
                self.place(start, *filled, *offset);
                if is_rest(&self.newton()) && self.lost().is_none() && self.settle().is_ok() && self.run_in().is_ok() {
                    let residual = self.newton();
                    if is_rest(&residual) && self.lost().is_none() {
                        return Ok(());
                    }
                }
            }
        }
        let (mut best, mut lost) = (DVector::from_element(self.moving.len(), f64::INFINITY), None);
        for (filled, offset) in starts {
            self.place(start, filled, offset);
            if self.settle().is_err() || self.run_in().is_err() {
                continue;
            }
            let residual = self.newton();
            if is_rest(&residual) {
                lost = self.lost();
                if lost.is_none() {
                    return Ok(());
                }
            } else if residual.norm() < best.norm() {
                best = residual;
            }
        }
        Err(lost.unwrap_or_else(|| self.left(&best)))
    }

    /// Goes to the start of a search: inputs, and chambers filled by a share of the supply.
    fn place(&mut self, start: &Saved, filled: f64, offset: f64) {
        self.plant.restore(start).expect("a state of this plant");
        let inputs = self.free.len() - self.free_inputs..self.free.len();
        for place in inputs {
            let own = self.free[place].clone();
            self.put(&own, self.plant.value(own.place) + offset * own.nominal);
        }
        if filled > 0.0 {
            let supply = self.plant.get(SUPPLY).expect("a supply");
            for place in self.chambers.clone() {
                let own = self.free[place].clone();
                let pressure = self.plant.value(own.place);
                self.put(&own, pressure + filled * (supply - pressure));
            }
        }
        self.hold();
    }

    /// Finds the point of a motion faster by a factor, and follows it down to the given motion.
    fn follow(&mut self, start: &Saved, mut times: f64) -> bool {
        self.speed(times);
        let mut is_found = self.search(start).is_ok();
        while is_found && times > 1.0 {
            times = (0.5 * times).max(1.0);
            self.speed(times);
            is_found = self.run_in().is_ok() && is_rest(&self.newton());
        }
        self.speed(1.0);
        is_found && self.lost().is_none()
    }

    /// Holds the given values, with a motion faster by a factor.
    fn speed(&mut self, times: f64) {
        self.held = self.given.iter().map(|(_, value)| *value).collect();
        for carrier in &self.carriers {
            self.held[carrier.rate] = times * self.given[carrier.rate].1;
        }
    }

    fn put(&mut self, own: &Own, value: f64) {
        match own.place {
            Place::Input(place) => self.plant.put_input(place, value),
            _ => {
                self.plant.put_state(own.state.expect("a state or an input"), value);
            }
        }
    }

    fn hold(&mut self) {
        for place in 0..self.given.len() {
            let state = self.given[place].0.state.expect("a state");
            self.plant.put_state(state, self.held[place]);
        }
    }

    /// Lets everything follow the inputs while the given states are held, until the rates vanish.
    fn settle(&mut self) -> Result<(), StepError> {
        for number in 0..SETTLING_STEPS {
            if number % CHECKED == CHECKED - 1 && is_rest(&self.residual()) {
                break;
            }
            self.plant.step(SETTLING_STEP)?;
            self.hold();
        }
        Ok(())
    }

    /// Comes to the place from behind at the given speed: held in place, friction would remember a rest.
    ///
    /// A slow motion begins faster, so that it comes far enough. The gas does not change on the way.
    fn run_in(&mut self) -> Result<(), StepError> {
        if self.carriers.iter().all(|carrier| self.held[carrier.rate] == 0.0) {
            self.hold();
            return Ok(());
        }
        let before = self.plant.save();
        let gas: Vec<f64> = self.absolute.iter().map(|(own, _)| self.plant.value(own.place)).collect();
        for carrier in self.carriers.clone() {
            let (end, speed) = (self.held[carrier.place], self.held[carrier.rate]);
            if speed != 0.0 && self.come(carrier, end, speed, &gas).is_err() {
                // There is no room behind, so close to a cover.
                self.plant.restore(&before).expect("a state of this plant");
                break;
            }
        }
        self.refill(&gas);
        self.hold();
        Ok(())
    }

    /// Puts pressures and temperatures back.
    fn refill(&mut self, gas: &[f64]) {
        for (place, value) in gas.iter().enumerate() {
            let state = self.absolute[place].0.state.expect("a state");
            self.plant.put_state(state, *value);
        }
    }

    /// Comes to the given place, at a speed in the end. There the gas stays as it is: forces that do not balance would change the
    /// speed that friction remembers.
    fn come(&mut self, carrier: Carrier, end: f64, speed: f64, gas: &[f64]) -> Result<(), StepError> {
        let fast = speed.abs().max(RUN_IN_SPEED).copysign(speed);
        let slow = end - RUN_IN_TIME * speed;
        let own = self.given[carrier.place].0.clone();
        self.put(&own, slow - RUN_IN.copysign(speed));
        self.travel(carrier, slow, fast, &[])?;
        self.travel(carrier, end, speed, gas)
    }

    /// Goes to a position at a speed; the other free values follow, but for the gas where it is given.
    fn travel(&mut self, carrier: Carrier, end: f64, speed: f64, gas: &[f64]) -> Result<(), StepError> {
        let [position, velocity] = [carrier.place, carrier.rate].map(|place| self.given[place].0.clone());
        for _ in 0..2 * SETTLING_STEPS {
            self.refill(gas);
            self.put(&velocity, speed);
            let left = (end - self.plant.value(position.place)) / speed;
            if left < 1e-9 * SETTLING_STEP {
                break;
            }
            self.plant.step(left.min(SETTLING_STEP))?;
        }
        self.put(&velocity, speed);
        Ok(())
    }

    /// Takes Newton's steps in nominal units; returns the remaining rates.
    fn newton(&mut self) -> DVector<f64> {
        let mut residual = self.residual();
        for _ in 0..NEWTON_STEPS {
            if is_rest(&residual) || !residual.iter().all(|rate| rate.is_finite()) {
                break;
            }
            let jacobian = self.jacobian();
            if !jacobian.iter().all(|entry| entry.is_finite()) {
                break;
            }
            // The shortest step, where some directions change nothing.
            let step = pseudo_inverse(&jacobian, RANK) * -&residual;
            let Some(next) = self.walk(&step, residual.norm()) else { break };
            residual = next;
        }
        residual
    }

    /// Derivatives of the rates by what is free, in nominal units.
    fn jacobian(&mut self) -> DMatrix<f64> {
        let table = self.plant.table();
        let mut inputs = vec![0.0; table.inputs().count()];
        let mut states = vec![0.0; table.number_of_states()];
        let mut computed = vec![0.0; self.plant.computed_count()];
        let mut matrix = DMatrix::zeros(self.moving.len(), self.free.len());
        for (column, own) in self.free.iter().enumerate() {
            let seed = match (own.state, own.place) {
                (Some(state), _) => &mut states[state],
                (None, Place::Input(input)) => &mut inputs[input],
                _ => unreachable!("what is free is a state or an input"),
            };
            *seed = own.nominal;
            let direction = Direction { time: 0.0, inputs: &inputs, states: &states, parameters: &[] };
            self.plant.simulation.directional_derivative(direction, &mut computed);
            states.fill(0.0);
            inputs.fill(0.0);
            for (row, rate) in self.moving.iter().enumerate() {
                if let Place::Computed(place) = rate.place {
                    matrix[(row, column)] = computed[place] / rate.nominal;
                }
            }
        }
        matrix
    }

    /// The rates in nominal units; without end where a pressure or temperature all but vanishes, or an input is not legal.
    fn residual(&self) -> DVector<f64> {
        let is_vacuum = self.absolute.iter().any(|(own, floor)| self.plant.value(own.place) <= *floor);
        let mut inputs = self.free[self.free.len() - self.free_inputs..].iter();
        let is_out = is_vacuum || inputs.any(|own| own.variable.check(self.plant.value(own.place)).is_err());
        let rate = |own: &Own| if is_out { f64::INFINITY } else { self.plant.value(own.place) / own.nominal };
        DVector::from_iterator(self.moving.len(), self.moving.iter().map(rate))
    }

    /// Goes along a direction, half as far until that is better; returns the rates there, or nothing if none is.
    fn walk(&mut self, step: &DVector<f64>, before: f64) -> Option<DVector<f64>> {
        let free = self.free.clone();
        let origin: Vec<f64> = free.iter().map(|own| self.plant.value(own.place)).collect();
        let mut share = 1.0;
        while share >= 0.5e-3 {
            for ((own, origin), step) in free.iter().zip(&origin).zip(step.iter()) {
                self.put(own, origin + share * step * own.nominal);
            }
            let residual = self.residual();
            if residual.norm() < before {
                return Some(residual);
            }
            share /= 2.0;
        }
        for (own, origin) in free.iter().zip(&origin) {
            self.put(own, *origin);
        }
        None
    }

    /// A given state that has not stayed as it was given.
    fn lost(&self) -> Option<String> {
        let mut named = self.given[..self.wanted].iter().zip(&self.held);
        named.find_map(|((own, _), wanted)| {
            let found = self.plant.value(own.place);
            let (name, unit) = (&own.variable.name, unit(own.variable));
            ((found - wanted).abs() > TOLERANCE * wanted.abs()).then(|| {
                format!("{name} = {wanted:?} {unit} was given, but the plant comes to {name} = {found:?} {unit}")
            })
        })
    }

    /// Names the states that do not come to rest.
    fn left(&self, residual: &DVector<f64>) -> String {
        if !residual.iter().all(|rate| rate.is_finite()) {
            return "pressures or temperatures would have to vanish".to_owned();
        }
        let worst = residual.iamax();
        let rate = &self.moving[worst];
        let stays =
            format!("{} stays at {:.3e} {}", rate.variable.name, residual[worst] * rate.nominal, unit(rate.variable));
        if let Some(input) = self.fixed_input.as_ref().filter(|_| self.carriers.is_empty()) {
            let (name, value) = (&input.variable.name, self.plant.value(input.place));
            let speed = self.moving.iter().find(|rate| unit(rate.variable) == "m/s");
            let speed = speed.map_or("velocity", |rate| rate.variable.name.as_str());
            return format!(
                "with {name} = {value:?} {} nothing balances at rest: {stays}. Give a motion in place of the input, for example \
                 {speed} = 0.05 m/s, and the {name} that keeps it up is found; or leave {name} out",
                unit(input.variable)
            );
        }
        format!(
            "{stays}. Within the play of valve.hysteresis and within a dead zone without leakage the valve does not react; a \
             mass that sticks does not either"
        )
    }
}

/// The name of a unit; none of what is no real number.
fn unit(variable: &Variable) -> &'static str {
    if let Kind::Real(unit) = variable.kind { unit.name } else { "" }
}

fn is_rest(residual: &DVector<f64>) -> bool {
    residual.iter().all(|rate| rate.abs() < TOLERANCE)
}
