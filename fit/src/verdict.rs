//! The worth of a fit: a traffic light, and findings in words.

use crate::arrays::mean;
use crate::fitting::Answer;
use crate::numerals::significant;

/// Share of a signal's standard deviation that no model of it leaves as residual.
const MISSED: f64 = 0.5;
/// Ratio of a residual to the noise of a sensor that shows an error of the model.
const LOUD: f64 = 3.0;
/// Ratios of the residual of validation data to the fitted one: predicted badly, or not at all.
const OFF: [f64; 2] = [1.5, 3.0];

/// A light, the worst last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Light {
    /// The law describes the data as far as they tell.
    Green,
    /// Something has to be looked at before the values are used.
    Yellow,
    /// The values do not describe the machine.
    Red,
}

impl Light {
    /// All of them, the worst last.
    pub const ALL: [Self; 3] = [Self::Green, Self::Yellow, Self::Red];

    /// The light of the RMS residual of a signal, by the standard deviation of its samples and by the noise of its sensor.
    pub fn of_residual(rms: f64, spread: f64, noise: f64) -> Self {
        if rms.is_nan() || rms > MISSED * spread {
            Self::Red
        } else if rms > LOUD * noise {
            Self::Yellow
        } else {
            Self::Green
        }
    }

    /// The light of a prediction, by the ratio of the RMS residuals of validation data and of fitted data.
    pub fn of_prediction(ratio: f64) -> Self {
        let [off, far] = OFF;
        match ratio {
            ratio if ratio <= off => Self::Green,
            ratio if ratio <= far => Self::Yellow,
            _ => Self::Red,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Green => "green",
            Self::Yellow => "yellow",
            Self::Red => "red",
        }
    }

    /// Its meaning in a sentence, without the full stop.
    pub fn head(self) -> &'static str {
        match self {
            Self::Green => "The law describes the data as far as they tell",
            Self::Yellow => "Look at this before the values are used",
            Self::Red => "These values do not describe the machine",
        }
    }
}

/// One reason for a light, in a sentence without the full stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Its light.
    pub light: Light,
    /// Its sentence.
    pub text: String,
}

/// Findings, the worst first, and the light of the worst.
pub fn verdict(answer: &Answer) -> (Light, Vec<Finding>) {
    let mut findings = of_search(answer);
    findings.extend(of_residuals(answer));
    findings.extend(of_prediction(answer));
    let cause = answer.cause.iter().map(|cause| Finding { light: Light::Yellow, text: cause.text.clone() });
    findings.splice(0..0, cause);
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.light));
    (findings.first().map_or(Light::Green, |finding| finding.light), findings)
}

fn of_search(answer: &Answer) -> Vec<Finding> {
    let end = format!("The search did not converge: {}", answer.message);
    let search = (!answer.converged).then_some(Finding { light: Light::Red, text: end });
    let undetermined = answer.estimates.iter().filter_map(|one| {
        let text = format!("{} is not identifiable: {}", one.parameter.0, one.undetermined?);
        Some(Finding { light: Light::Yellow, text })
    });
    search.into_iter().chain(undetermined).collect()
}

fn of_residuals(answer: &Answer) -> Vec<Finding> {
    let of_signal = |(signal, rms): (&&'static str, &f64)| {
        let spread = spread(answer, signal);
        let noise = answer.noise.get(signal).copied().unwrap_or(f64::INFINITY);
        let (unit, residual) = (answer.units.of_signal(signal), format!("RMS residual of {signal}: {}", short(*rms)));
        let light = Light::of_residual(*rms, spread, noise);
        let text = match light {
            Light::Red => format!(
                "{residual} {unit}, and the signal varies by {} {unit}: look at signs, units, and the supply, mass and \
                 bore that were assumed",
                short(spread)
            ),
            Light::Yellow => format!(
                "{residual} {unit}, {} times the noise of its sensor: the law, or a fixed parameter, misses something",
                short(rms / noise)
            ),
            Light::Green => format!("{residual} {unit}, about the noise of its sensor"),
        };
        Finding { light, text }
    };
    answer.rms.iter().map(of_signal).collect()
}

/// Standard deviation of the measured samples of a signal.
fn spread(answer: &Answer, signal: &str) -> f64 {
    let courses = answer.courses.iter().flat_map(|course| &course.readings);
    let measured: Vec<f64> =
        courses.filter(|(name, ..)| *name == signal).flat_map(|(_, measured, _)| measured.iter().copied()).collect();
    let middle = mean(&measured);
    let squares: Vec<f64> = measured.iter().map(|value| (value - middle) * (value - middle)).collect();
    mean(&squares).sqrt()
}

fn of_prediction(answer: &Answer) -> Vec<Finding> {
    let of_signal = |(signal, validation): (&&'static str, &f64)| {
        let ratio = validation / answer.rms.get(signal).copied().unwrap_or(0.0).max(1e-300);
        let light = Light::of_prediction(ratio);
        let text = format!(
            "The residual of the validation data of {signal} is {} times the residual of the fitted data",
            short(ratio)
        );
        Finding { light, text }
    };
    answer.validation_rms.iter().map(of_signal).collect()
}

fn short(value: f64) -> String {
    significant(value, 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fitting::{Course, Estimate};
    use crate::machine_units::MachineUnits;

    /// A fit that leaves an RMS residual of a position that varies by 1 and has a noise of 0.001.
    fn answer(rms: f64) -> Answer {
        let measured: Vec<f64> = (0..1000).map(|k| 2f64.sqrt() * libm::sin(0.1 * f64::from(k))).collect();
        Answer {
            converged: true,
            message: "ended".to_owned(),
            estimates: vec![],
            rms: [("position", rms)].into(),
            validation_rms: [].into(),
            noise: [("position", 1e-3)].into(),
            cause: None,
            notes: vec![],
            validation_from: None,
            start: [].into(),
            courses: vec![Course { time: vec![], readings: vec![("position", measured, vec![])] }],
            units: MachineUnits::default(),
        }
    }

    #[test]
    fn a_fit_is_judged_by_its_residuals_and_not_by_the_end_of_its_search() {
        for (rms, light) in [(1e-3, Light::Green), (0.05, Light::Yellow), (0.6, Light::Red), (f64::NAN, Light::Red)] {
            assert_eq!(verdict(&answer(rms)).0, light, "{rms}");
        }
        let (_, findings) = verdict(&answer(0.6));
        assert!(findings[0].text.contains("position") && findings[0].text.contains("supply, mass and bore"));
        assert_eq!(verdict(&Answer { converged: false, ..answer(1e-3) }).0, Light::Red);
        for (validation, light) in [(1.2e-3, Light::Green), (2e-3, Light::Yellow), (4e-3, Light::Red)] {
            let judged = Answer { validation_rms: [("position", validation)].into(), ..answer(1e-3) };
            assert_eq!(verdict(&judged).0, light, "{validation}");
        }
        let parameter = ("friction.stribeck.Fc".to_owned(), "N".to_owned());
        let estimate = Estimate { parameter, value: 1.0, interval: [0.0, 2.0], undetermined: Some("it is at a bound") };
        let (light, findings) = verdict(&Answer { estimates: vec![estimate], ..answer(1e-3) });
        assert_eq!(
            (light, findings[0].text.as_str()),
            (Light::Yellow, "friction.stribeck.Fc is not identifiable: it is at a bound")
        );
    }
}
