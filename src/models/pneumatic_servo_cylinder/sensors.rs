//! The sensors of the rig: of position, of both pressures, and of the force between rod and carriage.
//!
//! Their readings stand beside the quantities themselves, and act on nothing: with samples at communication points they change no
//! bit of a run. Sensors with a lag have states, in front of the position, which the step control follows; a cylinder whose sensors
//! have none has none of these.

use super::states::State;
use crate::numbers::{Scalar, Varying, random};
use crate::parameters;
use crate::sensor::{self, Quantity, Sensor};
use crate::system::{Part, PartFacts, Sample, StateLabel};
use crate::variables::{ParameterError, Variable, units};

/// Number of sensors.
pub const COUNT: usize = 4;

/// Discrete states of the sensors.
pub type Memory<S> = [sensor::Memory<S>; COUNT];

const NAMES: [&str; COUNT] = ["position", "pressureA", "pressureB", "force"];
/// Names of the readings.
const HELD: [&str; COUNT] =
    ["sensor.position.reading", "sensor.pressureA.reading", "sensor.pressureB.reading", "sensor.force.reading"];
const TEXTS: [&str; COUNT] =
    ["position", "absolute pressure in chamber A", "absolute pressure in chamber B", "force between rod and carriage"];
const LENGTH: Quantity = Quantity { unit: units::METRE, display: Some("mm"), most: 10.0, error: 1e-4 };
const PRESSURE: Quantity = Quantity { unit: units::PASCAL, display: Some("bar"), most: 1e8, error: 1e3 };
const FORCE: Quantity = Quantity { unit: units::NEWTON, display: None, most: 1e6, error: 0.1 };
const QUANTITIES: [Quantity; COUNT] = [LENGTH, PRESSURE, PRESSURE, FORCE];
/// Magnitudes of the quantities, for error control.
const SCALES: [f64; COUNT] = [0.1, 1e5, 1e5, 10.0];

/// Value references of the readings; the states and their rates follow.
const READINGS: u32 = 240;
const LAGGED: u32 = READINGS + COUNT as u32;
const RATES: u32 = LAGGED + COUNT as u32;

parameters! {
    /// The parameters of the sensors.
    Sensors {
        position: Sensor = Sensor::variables("sensor.position", 1300, LENGTH);
        pressure_a: Sensor = Sensor::variables("sensor.pressureA", 1310, PRESSURE);
        pressure_b: Sensor = Sensor::variables("sensor.pressureB", 1320, PRESSURE);
        force: Sensor = Sensor::variables("sensor.force", 1330, FORCE);
        seed: u64 = Variable::count(1340, "sensor.seed", 1).range(0.0, f64::from(i32::MAX))
            .text("Seed of the noise of all sensors");
    }
}

impl Sensors {
    fn all(&self) -> [&Sensor; COUNT] {
        [&self.position, &self.pressure_a, &self.pressure_b, &self.force]
    }

    /// Whether any of them reads anything but its quantity.
    pub fn are_used(&self) -> bool {
        self.all().into_iter().any(Sensor::is_used)
    }

    /// Puts values of their states among those of the cylinder, if they have any.
    #[inline(always)]
    pub fn put<T: Copy>(&self, values: &[T; COUNT], x: &mut [T]) {
        if self.states() > 0 {
            let first = State::Position.at(x.len()) - COUNT;
            x[first..][..COUNT].copy_from_slice(values);
        }
    }

    /// Refuses contradictory parameters.
    ///
    /// # Errors
    /// [`ParameterError`] of the sensor.
    pub fn check(&self) -> Result<(), ParameterError> {
        for (sensor, name) in self.all().into_iter().zip(NAMES) {
            sensor.check().map_err(|error| error.within(name).within("sensor"))?;
        }
        Ok(())
    }

    /// Names of the readings that are rounded, in the memory of all.
    pub fn rounded(&self) -> Vec<String> {
        let has_resolution = |(_, sensor): &(usize, &Sensor)| sensor.resolution > 0.0;
        let rounded = self.all().into_iter().enumerate().filter(has_resolution);
        rounded.map(|(place, _)| format!("sensors[{}].reading", place + 1)).collect()
    }

    /// How the number that fields lead to in the memory of all is told, if it is theirs: the reading of a sensor that takes no samples
    /// is computed from its quantity.
    pub fn state_label(&self, fields: &str) -> Option<StateLabel> {
        let place = (0..COUNT).find(|place| fields == format!("sensors[{}].reading", place + 1))?;
        let is_sampled = self.all()[place].sample_time > 0.0;
        Some(if is_sampled { StateLabel::Variable(HELD[place]) } else { StateLabel::Nothing })
    }

