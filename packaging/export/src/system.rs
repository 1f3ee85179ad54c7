//! A configured system: an SSP whose FMUs start with the values of their machines.

use std::collections::BTreeMap;

use pneumatic_servo::model::Model;
use pneumatic_servo_variant::Given;

use crate::archive::Archive;
use crate::node::Node;
use crate::{Machine, Refused, check_name, export};

const SYSTEM: &str = "SystemStructure.ssd";
/// The same system for hosts that know components alone.
const COMPONENTS: &str = "Components.ssd";

/// The SSP of a system with values by name, `component.variable`, made from a released one.
///
/// Values that are not given are those of the set of parameters that the source is bound to. The FMUs keep all their variables,
/// since the connections are to stay; the sets of parameters go.
///
/// # Errors
/// [`Refused`] when the file is no SSP of FMUs of these models, and for names and values as those of an FMU are refused.
pub fn export_system(
    source: &[u8],
    models: &[&'static Model],
    name: &str,
    values: &BTreeMap<String, Given>,
) -> Result<Vec<u8>, Refused> {
    check_name(name)?;
    let archive = Archive::read(source)?;
    let mut system = Node::read(&archive.text(SYSTEM)?, SYSTEM)?;
    let mut components = BTreeMap::new();
    for node in system.all() {
        if node.name == "ssd:Component"
            && let (Some(name), Some(source)) = (node.get("name"), node.get("source"))
        {
            components.insert(name.to_owned(), source.to_owned());
        }
    }
    let mut all = BTreeMap::new();
    for path in bound(&system) {
        all.extend(read_ssv(&archive.text(&path)?, &path)?);
    }
    // Of connectors of the system: their start values are those of the components.
    all.retain(|name, _| part_of(name, &components).is_some());
    for (name, value) in values {
        if part_of(name, &components).is_none() {
            let known: Vec<_> = components.keys().map(|component| format!("{component}.")).collect();
            return Err(Refused(format!("{name} is of no component; names begin with {}", known.join(" or "))));
        }
        all.insert(name.clone(), value.clone());
    }

    let mut changed = BTreeMap::new();
    for (component, path) in &components {
        if !archive.has(path) {
            return Err(Refused(format!("{component}: there is no {path} in the system")));
        }
        let fmu = archive.bytes(path)?;
        let own = all.iter().filter_map(|(name, value)| {
            let (part, variable) = part_of(name, &components)?;
            (part == component).then(|| (variable.to_owned(), value.clone()))
        });
        let machine = Machine { name: format!("{name} {component}"), values: own.collect(), ..Machine::default() };
        let exported =
            export(&fmu, models, &machine).map_err(|Refused(reason)| Refused(format!("{component}: {reason}")))?;
        changed.insert(path.clone(), exported.fmu);
    }
    system.set("name", name);
    unbind(&mut system);
    changed.insert(SYSTEM.to_owned(), system.text().into_bytes());
    if archive.has(COMPONENTS) {
        let mut parts = Node::read(&archive.text(COMPONENTS)?, COMPONENTS)?;
        parts.set("name", format!("{name} components"));
        unbind(&mut parts);
        changed.insert(COMPONENTS.to_owned(), parts.text().into_bytes());
    }
    let goes = |path: &str| path.ends_with(".ssv") || path.ends_with(".ssd") && path != SYSTEM && path != COMPONENTS;
    archive.rewritten(changed, goes)
}

/// Component and variable of a name.
fn part_of<'a>(name: &'a str, components: &BTreeMap<String, String>) -> Option<(&'a str, &'a str)> {
    name.split_once('.').filter(|(component, _)| components.contains_key(*component))
}

/// The files that parameters are bound to.
fn bound(system: &Node) -> Vec<String> {
    let bindings = system.all().into_iter().filter(|node| node.name == "ssd:ParameterBinding");
    bindings.filter_map(|node| node.get("source").map(str::to_owned)).collect()
}

fn unbind(node: &mut Node) {
    node.children.retain(|child| child.name != "ssd:ParameterBindings");
    node.children.iter_mut().for_each(unbind);
}

/// The values of an SSV, as files of this library state them: in the units of the variables.
///
/// # Errors
/// [`Refused`] for what is no SSV, and for a parameter without value or a name twice.
pub fn read_ssv(text: &str, file: &str) -> Result<BTreeMap<String, Given>, Refused> {
    let set = Node::read(text, file)?;
    if set.name != "ssv:ParameterSet" {
        return Err(Refused(format!("{file} is no SSV, since it begins with {}", set.name)));
    }
    let mut values = BTreeMap::new();
    for parameter in set.all().into_iter().filter(|node| node.name == "ssv:Parameter") {
        let name = parameter.get("name").unwrap_or_default();
        let value = parameter.children.first().and_then(|typed| typed.get("value"));
        let value = value.ok_or_else(|| Refused(format!("{file}: {name} has no value")))?;
        if values.insert(name.to_owned(), Given::read(value)).is_some() {
            return Err(Refused(format!("{file}: {name} is there twice")));
        }
    }
    Ok(values)
}

/// Whether an archive is a system, not an FMU.
///
/// # Errors
/// [`Refused`] when it is no archive.
pub fn is_system(source: &[u8]) -> Result<bool, Refused> {
    Ok(Archive::read(source)?.has(SYSTEM))
}
