//! The section of the documentation page about the configured machine.

use std::fmt::Write;

use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Kind, Place, Variable};
use pneumatic_servo_variant::{Resolved, Variant, given};
use quick_xml::escape::escape;

use crate::Refused;

/// The section, as HTML.
pub fn section(model: &Model, variant: &Variant, resolved: &Resolved) -> String {
    let list = |names: &[String]| match names {
        [] => "none".to_owned(),
        names => names.iter().map(|name| format!("<code>{}</code>", escape(&**name))).collect::<Vec<_>>().join(", "),
    };
    let mut text = format!(
        "<section id=\"configured\">\n<h2>{name}: the configured machine</h2>\n\
         <p>Inputs: {inputs}. Outputs: {outputs}. {parameters} of {all} parameters can be set; the others, and the other \
         inputs, keep the values below or their defaults. The tables of this page are about the model \
         {model}; its defaults are not those of this FMU.</p>\n<div class=\"scroll\" tabindex=\"0\">\n<table>\n\
         <thead><tr><th>Name</th><th>Value</th><th>Unit</th><th>Default</th><th>Description</th></tr></thead>\n<tbody>\n",
        name = escape(&*variant.name),
        inputs = list(&variant.inputs),
        outputs = list(&variant.outputs),
        parameters = model.table().parameters().filter(|it| resolved.settable.contains(&it.reference)).count(),
        all = model.table().parameters().count(),
        model = escape(model.name),
    );
    for (variable, value) in values(model, variant, resolved) {
        let unit = match variable.kind {
            Kind::Real(unit) => unit.name,
            _ => "",
        };
        let _ = writeln!(
            text,
            "<tr><td><code>{}</code></td><td>{}</td><td>{unit}</td><td>{}</td><td>{}</td></tr>",
            escape(&*variable.name),
            given(variable, value),
            given(variable, variable.start.unwrap_or_default()),
            escape(&*variable.description),
        );
    }
    text + "</tbody>\n</table>\n</div>\n</section>\n"
}

/// The configured values, in the order of the table.
pub fn values<'a>(
    model: &'a Model,
    variant: &'a Variant,
    resolved: &'a Resolved,
) -> impl Iterator<Item = (&'static Variable, f64)> + 'a {
    model.table().iter().filter(|variable| variant.values.contains_key(&variable.name)).filter_map(|variable| {
        Some((
            variable,
            match model.table().find(&variable.name)?.place {
                Place::Input(place) => resolved.inputs[place],
                Place::Parameter(place) => resolved.parameters[place],
                Place::Time | Place::Computed(_) => return None,
            },
        ))
    })
}

/// The page with sections before the others, links to them, and the name of the machine in its title.
pub fn with_section(page: &str, name: &str, sections: &str) -> Result<String, Refused> {
    let changed = || Refused("documentation/index.html is no page of this library".to_owned());
    let (head, body) = page.split_once("<main>\n").ok_or_else(changed)?;
    let (contents, rest) = body.split_once("<ul>\n").ok_or_else(changed)?;
    let (links, rest) = rest.split_once("</nav>\n").ok_or_else(changed)?;
    let own = sections.split("<section id=\"").skip(1).filter_map(|section| {
        let (id, section) = section.split_once('"')?;
        let (heading, _) = section.split_once("<h2>")?.1.split_once("</h2>")?;
        Some(format!("<li><a href=\"#{id}\">{heading}</a></li>\n"))
    });
    let name = escape(name);
    let head = head.replacen("<title>", &format!("<title>{name}: "), 1).replacen("<h1>", &format!("<h1>{name}: "), 1);
    Ok(format!("{head}<main>\n{contents}<ul>\n{}{links}</nav>\n{sections}{rest}", own.collect::<String>()))
}
