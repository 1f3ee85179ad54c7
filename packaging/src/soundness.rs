//! Whether the tables of a model hold together: looked at before anything of it is built or written.

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};

use anyhow::{Result, ensure};
use pneumatic_servo::conformance::Slopes;
use pneumatic_servo::model::{Model, Setup, Start};
use pneumatic_servo::variables::{Kind, Table, Variable};

/// Refuses models whose tables do not hold together, each by its name with all that is wrong with it.
///
/// # Errors
/// When there is anything wrong.
pub fn check(models: &[Model]) -> Result<()> {
    let wrong: Vec<String> =
        models.iter().flat_map(|model| problems(model).into_iter().map(|it| format!("{}: {it}", model.name))).collect();
    ensure!(wrong.is_empty(), "the models cannot be packed:\n  {}", wrong.join("\n  "));
    Ok(())
}

/// The derivatives of models that no difference confirms, in words: hosts would take for exact what equations have lost. Items
/// of a crate's own (ids from 1000 on) are looked at one by one.
pub fn wrong_slopes(models: &'static [Model]) -> Vec<String> {
    let mut wrong = Vec::new();
    for setup in models.iter().flat_map(settings) {
        let mut found = Slopes::default();
        let failed = quietly(|| found.run(&setup, &|_| true)).err();
        wrong.extend(found.wrong.into_iter().chain(failed));
    }
    wrong
}

/// The defaults of a model, and those with each item of its enumerations that is a crate's own.
fn settings(model: &'static Model) -> Vec<Setup> {
    let own = |variable: &'static Variable| match variable.kind {
        Kind::Enumeration(of) => of.items.iter().filter(|(id, ..)| *id >= 1000).map(|(_, item, _)| *item).collect(),
        _ => Vec::new(),
    };
    let chosen = |(name, item): (&str, &str)| Setup::of(model).set(name, item).ok();
    let choices = (model.variables)().parameters().flat_map(|it| own(it).into_iter().map(|item| (&*it.name, item)));
    std::iter::once(Setup::of(model)).chain(choices.filter_map(chosen)).collect()
}

/// What is wrong with a model.
fn problems(model: &Model) -> Vec<String> {
    let table = match quietly(|| (model.variables)()) {
        Ok(table) => table,
        Err(reason) => return vec![reason],
    };
    let mut problems = Vec::new();
    table.iter().for_each(|variable| of_variable(variable, &mut problems));
    // Names or value references that come twice or lead nowhere, among others.
    if let Some(problem) = table.problem() {
        problems.push(problem.reason.clone());
        return problems;
    }
    if model.description.is_empty() {
        problems.push("it has no description".to_owned());
    }
    of_enumerations(table, &mut problems);
    of_events(model, table, &mut problems);
    problems.extend(model.experiment.problems(table));
    // What is unsound may not even start.
    if problems.is_empty() {
        of_start(model, table, &mut problems);
    }
    problems
}

/// What makes a table, or why it cannot be made.
fn quietly<T>(make: impl FnOnce() -> T) -> Result<T, String> {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| ()));
    let made = catch_unwind(AssertUnwindSafe(make));
    std::panic::set_hook(hook);
    made.map_err(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
        text.unwrap_or_else(|| "its table of variables cannot be made".to_owned())
    })
}

fn of_variable(variable: &Variable, problems: &mut Vec<String>) {
    let Variable { name, min, max, start, nominal, .. } = variable;
    if name.is_empty() {
        problems.push(format!("the variable with value reference {} has no name", variable.reference));
    }
    if let (Some(min), Some(max)) = (min, max)
        && min > max
    {
        problems.push(format!("the range of {name}, {min} to {max}, is empty"));
    }
    if let Some(start) = start
        && let Err(refusal) = variable.check(*start)
    {
        problems.push(format!("the start value of {name} is not legal: {refusal}"));
    }
    if nominal.is_some_and(|nominal| !is_magnitude(nominal)) {
        problems.push(format!("the nominal of {name} is no positive number"));
    }
}

/// Whether a number can say how large something is.
fn is_magnitude(number: f64) -> bool {
    number.is_finite() && number > 0.0
}

/// It starts with its defaults, and knows how large each of its states is.
fn of_start(model: &Model, table: &Table, problems: &mut Vec<String>) {
    let starts = |variable: &Variable| variable.start.unwrap_or_default();
    let parameters: Vec<f64> = table.parameters().map(starts).collect();
    let inputs: Vec<f64> = table.inputs().map(starts).collect();
    let start = Start { time: 0.0, parameters: &parameters, inputs: &inputs, tolerance: None };
    let run = match quietly(|| (model.start)(&start)) {
        Ok(Ok(run)) => run,
        Ok(Err(refusal)) => return problems.push(format!("it does not start with its defaults: {refusal}")),
        Err(reason) => return problems.push(format!("it does not start with its defaults: {reason}")),
    };
    let mut scales = vec![1.0; table.number_of_states()];
    if let Some(exchange) = run.exchange((model.indicators)()) {
        exchange.nominals(&mut scales);
    }
    for (reference, scale) in table.states().zip(scales) {
        let name = table.by_reference(reference).map_or("", |entry| &entry.variable.name);
        if !is_magnitude(scale) {
            problems.push(format!("the state {name} has the scale {scale}, which is no positive number"));
        }
    }
}

