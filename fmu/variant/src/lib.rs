//! A variant of a model: values with which its instances start, and the variables that its description keeps.
//!
//! An exported FMU has the file [`FILE`] in its `resources`; its library reads the values from there. The GUID of its
//! description is made from the GUID of the model and the bytes of the file ([`guid`]), so that a damaged file, or one of
//! another FMU, is noticed.
//!
//! ```text
//! pneumatic-servo variant 1
//! model = PneumaticServoCylinder
//! name = Axis7
//! inputs = valveVoltage, supplyPressure
//! outputs = position
//! parameters = mass.carriage
//!
//! cylinder.bore = 0.032
//! friction.law = LuGre
//! ```

pub mod fnv;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Write};

use pneumatic_servo::variables::{Kind, Place, Role, Table, Value, Variable, array_name, find};

/// The name of the file in `resources`.
pub const FILE: &str = "variant.txt";

/// More bytes than a file may have.
pub const LIMIT: usize = 1 << 20;

const HEADER: &str = "pneumatic-servo variant 1";

/// A variant, by the names of its variables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variant {
    /// Name of the model.
    pub model: String,
    /// Name of the variant.
    pub name: String,
    /// Inputs that stay; the others keep their values.
    pub inputs: Vec<String>,
    /// Outputs that stay.
    pub outputs: Vec<String>,
    /// Parameters that stay settable; the others keep their values.
    pub parameters: Vec<String>,
    /// Values of parameters, and start values of inputs, in place of the defaults.
    pub values: BTreeMap<String, Given>,
}

/// A value as the file states it.
#[derive(Clone, Debug, PartialEq)]
pub enum Given {
    /// A number, in the SI unit of the variable.
    Number(f64),
    /// True or false.
    Flag(bool),
    /// The name of an item of an enumeration.
    Item(String),
}

impl Given {
    /// Reads a value as files state it.
    pub fn read(text: &str) -> Self {
        match (text.parse(), text.parse()) {
            (Ok(flag), _) => Self::Flag(flag),
            (_, Ok(number)) => Self::Number(number),
            _ => Self::Item(text.to_owned()),
        }
    }

    /// The value as a model takes it.
    pub fn value(&self) -> Value<'_> {
        match self {
            Self::Number(number) => Value::Number(*number),
            Self::Flag(flag) => Value::Flag(*flag),
            Self::Item(item) => Value::Item(item),
        }
    }
}

impl fmt::Display for Given {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // The shortest text that gives the same bits.
            Self::Number(number) => write!(f, "{number:?}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Item(item) => f.write_str(item),
        }
    }
}

/// A variant, by the places of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// The values of all parameters.
    pub parameters: Vec<f64>,
    /// The start values of all inputs.
    pub inputs: Vec<f64>,
    /// Value references of inputs and parameters that may be set.
    pub settable: BTreeSet<u32>,
    /// Value references of outputs that stay.
    pub outputs: BTreeSet<u32>,
}

/// The GUID of a variant, made from the GUID of its model and the bytes of its file.
pub fn guid(model: &str, file: &[u8]) -> String {
    let mut hash = fnv::Hash::default();
    hash.add(model.as_bytes());
    hash.add(file);
    let digits = hash.digits();
    let [a, b, c, d, e] = [&digits[..8], &digits[8..12], &digits[12..16], &digits[16..20], &digits[20..]];
    format!("{{{a}-{b}-{c}-{d}-{e}}}")
}

impl Variant {
    /// The file.
    pub fn text(&self) -> String {
        let Self { model, name, inputs, outputs, parameters, values } = self;
        let [inputs, outputs, parameters] = [inputs, outputs, parameters].map(|names| names.join(", "));
        let mut text = format!(
            "{HEADER}\nmodel = {model}\nname = {name}\ninputs = {inputs}\noutputs = {outputs}\n\
             parameters = {parameters}\n\n"
        );
        values.iter().for_each(|(name, value)| {
            let _ = writeln!(text, "{name} = {value}");
        });
        text
    }

