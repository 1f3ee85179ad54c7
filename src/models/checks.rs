//! Helpers of the tests of several models.

use crate::friction::Law;
use crate::model::{Seeds, Start};
use crate::session::build;
use crate::system::{System, table};
use crate::variables::{Choice, Meaning, Variable};

/// The equations of a model with its defaults, but for the friction law.
pub fn built<E: System<U>, const U: usize>(law: Option<Law>) -> E {
    let value = |variable: &Variable| match law.filter(|_| variable.meaning == Some(Meaning::FrictionLaw)) {
        Some(law) => f64::from(law.id()),
        None => variable.start.unwrap_or_default(),
    };
    let parameters: Vec<f64> = table::<E, U>().parameters().map(value).collect();
    let start = Start { time: 0.0, parameters: &parameters, inputs: &[0.0; U], tolerance: None, seeds: Seeds::NONE };
    build(&start).expect("the defaults fit").0
}

/// Checks that events are looked for, and the time counts, under friction laws that ask for it alone, since both cost
/// time in every step; but for a model that itself has events, or whose equations depend on time.
pub fn laws_cost_what_they_ask_for<E: System<U>, const U: usize>([has_events, has_time]: [bool; 2]) {
    let laws = [
        (Law::None, [false; 2]),
        (Law::LuGre, [false; 2]),
        (Law::Stribeck, [true, false]),
        (Law::Armstrong, [true; 2]),
    ];
    for (law, [switches, remembers_times]) in laws {
        let equations: E = built(Some(law));
        let found = [equations.has_events(), equations.depends_on_time()];
        assert_eq!(found, [has_events || switches, has_time || remembers_times], "{law:?}");
    }
}

/// Checks the name of each event of a model with its defaults against the one that belongs to its place and to the name
/// of its indicator, without the group.
pub fn events_are_named<E: System<U>, const U: usize>(expected: impl Fn(usize, &str) -> &str) {
    let equations: E = built(None);
    for (place, indicator) in E::indicator_list().iter().enumerate() {
        let (_, last) = indicator.name.rsplit_once('.').expect("a name within a group");
        assert_eq!(equations.event_name(place), expected(place, last), "{}", indicator.name);
    }
}
