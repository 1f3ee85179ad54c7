//! Equations: `\( ... \)` in a line and `\[ ... \]` on its own, written in LaTeX, become MathML.

use anyhow::{Context, Result, bail};
use pulldown_latex::config::{DisplayMode, RenderConfig};
use pulldown_latex::{Parser, Storage, push_mathml};

/// Space that the renderer puts before the name of a function.
const SPACE: &str = "<mspace width=\"0.1667em\" />";

/// Replaces all equations of a text.
///
/// # Errors
/// When an equation has no end or cannot be read.
pub fn render(source: &str) -> Result<String> {
    let mut page = String::with_capacity(2 * source.len());
    let mut rest = source;
    while let Some(start) = rest.find("\\(").into_iter().chain(rest.find("\\[")).min() {
        let (end, mode) = match &rest[start..start + 2] {
            "\\(" => ("\\)", DisplayMode::Inline),
            _ => ("\\]", DisplayMode::Block),
        };
        let inner = &rest[start + 2..];
        let length = inner.find(end).with_context(|| format!("{end} is missing after {}", excerpt(inner)))?;
        page.push_str(&rest[..start]);
        equation(&mut page, &plain(&inner[..length]), mode)?;
        rest = &inner[length + 2..];
    }
    page.push_str(rest);
    Ok(page)
}

fn equation(page: &mut String, latex: &str, display_mode: DisplayMode) -> Result<()> {
    let storage = Storage::new();
    if let Some(error) = Parser::new(latex, &storage).find_map(Result::err) {
        bail!("{}: {error}", excerpt(latex));
    }
    let config = RenderConfig { display_mode, ..RenderConfig::default() };
    let mut mathml = String::new();
    push_mathml(&mut mathml, Parser::new(latex, &storage), config).with_context(|| excerpt(latex))?;
    // The renderer leaves the first as it is, escapes the name of the second, which is then shown letter by letter, and puts
    // the space before a function into its power or index.
    let mathml = mathml.replace("<mo><</mo>", "<mo>&lt;</mo>").replace("&amp;nbsp;", "\u{a0}");
    page.push_str(
        &["msup", "msub", "msubsup"].iter().fold(mathml, |mathml, script| {
            mathml.replace(&format!("<{script}>{SPACE}"), &format!("{SPACE}<{script}>"))
        }),
    );
    Ok(())
}

/// LaTeX without the entities that HTML needs; a bare `&` separates columns.
fn plain(latex: &str) -> String {
    latex.replace("&lt;", "<").replace("&gt;", ">")
}

/// The beginning of a text, for messages.
fn excerpt(text: &str) -> String {
    text.trim().chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_around_equations_stays() -> Result<()> {
        let page = render(r"<p>With \(x\) and \[y = x^2\] done</p>")?;
        assert!(page.starts_with("<p>With <math"));
        assert!(page.contains("</math> and <math display=\"block\""));
        assert!(page.ends_with("</math> done</p>"));
        Ok(())
    }

    #[test]
    fn entities_are_read_as_characters() -> Result<()> {
        let page = render(r"\(a &lt; b\)")?;
        assert!(page.contains("<mo>&lt;</mo>"), "{page}");
        Ok(())
    }

    #[test]
    fn spaces_are_shown_as_spaces() -> Result<()> {
        assert!(render(r"\(1\ \mathrm{Pa}\)")?.contains("<mtext>\u{a0}</mtext>"));
        Ok(())
    }

    #[test]
    fn power_of_a_function_has_a_base_and_an_exponent() -> Result<()> {
        let page = render(r"\(m \sin^2 \phi\)")?;
        assert!(page.contains("<msup><mi>sin</mi><mn>2</mn></msup>"), "{page}");
        Ok(())
    }

    #[test]
    fn broken_equations_are_quoted() {
        let message = |source| render(source).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(message(r"\(x").contains("\\) is missing after x"));
        assert!(message(r"\(\nosuchcommand x\)").contains(r"\nosuchcommand x"));
    }
}
