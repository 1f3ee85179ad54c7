//! SSV: values of variables with the units that they are in.

use std::borrow::Cow;
use std::io;

use pneumatic_servo::variables::{Kind, Role, SettingError, Value, Variable};

use crate::xml::{Element, Xml, document, real};
use crate::{COMMON, PARAMETER_VALUES, Version, units, write_units};

/// A set of values.
pub struct ParameterSet<'a> {
    /// The version of the standard that it follows.
    pub version: Version,
    /// Its name.
    pub name: &'a str,
    /// Text that says what it describes.
    pub description: &'a str,
    /// The tool that writes it, with its version.
    pub tool: &'a str,
    /// When it is written, as XML writes times: `2020-01-01T00:00:00Z`.
    pub time: Option<&'a str>,
    /// The values.
    pub parameters: Vec<Parameter<'a>>,
}

/// The value of a variable, under its own name or its name within a system.
pub struct Parameter<'a> {
    name: Cow<'a, str>,
    variable: &'a Variable,
    value: f64,
}

impl<'a> Parameter<'a> {
    /// A value in the SI unit of its variable; items of enumerations by their name or by their number.
    ///
    /// # Errors
    /// [`SettingError`] if the variable is computed, or cannot have such a value.
    pub fn new<'v>(
        name: impl Into<Cow<'a, str>>,
        variable: &'a Variable,
        value: impl Into<Value<'v>>,
    ) -> Result<Self, SettingError> {
        if !(variable.is_parameter() || variable.role == Role::Input) {
            let name = variable.name.clone();
            return Err(SettingError::NotSettable { name, reason: "it is computed" });
        }
        let value = value.into().number(variable)?;
        Ok(Self { name: name.into(), variable, value })
    }

    fn write(&self, xml: &mut Xml, version: Version) -> io::Result<()> {
        let parameter = Element::new("ssv:Parameter").with("name", &self.name);
        parameter.contain(xml, |xml| self.typed(version).write(xml))
    }

    /// The value, which its variable was asked about.
    fn typed(&self, version: Version) -> Element {
        let (name, value) = match self.variable.kind {
            Kind::Real(_) => (version.choose("ssv:Real", "ssv:Float64"), real(self.value)),
            Kind::Integer => (version.choose("ssv:Integer", "ssv:Int32"), self.value.to_string()),
            Kind::Boolean => ("ssv:Boolean", (self.value != 0.0).to_string()),
            Kind::Enumeration(of) => {
                let item = of.items.iter().find(|(id, ..)| f64::from(*id) == self.value);
                ("ssv:Enumeration", item.map(|(_, name, _)| *name).unwrap_or_default().to_owned())
            }
        };
        let unit = match self.variable.kind {
            Kind::Real(unit) => Some(unit.name),
            _ => None,
        };
        Element::new(name).with("value", &value).with_some("unit", unit)
    }
}

impl ParameterSet<'_> {
    /// The set as a file.
    ///
    /// # Errors
    /// When the text cannot be written.
    pub fn text(&self) -> io::Result<String> {
        document(|xml| self.write(xml))
    }

    /// The set as an element of another file, which may have several.
    ///
    /// # Errors
    /// When the text cannot be written.
    pub fn write(&self, xml: &mut Xml) -> io::Result<()> {
        let root = Element::new("ssv:ParameterSet")
            .with("xmlns:ssc", COMMON)
            .with("xmlns:ssv", PARAMETER_VALUES)
            .with("version", self.version.number())
            .with("name", self.name)
            .with("description", self.description)
            .with("generationTool", self.tool)
            .with_some("generationDateAndTime", self.time);
        root.contain(xml, |xml| {
            Element::new("ssv:Parameters").contain(xml, |xml| {
                self.parameters.iter().try_for_each(|parameter| parameter.write(xml, self.version))
            })?;
            write_units(xml, "ssv:Units", &units::used(self.parameters.iter().map(|parameter| parameter.variable)))
        })
    }
}

#[cfg(test)]
mod tests {
    use pneumatic_servo::models::pneumatic_servo_cylinder::MODEL;

    use super::*;

