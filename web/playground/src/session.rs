//! The session of the page: a few plants, and the buffer through which numbers go.

use pneumatic_servo::model::Plant;
use pneumatic_servo::model::{Model, Setup};
use pneumatic_servo::models;

use crate::CallError;
use crate::index::{item, no_such};
use crate::ssv::ssv;

/// Numbers in the buffer.
pub const BUFFER: usize = 4096;
/// Most plants at a time.
pub const SLOTS: usize = 8;

/// Plants in numbered slots, and the buffer. Models and variables are known by their places in [`models::ALL`] and in
/// the table of the model.
pub struct Session {
    plants: [Option<Plant>; SLOTS],
    /// Numbers from the page, and back.
    pub buffer: [f64; BUFFER],
}

impl Default for Session {
    fn default() -> Self {
        Self { plants: [const { None }; SLOTS], buffer: [0.0; BUFFER] }
    }
}

impl Session {
    /// Starts a model at time 0 with the changes in the buffer: `count` numbers, variable and value in turn.
    ///
    /// # Errors
    /// [`CallError`]; the slot keeps what it had then.
    pub fn start(&mut self, slot: usize, model: usize, count: usize) -> Result<(), CallError> {
        let model: &'static Model = models::ALL.get(model).ok_or(no_such("model", model))?;
        let mut setup = Setup::new(model);
        for pair in self.numbers(count)?.chunks_exact(2) {
            let variable = item(model.table(), "variable", pair[0])?;
            setup.change(&variable.name, pair[1])?;
        }
        let plant = setup.start(0.0)?;
        *self.plants.get_mut(slot).ok_or(no_such("slot", slot))? = Some(plant);
        Ok(())
    }

    /// Sets inputs and tunable parameters of a running plant: `count` numbers, variable and value in turn.
    ///
    /// # Errors
    /// [`CallError`]; what stands before the refused pair is set then.
    pub fn set(&mut self, slot: usize, count: usize) -> Result<(), CallError> {
        self.numbers(count)?;
        let (plant, buffer) = self.plant(slot)?;
        for pair in buffer[..count].chunks_exact(2) {
            let variable = item(plant.table(), "variable", pair[0])?;
            plant.set(&variable.name, pair[1])?;
        }
        Ok(())
    }

    /// Lets a plant run to a time in s.
    ///
    /// # Errors
    /// [`CallError`]; the plant is then where the solver had to stop.
    pub fn advance(&mut self, slot: usize, end: f64) -> Result<(), CallError> {
        let (plant, _) = self.plant(slot)?;
        if !(end.is_finite() && end >= plant.time()) {
            return Err(CallError::Time { end });
        }
        Ok(plant.advance_to(end)?)
    }

    /// Replaces the first `count` numbers of the buffer, which are variables, by their values.
    ///
    /// # Errors
    /// [`CallError`] if one of them is no variable.
    pub fn read(&mut self, slot: usize, count: usize) -> Result<(), CallError> {
        self.numbers(count)?;
        let (plant, buffer) = self.plant(slot)?;
        for number in &mut buffer[..count] {
            let variable = item(plant.table(), "variable", *number)?;
            *number = plant.get(&variable.name)?;
        }
        Ok(())
    }

    /// The first `count` numbers in the buffer, and the texts in the `bytes` behind them, as SSV: for each part of a system
    /// model, how many numbers follow, then variable and value in turn; name, description and time of the set, then what
    /// stands before the names of each part, with a zero behind each text.
    ///
    /// # Errors
    /// [`CallError`] for what is not there, a value that is not legal, or bytes that are no text.
    pub fn ssv(&self, count: usize, bytes: usize) -> Result<String, CallError> {
        let numbers = self.numbers(count)?;
        let behind: Vec<u8> = self.buffer[count..].iter().flat_map(|number| number.to_le_bytes()).collect();
        let texts = behind.get(..bytes).ok_or(CallError::TooMany { count: count + bytes.div_ceil(8) })?;
        ssv(numbers, str::from_utf8(texts).map_err(|_| CallError::NoText)?)
    }

    fn numbers(&self, count: usize) -> Result<&[f64], CallError> {
        self.buffer.get(..count).ok_or(CallError::TooMany { count })
    }

