//! A sensor: its reading of the measured quantity.

use serde::{Deserialize, Serialize};

use crate::numbers::{Number, Scalar, Tangent, Varying, random};
use crate::parameter_group;
use crate::system::Sample;
use crate::variables::{Fixed, Meaning, ParameterError, Unit, Variable, units};

/// Quantity that a sensor measures.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Its unit.
    pub unit: Unit,
    /// Unit to show it in.
    pub display: Option<&'static str>,
    /// Largest value of any sensor of it.
    pub most: f64,
    /// Magnitude of the errors of a sensor.
    pub error: f64,
}

/// Discrete state of a sensor with a sample time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory<S> {
    reading: S,
    /// Number of the next sample.
    next: u64,
    random: u64,
}

/// Shortest lag and sample time in s but for 0.
const SHORTEST: f64 = 1e-5;

impl Quantity {
    /// A parameter of a sensor of it that is a part of its error.
    fn of_error(self, reference: u32, name: &str) -> Variable {
        let variable = Variable::parameter(reference, name, self.unit, 0.0);
        let variable = Variable { display: self.display, ..variable }.range(0.0, self.most);
        variable.plausible(2e-3 * self.error, 1e2 * self.error).nominal(self.error)
    }
}

parameter_group! {
    /// A sensor with lag, offset, noise, resolution and sample time; with all of them 0 it reads the quantity itself.
    ///
    /// ```text
    /// tau*dz/dt = y - z                                          lag of the quantity y; z = y if tau = 0
    /// reading   = z + offset                                     if T = 0
    /// reading   = r*round((z(t_k) + offset + noise*n_k)/r)       from t_k = k*T on, until the next sample
    /// ```
    ///
    /// `n_k` are independent numbers of the standard normal distribution, the same in each run with the same seed. Without a
    /// resolution `r` nothing is rounded.
    ///
    /// # Validity
    /// A linear sensor of first order without saturation. Only its lag limits aliasing.
    ///
    /// # Errors
    /// [`ParameterError`] for noise or a resolution without a sample time, since only samples have them, and for a lag or a
    /// sample time shorter than a clock can follow.
    Sensor(group: &str, base: u32, quantity: Quantity) {
        offset: Fixed = quantity.of_error(0, "offset").range(-quantity.most, quantity.most).plausible(-500.0 * quantity.error, 500.0 * quantity.error)
            .text("Constant error of the sensor, added to the signal").within(group, base);
        lag: Fixed = time(1, "lag").absent_at_zero()
            .text("Time constant of the sensor, first order; 0: none").within(group, base);
        noise: Fixed = quantity.of_error(2, "noise")
            .text("Standard deviation of the noise of a sample; needs a sample time").within(group, base);
        resolution: f64 = quantity.of_error(3, "resolution")
            .text("Resolution: the readings are multiples of it; 0: not rounded. Needs a sample time").within(group, base);
        sample_time: f64 = time(4, "sampleTime").meaning(Meaning::Sampling)
            .text("Time between samples, from the start on; 0: the reading is continuous").within(group, base);
    }
}

fn time(reference: u32, name: &str) -> Variable {
    Variable::parameter(reference, name, units::SECOND, 0.0)
        .range(0.0, 1e3)
        .plausible(1e-5, 2.0)
        .nominal(5e-3)
        .shown_in("ms")
}

impl Sensor {
    /// Refuses contradictory parameters.
    ///
    /// # Errors
    /// [`ParameterError`] that names the variable without its group.
    pub fn check(&self) -> Result<(), ParameterError> {
        for (name, value) in [("lag", self.lag.value), ("sampleTime", self.sample_time)] {
            if value > 0.0 && value < SHORTEST {
                return Err(ParameterError::new(name, value, &format!("it must be 0 or at least {SHORTEST}")));
            }
        }
        for (name, value) in [("noise", self.noise.value), ("resolution", self.resolution)] {
            if value > 0.0 && self.sample_time == 0.0 {
                return Err(ParameterError::new(name, value, "only samples have it: set sampleTime, too"));
            }
        }
        Ok(())
    }

    /// Whether it reads anything but the quantity.
    pub fn is_used(&self) -> bool {
        [self.offset, self.lag, self.noise].into_iter().any(Tangent::is_used)
            || self.resolution != 0.0
            || self.sample_time != 0.0
    }

    /// Whether it has a state.
    pub fn has_lag(&self) -> bool {
        self.lag > 0.0
    }

    /// Discrete state at the start, with a seed of its own, of a quantity that was constant before.
    pub fn start<S: Varying>(&self, quantity: S, seed: u64) -> Memory<S> {
        let mut memory = Memory { reading: S::zero(), next: 0, random: seed };
        self.sample(quantity, quantity, &mut memory);
        memory
    }

    /// Rate of its state, if it has a lag.
    pub fn rate<S: Scalar>(&self, quantity: S, lagged: S) -> S {
        // No lag is shorter. Compilers divide before they ask whether there is one, which a host that traps divisions by zero would
        // not survive.
        (quantity - lagged) / self.lag.max(Tangent::still(SHORTEST))
    }

