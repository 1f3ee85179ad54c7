//! Options of the use of the data: their values, and what interfaces say of them.

use crate::refused::Refused;

/// An option as interfaces offer it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offered {
    /// Its name, as of an argument of the Python package.
    pub name: &'static str,
    /// What it does, and what counts where nobody gives it.
    pub about: &'static str,
    /// Its values.
    pub range: Range,
    /// Its value in SI units where nobody gives one; nothing where the data, or the experiment, choose.
    pub usual: Option<f64>,
}

/// Values that an option may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Numbers that are not negative, with the unit in which people write them.
    Numbers {
        /// The unit.
        unit: &'static str,
        /// Whether 0 is none of them.
        is_positive: bool,
    },
    /// Items by their names.
    Items(&'static [&'static str]),
}

/// All options.
pub const OPTIONS: [Offered; 6] = [
    Offered {
        name: "width",
        about: "Width of the parabolas that give velocities",
        range: Range::Numbers { unit: "ms", is_positive: true },
        usual: Some(0.04),
    },
    Offered {
        name: "smoothing",
        about: "Whether measured forces and pressures that move a mass are smoothed over the width; automatic: the one \
                with the smaller residual, which a note states",
        range: Range::Items(&["on", "off"]),
        usual: None,
    },
    Offered {
        name: "rated",
        about: "Normal force at which the load factor is 1",
        range: Range::Numbers { unit: "N", is_positive: true },
        usual: Some(1.0),
    },
    Offered {
        name: "play",
        about: "Hides the jitter of a position at rest; automatic: three times its noise",
        range: Range::Numbers { unit: "um", is_positive: false },
        usual: None,
    },
    Offered {
        name: "segment",
        about: "Length after which a simulation starts anew from measured values; automatic: about 0.15 s where measured \
                forces move a mass, never otherwise",
        range: Range::Numbers { unit: "s", is_positive: true },
        usual: None,
    },
    Offered {
        name: "inputs",
        about: "Course of measured inputs between samples: held, on straight lines, or on a smooth curve; automatic: held, \
                but of forces what leaves least",
        range: Range::Items(&["hold", "lines", "smooth"]),
        usual: None,
    },
];

/// Options of the use of the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Normal force in N at which the load factor is 1.
    pub rated: f64,
    /// Width in s of the parabolas that give velocities.
    pub width: f64,
    /// Play in m that hides the jitter of a position at rest; by default three times its noise.
    pub play: Option<f64>,
    /// Length in s of the segments that a record is cut into; by default the length that the experiment has, if any.
    pub length: Option<f64>,
    /// Course of measured inputs between samples; nothing where the data choose.
    pub inputs: Option<Inputs>,
    /// Whether measured forces and pressures that move a mass are smoothed over the width; nothing where the data choose.
    pub smoothing: Option<bool>,
}

impl Default for Options {
    fn default() -> Self {
        Self { rated: 1.0, width: 0.04, play: None, length: None, inputs: None, smoothing: None }
    }
}

impl Options {
    /// Course of measured inputs, held as long as the data have not chosen.
    pub fn inputs(&self) -> Inputs {
        self.inputs.unwrap_or(Inputs::Held)
    }

    /// Whether measured forces are smoothed, as they are as long as the data have not chosen.
    pub fn smooths(&self) -> bool {
        self.smoothing.unwrap_or(true)
    }
}

/// Course of measured inputs between samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inputs {
    /// Each is held until the next sample.
    Held,
    /// They run on straight lines.
    Lines,
    /// They run on a smooth curve.
    Smooth,
}

impl std::str::FromStr for Inputs {
    type Err = Refused;

    fn from_str(name: &str) -> Result<Self, Refused> {
        match name {
            "held" | "hold" => Ok(Self::Held),
            "lines" => Ok(Self::Lines),
            "smooth" => Ok(Self::Smooth),
            _ => Err(Refused(format!("inputs = {name} is refused: it must be hold, lines or smooth"))),
        }
    }
}

impl Inputs {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Lines => "lines",
            Self::Smooth => "smooth",
        }
    }

    /// Whether they change within a step.
    pub fn have_lines(self) -> bool {
        self != Self::Held
    }

    /// Ends of the straight lines that take the place of a course, of its samples.
    ///
    /// Lines in place of a smooth curve have the mean over each step that the cubic through the four samples around has.
    pub fn ends(self, mut samples: Vec<f64>) -> Vec<f64> {
        if self == Self::Smooth {
            let bend: Vec<f64> = samples.windows(3).map(|own| (own[0] - 2.0 * own[1] + own[2]) / 12.0).collect();
            samples.iter_mut().skip(1).zip(bend).for_each(|(sample, bend)| *sample -= bend);
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_those_of_options() {
        let Options { rated, width, play, length, inputs, smoothing } = Options::default();
        let of = |name: &str| OPTIONS.iter().find(|option| option.name == name).expect("an option").usual;
        assert_eq!([of("rated"), of("width"), of("play"), of("segment")], [Some(rated), Some(width), play, length]);
        assert_eq!((inputs, smoothing), (None, None));
    }

    #[test]
    fn inputs_have_the_names_that_are_offered() {
        let Range::Items(items) = OPTIONS[5].range else { panic!("inputs have names") };
        let courses = items.iter().map(|name| name.parse::<Inputs>().map(Inputs::name));
        assert_eq!(courses.collect::<Vec<_>>(), [Ok("held"), Ok("lines"), Ok("smooth")]);
        let refused = "cubic".parse::<Inputs>().expect_err("a refusal").0;
        assert_eq!(refused, "inputs = cubic is refused: it must be hold, lines or smooth");
    }
}
