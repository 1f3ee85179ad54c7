//! The friction laws with their parameters, and the experiment: the default one of the model.

use pneumatic_servo::friction::LAWS;
use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;
use pneumatic_servo::variables::{Role, Variable};

/// Communication step in s of the comparison.
pub const STEP: f64 = MODEL.experiment.step_size;
/// Duration in s of the comparison.
pub const DURATION: f64 = MODEL.experiment.stop_time;

/// The valve voltage set at a time and held until the next communication step.
pub fn voltage(time: f64) -> f64 {
    MODEL.experiment.signals[0].course.at(time)
}

/// A cylinder with a friction law and some parameters changed.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in reports.
    pub name: String,
    /// All parameters in the order of the table.
    pub parameters: Vec<f64>,
}

/// The variables of the model of one kind.
pub fn variables(of: impl Fn(&Variable) -> bool) -> Vec<&'static Variable> {
    MODEL.table().iter().filter(|variable| of(variable)).collect()
}

/// The variable of that name.
///
/// # Panics
/// When there is none.
pub fn variable(name: &str) -> &'static Variable {
    variables(|variable| variable.name == name).first().unwrap_or_else(|| panic!("{name} is no variable"))
}

/// The start values of the inputs that a cylinder without options reads.
///
/// # Panics
/// When one of them has none.
pub fn inputs() -> [f64; 3] {
    let inputs = variables(|it| it.role == Role::Input);
    std::array::from_fn(|place| inputs[place].start.expect("a start value"))
}

impl Case {
    /// A friction law with all defaults, if the library has it.
    pub fn of(law: &str) -> Option<Self> {
        let (id, ..) = LAWS.items.iter().find(|(_, name, _)| *name == law)?;
        let parameters = variables(Variable::is_parameter).iter().filter_map(|it| it.start).collect();
        Some(Self { name: law.to_owned(), parameters }.with("friction.law", f64::from(*id)))
    }

    /// With a parameter changed.
    ///
    /// # Panics
    /// When the model has no such parameter.
    pub fn with(mut self, name: &str, value: f64) -> Self {
        let place = variables(Variable::is_parameter).iter().position(|it| it.name == name);
        self.parameters[place.unwrap_or_else(|| panic!("{name} is no parameter"))] = value;
        self
    }

    /// A parameter.
    ///
    /// # Panics
    /// When the model has no such parameter.
    pub fn parameter(&self, name: &str) -> f64 {
        let place = variables(Variable::is_parameter).iter().position(|it| it.name == name);
        self.parameters[place.unwrap_or_else(|| panic!("{name} is no parameter"))]
    }

    fn named(self, name: &str) -> Self {
        Self { name: name.to_owned(), ..self }
    }
}

/// LuGre with a bristle as stiff as Dahl's.
fn stiff_lugre() -> Option<Case> {
    let stiff = Case::of("LuGre")?.with("friction.lugre.sigma0", 8e6).with("friction.lugre.sigma1", 500.0);
    let stiff = stiff.with("friction.lugre.vd", 1e3);
    Some(stiff.named("LuGre, stiff"))
}

/// The cases whose cost is compared at equal error.
pub fn compared() -> Vec<Case> {
    let laws = ["Stribeck", "Polito", "Dahl", "LuGre", "ElastoPlastic"];
    let mut cases: Vec<Case> = laws.into_iter().filter_map(Case::of).collect();
    cases.extend(stiff_lugre());
    cases
}

/// Every friction law of the library with its defaults, and the stiff bristle.
pub fn all() -> Vec<Case> {
    LAWS.items.iter().filter_map(|(_, law, _)| Case::of(law)).chain(stiff_lugre()).collect()
}