    /// Reads a file.
    ///
    /// # Errors
    /// Says which line is wrong, and why.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        if bytes.len() > LIMIT {
            return Err(format!("it has more than {LIMIT} bytes"));
        }
        let text = str::from_utf8(bytes).map_err(|error| format!("it is no UTF-8: {error}"))?;
        let mut lines = (1..).zip(text.lines());
        if lines.next().is_none_or(|(_, line)| line != HEADER) {
            return Err(format!("its first line is not \"{HEADER}\""));
        }
        let mut stated = |key: &str| {
            let (number, line) = lines.next().unwrap_or_default();
            let value = line.strip_prefix(key).and_then(|rest| rest.trim_start().strip_prefix('='));
            value.map(|value| value.trim().to_owned()).ok_or_else(|| format!("line {number} does not state {key}"))
        };
        let (model, name) = (stated("model")?, stated("name")?);
        let [inputs, outputs, parameters] = [stated("inputs"), stated("outputs"), stated("parameters")];
        let names = |list: Result<String, String>| {
            let list = list?;
            Ok::<Vec<String>, String>(
                list.split(',').map(|it| it.trim().to_owned()).filter(|it| !it.is_empty()).collect(),
            )
        };
        let mut values = BTreeMap::new();
        let (inputs, outputs, parameters) = (names(inputs)?, names(outputs)?, names(parameters)?);
        for (number, line) in lines {
            if line.trim().is_empty() {
                continue;
            }
            let Some((name, value)) = line.rsplit_once(" = ") else {
                return Err(format!("line {number} is not \"name = value\""));
            };
            if values.insert(name.to_owned(), Given::read(value.trim())).is_some() {
                return Err(format!("line {number}: {name} has a value already"));
            }
        }
        Ok(Self { model, name, inputs, outputs, parameters, values })
    }

    /// Finds the variables in the table of the model.
    ///
    /// # Errors
    /// For a name that the table does not have, a name twice, a variable of another kind, and a value that is not legal.
    pub fn resolve(&self, table: &Table) -> Result<Resolved, String> {
        let start = |variable: &Variable| variable.start.unwrap_or_default();
        let mut parameters: Vec<f64> = table.parameters().map(start).collect();
        let mut inputs: Vec<f64> = table.inputs().map(start).collect();
        for (name, value) in &self.values {
            let entry = find(table, name).map_err(|error| error.to_string())?;
            let slot = match entry.place {
                Place::Parameter(place) => &mut parameters[place],
                Place::Input(place) => &mut inputs[place],
                Place::Time | Place::Computed(_) => return Err(format!("{name} cannot have a value: it is computed")),
            };
            *slot = value.value().number(entry.variable).map_err(|error| error.to_string())?;
        }
        let inputs_kept = kept(table, &self.inputs, "input", |variable| variable.role == Role::Input)?;
        let parameters_kept = kept(table, &self.parameters, "parameter", Variable::is_parameter)?;
        let outputs = kept(table, &self.outputs, "output", |variable| variable.role == Role::Output)?;
        Ok(Resolved { parameters, inputs, settable: &inputs_kept | &parameters_kept, outputs })
    }
}

/// The value references of variables by name, an array by the name that all elements share.
fn kept(table: &Table, names: &[String], what: &str, is: impl Fn(&Variable) -> bool) -> Result<BTreeSet<u32>, String> {
    let mut references = BTreeSet::new();
    for name in names {
        let elements: Vec<u32> =
            table.iter().filter(|it| array_name(&it.name) == Some(name)).map(|it| it.reference).collect();
        let found = match elements.first() {
            Some(first) => table.by_reference(*first).ok_or_else(|| format!("there is no variable {name}"))?,
            None => find(table, name).map_err(|error| error.to_string())?,
        };
        if !is(found.variable) {
            return Err(format!("{name} is no {what}"));
        }
        let elements = if elements.is_empty() { vec![found.variable.reference] } else { elements };
        for reference in elements {
            if !references.insert(reference) {
                return Err(format!("{name} is listed twice"));
            }
        }
    }
    Ok(references)
}

