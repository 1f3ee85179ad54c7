//! `documentation/index.html`: one self-contained page per model, from hand-written text and the variable table.

mod experiment;
mod laws;
mod math;
mod table;
mod text;

use anyhow::{Context, Result};
use pneumatic_servo::model::Model;
use pneumatic_servo::system::Indicator;
use pneumatic_servo::variables::Role;

pub use self::experiment::{figure, section as experiment};
use self::table::{END, TABLE};
use self::text::escape;
use crate::description::Version;
use crate::product::{Parts, Product};

/// The page of a model around its hand-written part, `<Model>.html`, and the section of its experiment. Without that file the
/// page says what the tables do.
///
/// # Errors
/// When a file that it includes is missing, or an equation in it cannot be read.
pub fn page(model: &Model, version: Version, product: &Product, experiment: &str) -> Result<String> {
    let source = match source(&product.parts, &format!("{}.html", model.name))? {
        Some(source) => laws::numbered(&source, model, &product.parts)?,
        None => generated(model),
    };
    let variables = model.table();
    let of_role = |roles: &[Role]| variables.iter().filter(|v| roles.contains(&v.role)).collect::<Vec<_>>();
    let sections = [
        math::render(&source).with_context(|| format!("the equations of {}", model.name))?,
        experiment.to_owned(),
        table::interface("inputs", "Inputs", &of_role(&[Role::Input])),
        table::interface("outputs", "Outputs", &of_role(&[Role::Output])),
        table::parameters(variables),
        table::enumerations(variables),
        table::interface("internal", "Internal variables", &of_role(&[Role::Local])),
        licence(product),
    ];
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{name}</title>\n\
         <style>\n{style}</style>\n</head>\n<body>\n<header>\n<h1>{name}</h1>\n<p>{description}</p>\n\
         <p class=\"facts\">{fmi}, version {release}, default experiment 0 s to {stop} s \
         with communication steps of {step} s</p>\n<p>{kinds}</p>\n</header>\n<main>\n{contents}{sections}</main>\n</body>\n</html>\n",
        name = escape(model.name),
        style = include_str!("style.css"),
        description = escape(model.description),
        fmi = version.name(),
        kinds = kinds(model, version),
        release = escape(&product.version),
        stop = text::number(model.experiment.stop_time),
        step = text::number(model.experiment.step_size),
        contents = contents(&sections.concat()),
        sections = sections.concat(),
    ))
}

/// Which kind and version to choose.
fn kinds(model: &Model, version: Version) -> String {
    if model.table().number_of_states() == 0 {
        return "Import it for co-simulation: there are no continuous states to exchange.".to_owned();
    }
    let kinds = "Import it for co-simulation, where the solver inside locates events, such as stick and slip; choose model exchange where a tool \
                 offers nothing else, or where one solver is to see the whole system or derivatives.";
    let other = match version {
        Version::Fmi2 => {
            "A host that is to react to events, in co-simulation with event mode, needs the FMU of FMI 3.0."
        }
        Version::Fmi3 => {
            "With event mode a step ends at an event, a break-away for example, if the host allows early return. Tools \
             that do not know FMI 3.0 take the FMU of FMI 2.0, of the same build."
        }
    };
    format!("{kinds} {other}")
}

/// Links to all sections.
fn contents(sections: &str) -> String {
    let headings = sections.split("<section id=\"").skip(1).filter_map(|section| {
        let (id, rest) = section.split_once('"')?;
        let (_, heading) = rest.split_once("<h2>")?;
        let (heading, _) = heading.split_once("</h2>")?;
        Some(format!("<li><a href=\"#{id}\">{heading}</a></li>\n"))
    });
    format!("<nav aria-label=\"Contents\">\n<ul>\n{}</ul>\n</nav>\n", headings.collect::<String>())
}

/// A file in which every line `{{name}}` is replaced by the file of that name; nothing if there is no such file.
fn source(parts: &Parts, name: &str) -> Result<Option<String>> {
    let Some(text) = parts.text(name)? else { return Ok(None) };
    let mut whole = String::new();
    for line in text.lines() {
        match line.strip_prefix("{{").and_then(|line| line.strip_suffix("}}")) {
            Some(included) => {
                let part = source(parts, included)?;
                whole.push_str(&part.with_context(|| format!("{name} includes {included}, which is missing"))?);
            }
            None => whole.extend([line, "\n"]),
        }
    }
    Ok(Some(whole))
}

/// Generated text of a model without a hand-written part: its contents and its events.
fn generated(model: &Model) -> String {
    let mut page =
        format!("<section id=\"purpose\">\n<h2>Purpose</h2>\n<p>{}</p>\n</section>\n", escape(model.description));
    let events = model.indicators();
    if !events.is_empty() {
        let row = |event: &Indicator| {
            format!("<tr><td><code>{}</code></td><td>{}</td></tr>\n", escape(&event.name), escape(event.text))
        };
        page.push_str(&format!(
            "<section id=\"events\">\n<h2>Events</h2>\n{TABLE}\n<thead><tr><th>Name</th><th>What happens</th></tr></thead>\n\
             <tbody>\n{}</tbody>\n{END}\n</section>\n",
            events.iter().map(row).collect::<String>()
        ));
    }
    page
}

