//! The states of hoses and vessel as variables.

use super::lines::{HOSE, Lines, STATES, VESSEL, VOLUMES, is_pressure};
use crate::pneumatics::actuator::SUPPLY;
use crate::pneumatics::hose::COLUMNS;
use crate::variables::{Variable, units};

/// Value references of the states of the hoses, and of the vessel; their rates are `RATES` further.
const REFERENCES: [u32; 3] = [300, 320, 340];
const RATES: u32 = 10;

/// Value reference of a state by its place.
const fn reference(place: usize) -> u32 {
    REFERENCES[place / HOSE] + (place % HOSE) as u32
}

/// Value references of the states that set the flow into a chamber, and of the pressure of the vessel.
pub fn feeds(chamber: usize) -> [u32; 4] {
    let first = chamber * HOSE;
    [first + VOLUMES - 2, first + VOLUMES - 1, first + HOSE - 1, VESSEL].map(reference)
}

impl Lines {
    /// The state that a variable stands for, if it is integrated, counted among those that are.
    pub fn state_at(&self, of: u32) -> Option<usize> {
        self.integrated().position(|place| reference(place) == of)
    }

    /// Number of their variables.
    pub const COMPUTED: usize = 2 * STATES;

    /// The states and their rates as variables. `direct` lists, for each chamber, on what the flow through the valve
    /// depends besides the gas at its port; `gas`, what the chamber itself offers: pressure, temperature and position.
    pub fn computed(direct: [&[u32]; 2], gas: [[u32; 3]; 2]) -> Vec<Variable> {
        let mut table: Vec<Variable> = (0..STATES).map(state).collect();
        // At the port of the valve is the first volume of a hose, or the chamber, which only the vessel sees.
        let of_valve = |side: usize| [direct[side], &[reference(side * HOSE), reference(VESSEL)]].concat();
        let of_vessel = || {
            let mut all = [of_valve(0), of_valve(1), gas[0][..2].to_vec(), gas[1][..2].to_vec()].concat();
            all.sort_unstable();
            all.dedup();
            all
        };
        table.extend((0..STATES).map(|place| {
            let depends = match place {
                VESSEL => of_vessel(),
                _ => depends_of_hose(place, &of_valve(place / HOSE), &gas[place / HOSE]),
            };
            let rate = state(place);
            let unit = if is_pressure(place) { units::PASCAL_PER_SECOND } else { units::KILOGRAM_PER_SECOND_SQUARED };
            Variable::output(reference(place) + RATES, &format!("der({})", rate.name), unit)
                .local()
                .derivative_of(reference(place))
                .depends_on(&depends)
                .text(&format!("Rate: {}", rate.description))
        }));
        table
    }
}

fn state(place: usize) -> Variable {
    let (own, hose) = (reference(place), ["hoseA", "hoseB"].get(place / HOSE).copied().unwrap_or_default());
    let (name, text, nominal) = match place {
        VESSEL => ("supply.vesselPressure".to_owned(), "Absolute pressure in the vessel of the supply".to_owned(), 1e5),
        _ if is_pressure(place) => {
            let number = place % HOSE + 1;
            let chamber = ["chamberA", "chamberB"][place / HOSE];
            let what = if number < VOLUMES {
                "counted from the valve".to_owned()
            } else {
                format!(
                    "where a restriction is between it and the chamber; otherwise it is part of the chamber: see {chamber}.pressure"
                )
            };
            let text = format!("Absolute pressure in volume {number} of the hose, {what}");
            (format!("{hose}.pressure[{number}]"), text, 1e5)
        }
        _ => {
            let number = place % HOSE + 1 - VOLUMES;
            (
                format!("{hose}.massFlow[{number}]"),
                format!("Mass flow in column {number} of the hose, towards the chamber, by its inertia"),
                1e-3,
            )
        }
    };
    let unit = if is_pressure(place) { units::PASCAL } else { units::KILOGRAM_PER_SECOND };
    let display = if is_pressure(place) { "bar" } else { "l/min(ANR)" };
    let variable = Variable::output(own, &name, unit).local().nominal(nominal).shown_in(display).depends_on(&[own]);
    let variable = if place == VESSEL { variable.starts_from(&[SUPPLY]) } else { variable };
    variable.text(&format!("{text}; 0 if there is none"))
}

/// What the rate of a state of a hose depends on.
fn depends_of_hose(place: usize, of_valve: &[u32], gas: &[u32; 3]) -> Vec<u32> {
    let (first, number) = (place / HOSE * HOSE, place % HOSE);
    let pressure = |number: usize| reference(first + number);
    // What flows in a column, and through it: its own flow and the pressures at its ends, of which the last one may be
    // that of the chamber.
    let column = |number: usize| {
        let mut depends = vec![pressure(number), pressure(number + 1), reference(first + VOLUMES + number)];
        depends.extend((number == COLUMNS - 1).then_some(gas[0]));
        depends
    };
    let mut depends = match number {
        0 => [of_valve, &column(0)].concat(),
        _ if number == VOLUMES - 1 => [&column(COLUMNS - 1), &gas[..]].concat(),
        _ if number < VOLUMES => [column(number - 1), column(number)].concat(),
        _ => column(number - VOLUMES),
    };
    depends.sort_unstable();
    depends.dedup();
    depends
}