    fn variable(name: &str) -> &'static Variable {
        MODEL.table().find(name).expect("a variable").variable
    }

    fn parameter<'a>(name: &'a str, value: impl Into<Value<'a>>) -> Result<Parameter<'a>, SettingError> {
        Parameter::new(name, variable(name), value)
    }

    /// All kinds of values, by name and by number, what XML must not take for its own, and no time.
    #[test]
    fn set_is_written_with_its_units() -> Result<(), Box<dyn std::error::Error>> {
        let set = ParameterSet {
            version: Version::One,
            name: "Kinds",
            description: "of <all> \"kinds\" & more",
            tool: "a test 1.0",
            time: None,
            parameters: vec![
                parameter("friction.law", "LuGre")?,
                Parameter::new("plant.friction.law", variable("friction.law"), 14.0)?,
                parameter("valve.polarity", -1)?,
                parameter("balance.enabled", true)?,
                parameter("supplyPressure", 6e5)?,
                parameter("friction.lugre.sigma0", 1234.1)?,
                parameter("ambientPressure", 101_325.0)?,
            ],
        };
        let expected = format!(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet xmlns:ssc="{COMMON}" xmlns:ssv="{PARAMETER_VALUES}" version="1.0" name="Kinds" description="of &lt;all&gt; &quot;kinds&quot; &amp; more" generationTool="a test 1.0">
  <ssv:Parameters>
    <ssv:Parameter name="friction.law">
      <ssv:Enumeration value="LuGre"/>
    </ssv:Parameter>
    <ssv:Parameter name="plant.friction.law">
      <ssv:Enumeration value="LuGre"/>
    </ssv:Parameter>
    <ssv:Parameter name="valve.polarity">
      <ssv:Integer value="-1"/>
    </ssv:Parameter>
    <ssv:Parameter name="balance.enabled">
      <ssv:Boolean value="true"/>
    </ssv:Parameter>
    <ssv:Parameter name="supplyPressure">
      <ssv:Real value="600000.0" unit="Pa"/>
    </ssv:Parameter>
    <ssv:Parameter name="friction.lugre.sigma0">
      <ssv:Real value="1234.1" unit="N/m"/>
    </ssv:Parameter>
    <ssv:Parameter name="ambientPressure">
      <ssv:Real value="101325.0" unit="Pa"/>
    </ssv:Parameter>
  </ssv:Parameters>
  <ssv:Units>
    <ssc:Unit name="Pa">
      <ssc:BaseUnit kg="1" m="-1" s="-2"/>
    </ssc:Unit>
    <ssc:Unit name="N/m">
      <ssc:BaseUnit kg="1" s="-2"/>
    </ssc:Unit>
  </ssv:Units>
</ssv:ParameterSet>
"#
        );
        assert_eq!(set.text()?, expected);
        let expected = expected.replace("\"1.0\" name", "\"2.0\" name").replace("ssv:Real", "ssv:Float64");
        let set = ParameterSet { version: Version::Two, ..set };
        assert_eq!(set.text()?, expected.replace("ssv:Integer", "ssv:Int32"));
        Ok(())
    }

    /// The schema demands that a section of units is not empty.
    #[test]
    fn set_without_units_has_no_section_of_them() -> Result<(), Box<dyn std::error::Error>> {
        let parameters = vec![parameter("friction.law", "LuGre")?];
        let time = Some("2020-01-01T00:00:00Z");
        let text = ParameterSet { version: Version::One, name: "Law", description: "", tool: "", time, parameters };
        let text = text.text()?;
        assert!(text.contains(r#" generationDateAndTime="2020-01-01T00:00:00Z">"#), "{text}");
        assert!(!text.contains("Units"), "{text}");
        Ok(())
    }

    #[test]
    fn value_that_a_variable_cannot_have_is_refused() {
        let refused = |name, value: Value<'static>| {
            parameter(name, value).err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert!(refused("cylinder.bore", (-0.016).into()).starts_with("cylinder.bore = -0.016 is refused"));
        assert!(refused("friction.law", "Sticky".into()).starts_with("friction.law = \"Sticky\" is refused"));
        assert!(refused("friction.law", 999.0.into()).starts_with("friction.law = 999 is refused"));
        assert_eq!(refused("position", 0.1.into()), "position cannot be set: it is computed");
        assert!(refused("supplyPressure", f64::NAN.into()).contains("it must be a finite number"));
    }
}