fn licence(product: &Product) -> String {
    let licence = match (product.is_of_the_project(), &*product.licence) {
        (true, _) => "MIT or Apache-2.0, at your choice".to_owned(),
        (false, "") => "Its author states none".to_owned(),
        (false, licence) => escape(licence),
    };
    format!(
        "<section id=\"licence\">\n<h2>Licence</h2>\n<p>{licence}; the texts, and the licences of the packages inside the library, are in \
         <code>documentation/licenses</code> of the FMU.</p>\n</section>\n"
    )
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use pneumatic_servo::model::Functions;
    use pneumatic_servo::models;

    use super::*;

    fn product() -> Product {
        Product::of_the_project(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
    }

    #[test]
    fn every_variable_is_on_the_page_of_its_model() -> Result<()> {
        for model in models::ALL {
            let page = page(model, Version::Fmi2, &product(), "")?;
            for variable in model.table().iter().filter(|variable| variable.role != Role::Time) {
                let cell = format!("<code>{}</code>", escape(&variable.name));
                assert!(page.contains(&cell), "{} is missing", variable.name);
            }
            assert!(!page.contains("http://") && !page.contains("https://"), "the page needs a network");
        }
        Ok(())
    }

    #[test]
    fn contents_lead_to_every_section() -> Result<()> {
        for model in models::ALL {
            let page = page(model, Version::Fmi2, &product(), "")?;
            let sections: Vec<_> =
                page.split("<section id=\"").skip(1).filter_map(|text| text.split('"').next()).collect();
            let links: Vec<_> =
                page.split("<li><a href=\"#").skip(1).filter_map(|text| text.split('"').next()).collect();
            assert_eq!(links, sections, "{}", model.name);
            assert!(sections.len() > 5, "{}: {sections:?}", model.name);
        }
        Ok(())
    }

    #[test]
    fn equations_are_given_for_exactly_the_friction_laws() -> Result<()> {
        let page = source(&product().parts, "friction.html")?.context("the file")?;
        let named = page.split("<tr><td>").skip(1).filter_map(|row| row.split_once("</td>")).map(|(name, _)| name);
        let laws = pneumatic_servo::friction::LAWS.items.iter().map(|(_, name, _)| *name);
        assert_eq!(named.collect::<Vec<_>>(), laws.collect::<Vec<_>>(), "modelDescription/friction.html");
        Ok(())
    }

    #[test]
    fn page_says_the_licence_of_whose_fmu_it_is() {
        let told = |source: Option<&str>, of: &str| {
            let product = Product { source: source.map(str::to_owned), licence: of.to_owned(), ..product() };
            licence(&product)
        };
        assert!(told(None, "").contains("<p>MIT or Apache-2.0, at your choice; the texts"));
        assert!(told(Some("0"), "BSD-3-Clause").contains("<p>BSD-3-Clause; the texts"));
        assert!(told(Some("0"), "A & B").contains("<p>A &amp; B; the texts"));
        assert!(told(Some("0"), "").contains("<p>Its author states none; the texts"));
    }

    /// A model of somebody else, whose page nobody has written.
    #[test]
    fn page_without_a_written_part_says_what_the_model_is_and_what_happens_in_it() -> Result<()> {
        let quiet = Model {
            name: "Own",
            description: "Gas & oil",
            functions: Functions { indicators: Vec::new, ..models::friction_bench::MODEL.functions },
            ..models::friction_bench::MODEL
        };
        let purpose = "<section id=\"purpose\">\n<h2>Purpose</h2>\n<p>Gas &amp; oil</p>\n</section>\n";
        assert_eq!(generated(&quiet), purpose);
        let indicators = || vec![Indicator { name: "a<b".to_owned(), nominal: 1.0, text: "Below" }];
        let events = generated(&Model { functions: Functions { indicators, ..quiet.functions }, ..quiet });
        assert_eq!(
            events.strip_prefix(purpose).context("a purpose")?,
            "<section id=\"events\">\n<h2>Events</h2>\n<div class=\"scroll\" tabindex=\"0\">\n<table>\n\
             <thead><tr><th>Name</th><th>What happens</th></tr></thead>\n<tbody>\n\
             <tr><td><code>a&lt;b</code></td><td>Below</td></tr>\n</tbody>\n</table>\n</div>\n</section>\n"
        );
        let page = page(
            &Model { functions: Functions { indicators, ..quiet.functions }, ..quiet },
            Version::Fmi3,
            &product(),
            "",
        )?;
        assert!(page.contains(&events) && page.contains("<title>Own</title>"), "{page}");
        Ok(())
    }

    /// Where there are no states there is nothing to exchange; events are for hosts of FMI 3.0.
    #[test]
    fn page_says_which_kind_and_version_to_choose() {
        const COSIMULATION: &str = "Import it for co-simulation: there are no continuous states to exchange.";
        for version in [Version::Fmi2, Version::Fmi3] {
            assert_eq!(kinds(&models::position_controller::MODEL, version), COSIMULATION);
            let kinds = kinds(&models::pneumatic_servo_cylinder::MODEL, version);
            assert!(kinds.contains("choose model exchange where a tool offers nothing else"), "{kinds}");
            assert_eq!(kinds.contains("needs the FMU of FMI 3.0."), version == Version::Fmi2, "{kinds}");
            assert_eq!(kinds.contains("With event mode a step ends at an event"), version == Version::Fmi3, "{kinds}");
        }
    }
}
