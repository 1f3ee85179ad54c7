//! `modelDescription.xml` and `terminalsAndIcons.xml` of a variant, made from the two files of the model.

use std::collections::{BTreeMap, BTreeSet};

use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Kind, Place, Variable};
use pneumatic_servo_ssp::xml::real;
use pneumatic_servo_variant::{Resolved, Variant};

use crate::node::Node;
use crate::{Experiment, Refused};

/// A model with the values with which it starts.
pub struct Started<'a> {
    /// The model.
    pub model: &'static Model,
    /// Parameters and inputs.
    pub resolved: &'a Resolved,
    /// States, by value reference.
    pub states: &'a BTreeMap<u32, f64>,
}

/// Elements of `ModelStructure` that list outputs, and only these.
const OUTPUTS: [&str; 2] = ["Output", "Outputs"];

impl Started<'_> {
    /// The description of the variant with a GUID.
    pub fn described(&self, source: &Node, variant: &Variant, guid: &str) -> Result<Node, Refused> {
        let mut description = source.clone();
        let token = if source.get("guid").is_some() { "guid" } else { "instantiationToken" };
        description.set(token, guid);
        description.set("modelName", &*variant.name);
        let text = description.get("description").unwrap_or_default();
        description.set("description", format!("{}: {text}", variant.name));
        for kind in ["ModelExchange", "CoSimulation"] {
            if let Some(kind) = description.child_mut(kind) {
                kind.children.retain(|child| child.name != "SourceFiles");
            }
        }
        let keeps_all =
            self.model.table().iter().filter(|it| it.role == pneumatic_servo::variables::Role::Output).count()
                == self.resolved.outputs.len();
        let kept = self.variables(&mut description, keeps_all)?;
        self.structure(&mut description, &kept);
        keep_used(&mut description, "TypeDefinitions", "declaredType");
        keep_used(&mut description, "UnitDefinitions", "unit");
        Ok(description)
    }

    /// Keeps the variables of the variant with their start values. Returns the places of those kept, which count from 1, by their
    /// places before; and for FMI 3.0 their value references.
    fn variables(&self, description: &mut Node, keeps_all: bool) -> Result<Kept, Refused> {
        let table = self.model.table();
        let section = description
            .child_mut("ModelVariables")
            .ok_or_else(|| Refused("the description has no variables".to_owned()))?;
        let (mut kept, mut variables) = (Kept::default(), Vec::new());
        for (place, mut node) in (1..).zip(std::mem::take(&mut section.children)) {
            let reference: u32 = node
                .number("valueReference")
                .ok_or_else(|| Refused(format!("variable {place} of the description has no value reference")))?;
            let Some(entry) = table.by_reference(reference) else {
                // An event indicator.
                kept.add(place, reference);
                variables.push(node);
                continue;
            };
            let causality = node.get("causality").unwrap_or("local").to_owned();
            let is_exchanged = entry.state.is_some() || entry.variable.derivative_of.is_some();
            let stays = match &*causality {
                "input" | "parameter" => self.resolved.settable.contains(&reference),
                "output" => self.resolved.outputs.contains(&reference) || is_exchanged,
                "local" => keeps_all || is_exchanged,
                _ => true,
            };
            if !stays {
                continue;
            }
            if causality == "output" && !self.resolved.outputs.contains(&reference) {
                node.set("causality", "local");
            } else if causality == "output" {
                kept.outputs.insert(reference);
            }
            self.start(&mut node, reference)?;
            kept.add(place, reference);
            variables.push(node);
        }
        // Of FMI 2.0: states by their places.
        for node in variables.iter_mut().flat_map(|node| &mut node.children) {
            if let Some(state) = node.number("derivative") {
                let place = kept.places.get(&state).ok_or_else(|| Refused(format!("there is no state {state}")))?;
                node.set("derivative", place.0.to_string());
            }
        }
        section.children = variables;
        Ok(kept)
    }

    /// Sets the start value of a variable that has one, where its type is stated.
    fn start(&self, node: &mut Node, reference: u32) -> Result<(), Refused> {
        let typed = match node.name.as_str() {
            "ScalarVariable" => {
                node.children.first_mut().ok_or_else(|| Refused("a variable has no type".to_owned()))?
            }
            _ => node,
        };
        let Some(length) = typed.get("start").map(|starts| starts.split_ascii_whitespace().count()) else {
            return Ok(());
        };
        let starts: Option<Vec<String>> = (reference..).take(length).map(|it| self.text(it)).collect();
        let starts =
            starts.ok_or_else(|| Refused(format!("the model has no value for the value reference {reference}")))?;
        typed.set("start", starts.join(" "));
        Ok(())
    }

    /// The start value of a variable as text.
    fn text(&self, reference: u32) -> Option<String> {
        let entry = self.model.table().by_reference(reference)?;
        let value = match entry.place {
            Place::Input(place) => self.resolved.inputs[place],
            Place::Parameter(place) => self.resolved.parameters[place],
            Place::Time => return None,
            Place::Computed(_) => *self.states.get(&reference)?,
        };
        Some(text(entry.variable, value))
    }

    /// Keeps unknowns that are there, and their dependencies on variables that are there: what is fixed is no unknown.
    fn structure(&self, description: &mut Node, kept: &Kept) {
        let is_fmi2 = description.get("fmiVersion") == Some("2.0");
        let Some(structure) = description.child_mut("ModelStructure") else { return };
        let places = &kept.places;
        // The number of a variable after the change.
        let renamed = |number: u32| match is_fmi2 {
            true => places.get(&number).map(|(place, _)| *place),
            false => kept.references.contains(&number).then_some(number),
        };
        let is_output = |number: u32| match is_fmi2 {
            true => places.get(&number).is_some_and(|(_, reference)| kept.outputs.contains(reference)),
            false => kept.outputs.contains(&number),
        };
        let key = if is_fmi2 { "index" } else { "valueReference" };
        let keep = |list: &str, node: &mut Node| {
            let Some(number) = node.number(key) else { return false };
            let Some(own) = renamed(number).filter(|_| !OUTPUTS.contains(&list) || is_output(number)) else {
                return false;
            };
            node.set(key, own.to_string());
            if let Some(dependencies) = node.get("dependencies") {
                let kinds = node.get("dependenciesKind").unwrap_or_default().split_ascii_whitespace();
                let numbers = dependencies.split_ascii_whitespace().map(|it| it.parse().ok().and_then(renamed));
                let (numbers, kinds): (Vec<String>, Vec<String>) = numbers
                    .zip(kinds)
                    .filter_map(|(number, kind)| Some((number?.to_string(), kind.to_owned())))
                    .unzip();
                node.set("dependencies", numbers.join(" "));
                node.set("dependenciesKind", kinds.join(" "));
            }
            true
        };
        if is_fmi2 {
            for list in &mut structure.children {
                let name = list.name.clone();
                list.children.retain_mut(|node| keep(&name, node));
            }
            structure.children.retain(|list| !list.children.is_empty());
        } else {
            structure.children.retain_mut(|node| keep(&node.name.clone(), node));
        }
    }
}

