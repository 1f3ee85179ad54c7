//! `terminalsAndIcons.xml` of FMI 3.0: variables that belong together, to be connected by one line, and the icon.

use std::io;

use anyhow::Result;
use pneumatic_servo::model::Model;
use pneumatic_servo_ssp::xml::{Element, Xml, document};

/// Variables that belong together.
struct Terminal {
    name: &'static str,
    description: &'static str,
    members: &'static [Member],
}

/// Name within the terminal, name of the variable, and what kind of quantity it is: a potential or flow of a physical
/// connection, or a signal.
type Member = (&'static str, &'static str, &'static str);

/// The terminals of any model that has all variables of them.
const TERMINALS: [Terminal; 3] = [
    Terminal {
        name: "valve",
        description: "Electric and pneumatic connection of the valve",
        members: &[("voltage", "valveVoltage", "signal"), ("supply", "supplyPressure", "signal")],
    },
    Terminal {
        name: "carriage",
        description: "Mechanical flange of the carriage: where it is, and the force on it",
        members: &[
            ("position", "position", "signal"),
            ("velocity", "velocity", "signal"),
            ("force", "externalForce", "inflow"),
        ],
    },
    Terminal {
        name: "flange",
        description: "Mechanical flange that a multibody tool moves (motion = Imposed), and the force of the cylinder on it",
        members: &[
            ("position", "imposedPosition", "signal"),
            ("velocity", "imposedVelocity", "signal"),
            ("force", "rodForce", "outflow"),
        ],
    },
];

/// The file of a model, with or without an icon.
///
/// # Errors
/// When the XML cannot be written.
pub fn xml(model: &Model, has_icon: bool) -> Result<String> {
    Ok(document(|xml| {
        Element::new("fmiTerminalsAndIcons").with("fmiVersion", "3.0").contain(xml, |xml| {
            if has_icon {
                graphics(xml)?;
            }
            let has = |variable: &str| model.table().find(variable).is_some();
            let terminals = TERMINALS.iter().filter(|it| it.members.iter().all(|(_, variable, _)| has(variable)));
            let terminals: Vec<_> = terminals.collect();
            if terminals.is_empty() {
                return Ok(());
            }
            Element::new("Terminals").contain(xml, |xml| terminals.iter().try_for_each(|it| write_terminal(xml, it)))
        })
    })?)
}

/// The icon fills a square of 20 mm.
fn graphics(xml: &mut Xml) -> io::Result<()> {
    let square = |name| ["x1", "y1"].into_iter().fold(Element::new(name), |it, corner| it.with(corner, "-100"));
    let square = |name| ["x2", "y2"].into_iter().fold(square(name), |it, corner| it.with(corner, "100"));
    Element::new("GraphicalRepresentation").contain(xml, |xml| {
        square("CoordinateSystem").with("suggestedScalingFactorTo_mm", "0.1").write(xml)?;
        square("Icon").write(xml)
    })
}

fn write_terminal(xml: &mut Xml, terminal: &Terminal) -> io::Result<()> {
    Element::new("Terminal")
        .with("name", terminal.name)
        .with("matchingRule", "plug")
        .with("description", terminal.description)
        .contain(xml, |xml| {
            terminal.members.iter().try_for_each(|(name, variable, kind)| {
                Element::new("TerminalMemberVariable")
                    .with("variableName", variable)
                    .with("memberName", name)
                    .with("variableKind", kind)
                    .write(xml)
            })
        })
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models;

    use super::*;

    #[test]
    fn the_cylinder_has_all_terminals_and_the_bench_none() -> Result<()> {
        let of =
            |name: &str| models::ALL.iter().find(|model| model.name == name).map(|it| xml(it, true)).expect("a model");
        let cylinder = of("PneumaticServoCylinder")?;
        for Terminal { name, members, .. } in &TERMINALS {
            assert!(cylinder.contains(&format!("<Terminal name=\"{name}\"")), "{cylinder}");
            assert!(members.iter().all(|(_, variable, _)| cylinder.contains(&format!("\"{variable}\""))), "{cylinder}");
        }
        assert!(!of("PositionController")?.contains("<Terminals>"));
        Ok(())
    }

    /// An icon is told of where there is one: it fills a square of 200 units of 0.1 mm.
    #[test]
    fn icon_fills_its_square_where_there_is_one() -> Result<()> {
        for model in models::ALL {
            assert!(!xml(model, false)?.contains("GraphicalRepresentation"));
            let with = xml(model, true)?;
            assert!(with.contains("suggestedScalingFactorTo_mm=\"0.1\""), "{with}");
            for (edge, value) in [("x1", -100), ("y1", -100), ("x2", 100), ("y2", 100)] {
                assert_eq!(
                    with.matches(&format!(" {edge}=\"{value}\"")).count(),
                    2,
                    "{edge} of icon and system in {with}"
                );
            }
        }
        Ok(())
    }
}