/// A number of the table as a value of a variable.
pub fn given(variable: &Variable, number: f64) -> Given {
    match variable.kind {
        Kind::Boolean => Given::Flag(number != 0.0),
        Kind::Enumeration(of) => match of.items.iter().find(|(id, ..)| f64::from(*id) == number) {
            Some((_, name, _)) => Given::Item((*name).to_owned()),
            None => Given::Number(number),
        },
        Kind::Real(_) | Kind::Integer => Given::Number(number),
    }
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

    use super::*;

    const GOOD: &str = "pneumatic-servo variant 1\nmodel = PneumaticServoCylinder\nname = Axis 7\n\
                        inputs = valveVoltage, coil\noutputs = position\nparameters = mass.carriage\n\n\
                        balance.enabled = true\ncylinder.bore = 0.032\nfriction.law = LuGre\nsupplyPressure = 600000.0\n";

    fn resolve(text: &str) -> Result<Resolved, String> {
        Variant::read(text.as_bytes())?.resolve(MODEL.table())
    }

    #[test]
    fn file_gives_the_variant_back_with_the_same_bytes() -> Result<(), String> {
        let variant = Variant::read(GOOD.as_bytes())?;
        assert_eq!((&*variant.name, &*variant.inputs), ("Axis 7", &["valveVoltage".to_owned(), "coil".to_owned()][..]));
        assert_eq!(variant.text(), GOOD);
        let resolved = variant.resolve(MODEL.table())?;
        let value = |name: &str| match MODEL.table().find(name).map(|entry| entry.place) {
            Some(Place::Parameter(place)) => resolved.parameters[place],
            Some(Place::Input(place)) => resolved.inputs[place],
            _ => f64::NAN,
        };
        assert_eq!(["friction.law", "cylinder.bore", "balance.enabled"].map(value), [14.0, 0.032, 1.0]);
        assert_eq!((value("supplyPressure"), value("valveVoltage")), (6e5, 5.0));
        // All coils, by the name of the array.
        assert_eq!(resolved.settable.len(), 6);
        Ok(())
    }

    #[test]
    fn wrong_file_is_refused_by_line_or_name() {
        let with = |line: &str| format!("{GOOD}{line}\n");
        let cases = [
            (String::new(), "first line"),
            (GOOD.replace("variant 1", "variant 2"), "first line"),
            (GOOD.replace("outputs = position\n", ""), "line 5 does not state outputs"),
            (with("cylinder.bore = 0.04"), "line 12: cylinder.bore has a value already"),
            (with("cylinder.bore"), "line 12 is not \"name = value\""),
            (with("cylinder.bohre = 0.04"), "there is no variable cylinder.bohre; did you mean cylinder.bore"),
            (with("cylinder.rodA = -1"), "cylinder.rodA = -1 is refused"),
            (with("cylinder.stroke = inf"), "cylinder.stroke = inf is refused"),
            (with("cylinder.stroke = NaN"), "cylinder.stroke = NaN is refused"),
            (with("cylinder.stroke = LuGre"), "must be a number in m"),
            (with("actuation = 99"), "actuation = 99 is refused"),
            (with("position = 0.1"), "position cannot have a value"),
            (GOOD.replace("inputs = valveVoltage", "inputs = position"), "position is no input"),
            (GOOD.replace("outputs = position", "outputs = position, position"), "position is listed twice"),
            (GOOD.replace("inputs = valveVoltage", "inputs = coil[2]"), "coil is listed twice"),
            (with(&"#".repeat(LIMIT)), "more than 1048576 bytes"),
        ];
        for (text, reason) in cases {
            let refused = resolve(&text).expect_err(reason);
            assert!(refused.contains(reason), "{refused}");
        }
        assert!(Variant::read(b"\xff").expect_err("no text").contains("UTF-8"));
    }

    /// Bytes changed, cut and doubled at random: a file is refused, or gives legal values and the same file again.
    #[test]
    fn damaged_file_never_gives_an_illegal_value() {
        let mut random = 0x9e37_79b9_7f4a_7c15_u64;
        let mut next = |below: usize| {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            (random % below as u64) as usize
        };
        let mut accepted = 0;
        for _ in 0..5_000 {
            let mut bytes = GOOD.as_bytes().to_vec();
            for _ in 0..=next(3) {
                let (place, end) = (next(bytes.len()), next(bytes.len()));
                match next(4) {
                    0 => bytes[place] ^= 1 << next(8),
                    1 => bytes[place] = b"=, \n-.e9"[next(8)],
                    2 => bytes.truncate(place.max(1)),
                    _ => bytes.extend_from_within(place.min(end)..place.max(end)),
                }
            }
            let Ok(variant) = Variant::read(&bytes) else { continue };
            let again = Variant::read(variant.text().as_bytes()).map(|again| again.text());
            assert_eq!(again, Ok(variant.text()));
            let Ok(resolved) = variant.resolve(MODEL.table()) else { continue };
            accepted += 1;
            let (parameters, inputs) = (MODEL.table().parameters(), MODEL.table().inputs());
            for (variable, value) in parameters.zip(&resolved.parameters).chain(inputs.zip(&resolved.inputs)) {
                variable.check(*value).expect("a legal value");
            }
        }
        assert!(accepted > 100, "{accepted} files are accepted");
    }

    /// Any change of the file but line ends, which archives may change, gives another GUID.
    #[test]
    fn guid_follows_every_byte() {
        let one = guid("{model}", GOOD.as_bytes());
        assert_eq!(one.len(), 38);
        for place in 0..GOOD.len() {
            let mut bytes = GOOD.as_bytes().to_vec();
            bytes[place] ^= 1;
            assert_ne!(guid("{model}", &bytes), one, "byte {place}");
        }
        assert_ne!(guid("{other}", GOOD.as_bytes()), one);
        assert_eq!(guid("{model}", GOOD.replace('\n', "\r\n").as_bytes()), one);
    }
}