/// The variables that stay.
#[derive(Default)]
struct Kept {
    /// Their new places, and their value references, by their places before.
    places: BTreeMap<u32, (u32, u32)>,
    references: BTreeSet<u32>,
    outputs: BTreeSet<u32>,
}

impl Kept {
    fn add(&mut self, place: u32, reference: u32) {
        self.places.insert(place, (self.places.len() as u32 + 1, reference));
        self.references.insert(reference);
    }
}

/// A value as descriptions state it.
pub fn text(variable: &Variable, value: f64) -> String {
    match variable.kind {
        Kind::Real(_) => real(value),
        Kind::Integer | Kind::Enumeration(_) => format!("{value:.0}"),
        Kind::Boolean => (value != 0.0).to_string(),
    }
}

/// Keeps the definitions of a section that variables name; an empty section goes.
fn keep_used(description: &mut Node, section: &str, attribute: &str) {
    let used: BTreeSet<String> = description
        .child("ModelVariables")
        .into_iter()
        .flat_map(Node::all)
        .filter_map(|node| node.get(attribute).map(str::to_owned))
        .collect();
    if let Some(section) = description.child_mut(section) {
        section.children.retain(|node| node.get("name").is_some_and(|name| used.contains(name)));
    }
    description.children.retain(|node| node.name != section || !node.children.is_empty());
}

/// Changes the default experiment.
pub fn experiment(description: &mut Node, own: Experiment) -> Result<(), Refused> {
    let Some(default) = description.child_mut("DefaultExperiment") else { return Ok(()) };
    let stated = [
        ("startTime", own.start, f64::NEG_INFINITY),
        ("stopTime", own.stop, f64::NEG_INFINITY),
        ("stepSize", own.step, 0.0),
        ("tolerance", own.tolerance, 0.0),
    ];
    for (name, value, least) in stated {
        let Some(value) = value else { continue };
        if !(value.is_finite() && value > least) {
            let demand = if least == 0.0 { "positive and finite" } else { "finite" };
            return Err(Refused(format!("{name} = {value} of the default experiment is refused: it must be {demand}")));
        }
        default.set(name, real(value));
    }
    let [start, stop] = ["startTime", "stopTime"].map(|name| default.number(name).unwrap_or(0.0_f64));
    if stop <= start {
        return Err(Refused(format!(
            "the default experiment is refused: it stops at {stop} s and starts at {start} s"
        )));
    }
    Ok(())
}

/// The terminals of which all members are there.
pub fn terminals(mut source: Node, description: &Node) -> Node {
    let variables = description.child("ModelVariables").into_iter().flat_map(|section| &section.children);
    let ports = variables.filter(|node| matches!(node.get("causality"), Some("input" | "output")));
    let names: BTreeSet<&str> = ports.filter_map(|node| node.get("name")).collect();
    if let Some(section) = source.child_mut("Terminals") {
        section.children.retain(|terminal| {
            terminal.children.iter().filter_map(|member| member.get("variableName")).all(|name| names.contains(name))
        });
    }
    source.children.retain(|node| node.name != "Terminals" || !node.children.is_empty());
    source
}