fn of_enumerations(table: &Table, problems: &mut Vec<String>) {
    for variable in table {
        let Kind::Enumeration(of) = variable.kind else { continue };
        let (mut ids, mut names) = (BTreeSet::new(), BTreeSet::new());
        for (id, name, _) in of.items {
            if !ids.insert(id) {
                problems.push(format!("the id {id} of {} in {} is taken", name, of.name));
            }
            if !names.insert(name) {
                problems.push(format!("{} has the item {name} twice", of.name));
            }
        }
    }
}

fn of_events(model: &Model, table: &Table, problems: &mut Vec<String>) {
    let mut names = BTreeSet::new();
    let events = (model.indicators)();
    for (number, event) in (1..).zip(&events) {
        if event.name.is_empty() {
            problems.push(format!("event {number} of {} has no name", events.len()));
        } else if !names.insert(&event.name) || table.find(&event.name).is_some() {
            problems.push(format!("the name of the event {} is taken", event.name));
        }
        if event.text.is_empty() {
            problems.push(format!("the event {} does not say what happens", event.name));
        }
        if !is_magnitude(event.nominal) {
            problems.push(format!("the nominal of the event {} is no positive number", event.name));
        }
    }
    for indicator in model.indicator_variables() {
        if let Some(entry) = table.by_reference(indicator.reference) {
            let name = &entry.variable.name;
            problems.push(format!("{name} has the value reference {}, which is an event's", indicator.reference));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use pneumatic_servo::hybrid::Indicator;
    use pneumatic_servo::model::{Experiment, Panel};
    use pneumatic_servo::models;
    use pneumatic_servo::variables::{Enumeration, ParameterError, Role, units};

    use super::*;

    #[test]
    fn the_models_of_the_project_hold_together() {
        check(models::ALL).expect("nothing wrong");
    }

    fn refusals(model: &Model) -> String {
        check(&[Model { ..*model }]).err().map(|error| error.to_string()).unwrap_or_default()
    }

    fn table(change: impl FnOnce(&mut Vec<Variable>)) -> Table {
        let mut variables = vec![
            Variable::time(),
            Variable::input(1, "input", units::METRE, 0.0),
            Variable::output(2, "state", units::METRE).nominal(1.0),
            Variable::output(3, "der(state)", units::METRE_PER_SECOND).local().derivative_of(2).depends_on(&[1]),
            Variable::parameter(4, "lag", units::SECOND, 1.0).range(0.1, 10.0),
        ];
        change(&mut variables);
        Table::new(variables)
    }

    const MODEL: Model = Model {
        name: "Sound",
        description: "A model with nothing wrong",
        variables: || {
            static TABLE: LazyLock<Table> = LazyLock::new(|| table(|_| ()));
            &TABLE
        },
        indicators: Vec::new,
        start: |_| Err(ParameterError::new("lag", 1.0, "it must fit the gap")),
        experiment: Experiment {
            stop_time: 1.0,
            step_size: 0.1,
            signals: &[],
            panels: &[Panel { label: "state", curves: &["state"] }],
        },
    };

    /// The tables of the model are sound; then it is started.
    #[test]
    fn a_model_that_does_not_start_is_refused_with_the_reason() {
        let refused = "the models cannot be packed:\n  Sound: it does not start with its defaults: ";
        assert!(
            refusals(&MODEL).starts_with(refused)
                && refusals(&MODEL).contains("lag = 1 is refused: it must fit the gap"),
            "{}",
            refusals(&MODEL)
        );
        let panics = Model { start: |_| panic!("a slip"), ..MODEL };
        assert_eq!(refusals(&panics), format!("{refused}a slip"));
    }

    macro_rules! with_table {
        ($change:expr) => {
            Model {
                variables: || {
                    static TABLE: LazyLock<Table> = LazyLock::new(|| table($change));
                    &TABLE
                },
                ..MODEL
            }
        };
    }

    #[test]
    fn what_is_wrong_with_variables_is_named() {
        let twice = with_table!(|it| it.push(Variable::parameter(4, "gap", units::METRE, 1.0)));
        let name = with_table!(|it| it.push(Variable::parameter(5, "lag", units::METRE, 1.0)));
        let lost = with_table!(|it| it.push(Variable::output(5, "sum", units::METRE).depends_on(&[77])));
        let scale = with_table!(|it| it[2].nominal = Some(0.0));
        let start = with_table!(|it| it[4].start = Some(100.0));
        let range = with_table!(|it| it[4] = it[4].clone().range(2.0, 0.5));
        for (model, expected) in [
            (twice, "Sound: the value reference 4 of gap is used twice"),
            (name, "Sound: two variables have the name lag"),
            (lost, "no variable has the value reference 77"),
            (scale, "the nominal of state is no positive number"),
            (start, "the start value of lag is not legal: lag = 100 is refused"),
            (range, "the range of lag, 2 to 0.5, is empty"),
        ] {
            assert!(refusals(&model).contains(expected), "{expected}: {}", refusals(&model));
        }
    }

    #[test]
    fn a_range_may_be_a_single_value() {
        let single = with_table!(|it| it[4] = it[4].clone().range(1.0, 1.0));
        assert!(refusals(&single).contains("does not start"), "{}", refusals(&single));
    }

    #[test]
    fn magnitudes_are_positive_numbers() {
        for (number, expected) in
            [(1e-300, true), (1.0, true), (0.0, false), (-1.0, false), (f64::INFINITY, false), (f64::NAN, false)]
        {
            assert_eq!(is_magnitude(number), expected, "{number}");
        }
    }

    /// A choice among the items of an enumeration.
    fn law(items: &'static Enumeration) -> Variable {
        Variable {
            reference: 9,
            role: Role::Fixed,
            kind: Kind::Enumeration(items),
            start: Some(1.0),
            ..Variable::output(9, "law", units::ONE)
        }
    }

    #[test]
    fn ids_that_are_taken_are_named() {
        static LAWS: Enumeration = Enumeration {
            name: "Laws",
            description: "",
            items: &[(1, "None", ""), (1000, "One", ""), (1000, "Two", ""), (1001, "One", "")],
        };
        let model = with_table!(|it| it.push(law(&LAWS)));
        let text = refusals(&model);
        assert!(text.contains("the id 1000 of Two in Laws is taken"), "{text}");
        assert!(text.contains("Laws has the item One twice"), "{text}");
    }

    #[test]
    fn what_is_wrong_with_events_and_the_experiment_is_named() {
        fn event(name: &str, nominal: f64, text: &'static str) -> Indicator {
            Indicator { name: name.to_owned(), nominal, text }
        }
        let events =
            || vec![event("", 1.0, "a"), event("lag", 1.0, "b"), event("stop", 0.0, ""), event("stop", 1.0, "c")];
        let panels = &[Panel { label: "height", curves: &["height"] }];
        let experiment = Experiment { stop_time: 0.0, panels, ..MODEL.experiment };
        let text = refusals(&Model { indicators: events, experiment, description: "", ..MODEL });
        for expected in [
            "it has no description",
            "event 1 of 4 has no name",
            "the name of the event lag is taken",
            "the event stop does not say what happens",
            "the nominal of the event stop is no positive number",
            "the name of the event stop is taken",
            "stop time and step size",
            "shows height, which is no variable",
        ] {
            assert!(text.contains(expected), "{expected}: {text}");
        }
        let nothing = Experiment { panels: &[], ..MODEL.experiment };
        assert!(refusals(&Model { experiment: nothing, ..MODEL }).contains("shows nothing"));
    }

    mod lost {
        use pneumatic_servo::prelude::*;

        parameters! {
            /// The value of the parameter alone has no slope.
            Lost {
                share: Tunable = Variable::parameter(0, "b", units::ONE, 0.25).range(0.0, 1.0).text("Share");
            }
        }

        impl VelocityLaw for Lost {
            fn force<S: Scalar>(&self, v: S, level: S) -> S {
                v * level * (1.0 - self.share.value)
            }
        }

        laws! {
            /// A law without any beside it.
            pub mod catalogue {
                1000 Lost "lost" OfVelocity<Lost>, "Loses the slope by a parameter";
            }
        }

        pub static MODELS: &[Model] = &[pneumatic_servo::models::friction_bench::model::<catalogue::Friction>()];
    }

    #[test]
    fn lost_slopes_are_told() {
        let wrong = wrong_slopes(lost::MODELS);
        assert!(wrong.iter().any(|it| it.contains("d frictionForce / d friction.lost.b = 0")), "{wrong:?}");
    }

    #[test]
    fn slopes_of_the_bench_are_differences() {
        static BENCH: &[Model] = &[pneumatic_servo::models::friction_bench::MODEL];
        assert_eq!(wrong_slopes(BENCH), Vec::<String>::new());
    }

    /// The defaults, and a run with each item that somebody else has added.
    #[test]
    fn models_are_tried_with_each_item_that_is_not_of_the_project() {
        static LAWS: Enumeration = Enumeration {
            name: "Laws",
            description: "",
            items: &[(1, "None", ""), (999, "Last", ""), (1000, "One", ""), (1001, "Two", "")],
        };
        static MODEL_WITH_LAWS: Model = with_table!(|it| it.push(law(&LAWS)));
        let laws: Vec<_> = settings(&MODEL_WITH_LAWS).iter().map(|setup| setup.get("law").expect("a law")).collect();
        assert_eq!(laws, [1.0, 1000.0, 1001.0]);
    }
}