    /// Discrete states at the start, with quantities that were constant before.
    pub fn start<S: Varying>(&self, quantities: [S; COUNT]) -> Memory<S> {
        let (all, mut seeds) = (self.all(), self.seed);
        std::array::from_fn(|place| all[place].start(quantities[place], random::next(&mut seeds)))
    }

    /// Their states, 0 if they have none.
    pub fn lagged<S: Scalar>(&self, x: &[S]) -> [S; COUNT] {
        if self.states() == 0 {
            return [S::zero(); COUNT];
        }
        std::array::from_fn(|place| x[State::Position.at(x.len()) - COUNT + place])
    }

    /// Rates of their states.
    pub fn rates<S: Scalar>(&self, quantities: [S; COUNT], lagged: [S; COUNT]) -> [S; COUNT] {
        let all = self.all();
        std::array::from_fn(|place| {
            if all[place].has_lag() { all[place].rate(quantities[place], lagged[place]) } else { S::zero() }
        })
    }

    /// The readings.
    pub fn readings<S: Scalar>(
        &self,
        quantities: [S; COUNT],
        lagged: [S; COUNT],
        memory: &Memory<S::Held>,
    ) -> [S; COUNT] {
        let all = self.all();
        std::array::from_fn(|place| all[place].reading(quantities[place], lagged[place], &memory[place]))
    }

    /// Number of their variables.
    pub const COMPUTED: usize = 3 * COUNT;

    /// Readings, states and rates as variables; `quantities` lists the dependences of each quantity, `starts` the inputs on
    /// which it depends at the start.
    pub fn computed(quantities: [&[u32]; COUNT], starts: [&[u32]; COUNT]) -> Vec<Variable> {
        let known = |place: usize| [quantities[place], &[LAGGED + place as u32]].concat();
        let variable = |first: u32, place: usize, name: &str| {
            let Quantity { unit, display, .. } = QUANTITIES[place];
            let variable = Variable::output(first + place as u32, name, unit);
            Variable { display, ..variable }.nominal(SCALES[place])
        };
        let reading = |place: usize| {
            variable(READINGS, place, HELD[place])
                .depends_on(&known(place))
                .text(&format!("Reading of the sensor of the {}", TEXTS[place]))
        };
        let lagged = |place: usize| {
            variable(LAGGED, place, &format!("sensor.{}.lagged", NAMES[place]))
                .local()
                .depends_on(&[LAGGED + place as u32])
                .starts_from(starts[place])
                .text(&format!("Output of the first-order lag of the sensor of the {}; 0 without a lag", TEXTS[place]))
        };
        let rate = |place: usize| {
            let unit =
                [units::METRE_PER_SECOND, units::PASCAL_PER_SECOND, units::PASCAL_PER_SECOND, units::NEWTON_PER_SECOND];
            let name = format!("der(sensor.{}.lagged)", NAMES[place]);
            Variable::output(RATES + place as u32, &name, unit[place])
                .local()
                .derivative_of(LAGGED + place as u32)
                .depends_on(&known(place))
                .text(&format!("Rate of the state of the lag of the sensor of the {}", TEXTS[place]))
        };
        let all = 0..COUNT;
        all.clone().map(reading).chain(all.clone().map(lagged)).chain(all.map(rate)).collect()
    }
}

impl PartFacts for Sensors {
    /// Those of sensors without a lag rest.
    fn states(&self) -> usize {
        if self.all().into_iter().any(Sensor::has_lag) { COUNT } else { 0 }
    }

    fn state_at(&self, reference: u32, n: usize) -> Option<usize> {
        let place = reference.checked_sub(LAGGED)? as usize;
        self.all().get(place)?.has_lag().then_some(State::Position.at(n) - COUNT + place)
    }

    fn write_scales(&self, scales: &mut [f64]) {
        self.put(&SCALES, scales);
    }
}

impl Part for Sensors {
    type Memory<S: Varying> = Memory<S>;
    /// The quantities.
    type Sees<S: Scalar> = [S; COUNT];

    const SHOWS: bool = true;

    fn next_sample<S: Varying>(&self, memory: &Memory<S>) -> Sample<S> {
        let samples = self.all().into_iter().zip(memory).map(|(sensor, memory)| sensor.next_sample(memory));
        samples.fold(Sample::never(), Sample::earlier)
    }

    fn sample<S: Varying>(&self, time: f64, quantities: &[S; COUNT], x: &mut [S], memory: &mut Memory<S>) {
        let lagged = self.lagged(x);
        for (place, (sensor, memory)) in self.all().into_iter().zip(memory).enumerate() {
            if sensor.next_sample(memory).is_due_at(time) {
                sensor.sample(quantities[place], lagged[place], memory);
            }
        }
    }

    fn fits<S: Varying>(&self, memory: &Memory<S>) -> bool {
        memory.iter().all(sensor::Memory::is_sound)
    }
}
