//! Translates a module: `cargo run -p wasm-as-c --example translate -- MODULE.wasm PREFIX FOLDER [EXPORT...]`. Without names all
//! exported functions are translated.

use std::path::Path;

use anyhow::{Context, Result};

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [module, prefix, folder, exports @ ..] = &words[..] else {
        anyhow::bail!("usage: translate MODULE.wasm PREFIX FOLDER [EXPORT...]");
    };
    let module = std::fs::read(module).with_context(|| format!("cannot read {module}"))?;
    let exports = match exports {
        [] => wasm_as_c::exports(&module)?,
        named => named.to_vec(),
    };
    let exports: Vec<&str> = exports.iter().map(String::as_str).collect();
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {folder}"))?;
    for (name, text) in wasm_as_c::translate(&module, prefix, &exports)? {
        std::fs::write(Path::new(folder).join(&name), text).with_context(|| format!("cannot write {name}"))?;
    }
    Ok(())
}
