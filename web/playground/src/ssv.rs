//! Parameter sets of the page as SSV.

use pneumatic_servo::models;
use pneumatic_servo_ssp::{Parameter, ParameterSet, Version};

use crate::CallError;
use crate::index::{item, no_such};

const TOOL: &str = concat!("pneumatic-servo-playground ", env!("CARGO_PKG_VERSION"));

/// The file for numbers and texts of the page, as [`Session::ssv`](crate::Session::ssv) takes them.
///
/// # Errors
/// [`CallError`] for a model, variable or text that is not there, or a value that is not legal.
pub fn ssv(mut numbers: &[f64], texts: &str) -> Result<String, CallError> {
    let texts: Vec<&str> = texts.split_terminator('\0').collect();
    let [name, description, time, prefixes @ ..] = &texts[..] else { return Err(no_such("text", texts.len())) };
    let mut parameters = Vec::new();
    for part in 0.. {
        let [model, count, rest @ ..] = numbers else { break };
        let model = item(models::ALL, "model", *model)?;
        let count = *count as usize;
        let (pairs, others) = rest.split_at_checked(count).ok_or(CallError::TooMany { count })?;
        let prefix = prefixes.get(part).ok_or(no_such("text", part + 3))?;
        for pair in pairs.chunks_exact(2) {
            let variable = item(model.table(), "variable", pair[0])?;
            parameters.push(Parameter::new(format!("{prefix}{}", variable.name), variable, pair[1])?);
        }
        numbers = others;
    }
    let set = ParameterSet { version: Version::One, name, description, tool: TOOL, time: Some(time), parameters };
    Ok(set.text().expect("memory takes every text"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXTS: &str = "Loop\0Set \"here\"\x002026-01-02T03:04:05Z\0plant.\0controller.\0";

    /// The numbers of a model and of one of its variables.
    fn places(model: &str, name: &str) -> [f64; 2] {
        let place = models::ALL.iter().position(|known| known.name == model).expect("a model");
        let variables = models::ALL[place].table();
        let variable = variables.iter().position(|variable| variable.name == name).expect("a variable");
        [place, variable].map(|place| place as f64)
    }

    #[test]
    fn values_of_several_models_have_the_names_of_their_parts() {
        let [cylinder, law] = places("PneumaticServoCylinder", "friction.law");
        let [_, supply] = places("PneumaticServoCylinder", "supplyPressure");
        let [controller, gain] = places("PositionController", "gain.position");
        let text = ssv(&[cylinder, 4.0, law, 14.0, supply, 6e5, controller, 2.0, gain, 30.0], TEXTS).expect("a text");
        for part in [
            r#"name="Loop" description="Set &quot;here&quot;" generationTool="pneumatic-servo-playground "#,
            r#" generationDateAndTime="2026-01-02T03:04:05Z">"#,
            "<ssv:Parameter name=\"plant.friction.law\">\n      <ssv:Enumeration value=\"LuGre\"/>",
            "<ssv:Parameter name=\"plant.supplyPressure\">\n      <ssv:Real value=\"600000.0\" unit=\"Pa\"/>",
            "<ssv:Parameter name=\"controller.gain.position\">\n      <ssv:Real value=\"30.0\" unit=\"",
            r#"<ssc:BaseUnit kg="1" m="-1" s="-2"/>"#,
        ] {
            assert!(text.contains(part), "{part} is not in {text}");
        }
    }

    #[test]
    fn what_is_not_there_is_refused() {
        let [cylinder, supply] = places("PneumaticServoCylinder", "supplyPressure");
        let refused = |numbers: &[f64], texts| ssv(numbers, texts).expect_err("a refusal").to_string();
        assert_eq!(refused(&[cylinder, 2.0, supply, 6e5], "a\0b\0"), "there is no text 2");
        assert_eq!(refused(&[cylinder, 2.0, supply, 6e5], "a\0b\0c\0"), "there is no text 3");
        assert_eq!(refused(&[0.5, 2.0, supply, 6e5], TEXTS), "there is no model 0.5");
        assert_eq!(refused(&[cylinder, 2.0, f64::NAN, 6e5], TEXTS), "there is no variable NaN");
        assert_eq!(refused(&[cylinder, 4.0, supply, 6e5], TEXTS), "4 numbers are more than the buffer has");
        let negative = refused(&[cylinder, 2.0, supply, -1.0], TEXTS);
        assert!(negative.starts_with("supplyPressure = -1 is refused"), "{negative}");
    }
}