    fn plant(&mut self, slot: usize) -> Result<(&mut Plant, &mut [f64; BUFFER]), CallError> {
        let plant = self.plants.get_mut(slot).and_then(Option::as_mut).ok_or(no_such("plant", slot))?;
        Ok((plant, &mut self.buffer))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(name: &str) -> f64 {
        let table = models::ALL[0].table();
        table.iter().position(|variable| variable.name == name).expect("a variable") as f64
    }

    fn with(numbers: &[f64]) -> Session {
        let mut session = Session::default();
        session.buffer[..numbers.len()].copy_from_slice(numbers);
        session
    }

    #[test]
    fn a_run_has_the_bits_of_the_library() {
        let law = 14.0;
        let mut session = with(&[place("friction.law"), law, place("valveVoltage"), 7.0]);
        session.start(3, 0, 4).expect("started");
        let mut plant = Setup::new(&models::ALL[0]).set("friction.law", "LuGre").expect("a law");
        plant.change("valveVoltage", 7.0).expect("an input");
        let mut plant = plant.start(0.0).expect("started");
        for k in 1..=300 {
            let end = f64::from(k) * 1e-3;
            session.advance(3, end).expect("a step");
            plant.advance_to(end).expect("a step");
        }
        let names = ["position", "frictionForce", "chamberA.pressure"];
        session.buffer[..3].copy_from_slice(&names.map(place));
        session.read(3, 3).expect("values");
        assert!(session.buffer[0] > 0.251, "the carriage moves");
        assert_eq!(session.buffer[..3], names.map(|name| plant.get(name).expect("a value")));
    }

    #[test]
    fn refusals_are_those_of_the_library() {
        let refusal = |name: &str, value: f64| with(&[place(name), value]).start(0, 0, 2).unwrap_err().to_string();
        assert!(refusal("cylinder.bore", -1.0).starts_with("cylinder.bore = -1 is refused: it must be at least"));
        assert!(refusal("cylinder.rod", 0.016).starts_with("cylinder.rod = 0.016 is refused"));
        assert_eq!(refusal("position", 0.1), "position cannot be set: it is computed");
        assert!(refusal("supplyPressure", f64::NAN).contains("finite number"));
    }

    #[test]
    fn nothing_the_page_can_pass_panics() {
        let strange = [f64::NAN, f64::INFINITY, -1.0, 0.5, -0.0, f64::NEG_INFINITY];
        for number in strange {
            let mut session = with(&[number, number]);
            let _ = session.start(0, 0, 2);
            let _ = session.start(0, usize::MAX, 0);
            let _ = session.start(usize::MAX, 0, 0);
            let _ = session.start(0, 0, usize::MAX);
            session.start(0, 0, 0).expect("the defaults");
            let _ = session.set(0, 2);
            let _ = session.set(1, 2);
            let _ = session.set(0, BUFFER + 1);
            let _ = session.read(0, 1);
            let _ = session.read(0, BUFFER + 1);
            let _ = session.advance(usize::MAX, number);
            let _ = session.ssv(2, 8);
            let _ = session.ssv(BUFFER, 1);
            let _ = session.ssv(0, usize::MAX);
            let _ = session.ssv(usize::MAX, 0);
            assert_eq!(session.advance(0, number).is_ok(), (0.0..1.0).contains(&number), "{number}");
        }
    }

    #[test]
    fn texts_stand_behind_the_numbers() {
        let mut session = with(&[0.0, 2.0, place("supplyPressure"), 6e5]);
        let texts = "Däs\0\0now\0a.\0".as_bytes();
        let words = texts.chunks(8).enumerate();
        words.for_each(|(place, bytes)| {
            let mut word = [0; 8];
            word[..bytes.len()].copy_from_slice(bytes);
            session.buffer[4 + place] = f64::from_le_bytes(word);
        });
        let text = session.ssv(4, texts.len()).expect("a text");
        assert!(text.contains("name=\"Däs\" ") && text.contains("\"a.supplyPressure\""), "{text}");
        assert_eq!(session.ssv(4, 2), Err(CallError::NoText), "half a letter");
        assert_eq!(session.ssv(4, 8 * BUFFER), Err(CallError::TooMany { count: BUFFER + 4 }));
    }

    #[test]
    fn a_step_does_not_end_in_the_past() {
        let mut session = Session::default();
        session.start(0, 0, 0).expect("the defaults");
        session.advance(0, 0.1).expect("a step");
        assert_eq!(session.advance(0, 0.05), Err(CallError::Time { end: 0.05 }));
    }
}