    /// The reading.
    pub fn reading<S: Scalar>(&self, quantity: S, lagged: S, memory: &Memory<S::Held>) -> S {
        if self.sample_time > 0.0 { S::held(memory.reading) } else { self.seen(quantity, lagged) }
    }

    /// The next sample.
    pub fn next_sample<S: Varying>(&self, memory: &Memory<S>) -> Sample<S> {
        if self.sample_time == 0.0 {
            return Sample::never();
        }
        Sample::periodic(S::of(memory.next as f64 * self.sample_time), self.sample_time)
    }

    /// Takes a sample. One that is rounded has no derivative.
    pub fn sample<S: Varying>(&self, quantity: S, lagged: S, memory: &mut Memory<S>) {
        let mut reading = self.seen(quantity, lagged);
        if self.noise.is_used() {
            reading = reading + self.noise * random::normal(&mut memory.random);
        }
        if self.resolution > 0.0 {
            reading = reading.chain(self.resolution * (reading.value() / self.resolution).round(), f64::NAN);
        }
        (memory.reading, memory.next) = (reading, memory.next + 1);
    }

    fn seen<S: Scalar>(&self, quantity: S, lagged: S) -> S {
        (if self.has_lag() { lagged } else { quantity }) + self.offset
    }
}

impl<S: Scalar> Memory<S> {
    /// Whether a sensor can have left it.
    pub fn is_sound(&self) -> bool {
        self.reading.value().is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;

    const PERFECT: Sensor =
        Sensor { offset: still(0.0), lag: still(0.0), noise: still(0.0), resolution: 0.0, sample_time: 0.0 };

    const fn still(value: f64) -> Tangent {
        Tangent::still(value)
    }

    fn reading(sensor: &Sensor, quantity: f64, lagged: f64, memory: &Memory<Real>) -> f64 {
        sensor.reading(Real::of(quantity), Real::of(lagged), memory).value
    }

    #[test]
    fn sensor_without_faults_reads_the_quantity() {
        assert!(!PERFECT.is_used());
        let memory = PERFECT.start(Real::of(3.0), 1);
        assert_eq!(reading(&PERFECT, 4.0, 7.0, &memory), 4.0);
        assert_eq!(PERFECT.next_sample(&memory), Sample::never());
    }

    #[test]
    fn sample_is_rounded_and_held() {
        let sensor = Sensor { offset: still(0.02), resolution: 0.25, sample_time: 1e-3, ..PERFECT };
        let mut memory = sensor.start(Real::of(1.0), 1);
        assert_eq!(reading(&sensor, 5.0, 0.0, &memory), 1.0);
        for (quantity, expected) in [(1.1, 1.0), (1.11, 1.25), (-0.2, -0.25)] {
            sensor.sample(Real::of(quantity), Real::of(0.0), &mut memory);
            assert_eq!(reading(&sensor, 5.0, 0.0, &memory), expected);
        }
        assert_eq!(sensor.next_sample(&memory).time.value, 4e-3);
    }

    /// Of 10,000 numbers the mean is off by a hundredth of the deviation, that by 0.7 %.
    #[test]
    fn noise_has_its_standard_deviation() {
        let sensor = Sensor { noise: still(0.5), sample_time: 1e-3, ..PERFECT };
        let mut memory = sensor.start(Real::of(0.0), 12);
        let errors: Vec<f64> = (0..10_000)
            .map(|_| {
                sensor.sample(Real::of(2.0), Real::of(0.0), &mut memory);
                reading(&sensor, 0.0, 0.0, &memory) - 2.0
            })
            .collect();
        let mean = errors.iter().sum::<f64>() / 1e4;
        let deviation = (errors.iter().map(|error| error * error).sum::<f64>() / 1e4).sqrt();
        assert!(mean.abs() < 0.02 && (deviation / 0.5 - 1.0).abs() < 0.03, "{mean} {deviation}");
        let next = errors.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / 1e4;
        assert!(next.abs() < 0.03 * 0.25, "{next} from one to the next");
    }

    #[test]
    fn noise_without_samples_is_refused_by_name() {
        for (sensor, expected) in [
            (
                Sensor { noise: still(0.1), ..PERFECT },
                "noise = 0.1 is refused: only samples have it: set sampleTime, too",
            ),
            (
                Sensor { resolution: 2.0, ..PERFECT },
                "resolution = 2 is refused: only samples have it: set sampleTime, too",
            ),
            (Sensor { lag: still(1e-7), ..PERFECT }, "lag = 0.0000001 is refused: it must be 0 or at least 0.00001"),
        ] {
            assert_eq!(sensor.check().unwrap_err().to_string(), expected);
        }
    }
    #[test]
    fn reading_that_is_no_number_is_not_sound() {
        let memory = |reading: f64| Memory { reading: Real::of(reading), ..PERFECT.start(Real::of(0.0), 1) };
        assert!(memory(-3.0).is_sound());
        assert!([f64::NAN, f64::INFINITY].iter().all(|reading| !memory(*reading).is_sound()));
    }
}
