//! Measures every friction law, compares with general solvers at equal error, and writes `target/bench`.
//!
//! `cargo bench --package benchmark --features rival --bench comparison`; with `-- latency` or `-- precision` only that part,
//! and with names of laws, as in `-- precision LuGre`, only those are compared. Of a whole run `page.md` holds the tables of
//! `docs/performance.md`, and `laws.csv` and `ratios.csv` are the files beside it.

use std::env;
use std::fs;

use anyhow::Result;
use benchmark::page::{self, Row};
use benchmark::report::{Comparison, draw, folder, latency_table, points, ratio_table};
use benchmark::{case, latency, precision};

/// The default tolerance of the FMU.
const TOLERANCE: f64 = 1e-6;

fn main() -> Result<()> {
    let asked = |part: &str| env::args().any(|argument| argument == part);
    let everything = !asked("latency") && !asked("precision");
    let folder = folder()?;
    let mut report = String::from("# Cost of a communication step\n");
    let mut page = String::new();
    if everything || asked("latency") {
        let rows = latencies();
        report += &format!("\n{}", latency_table(&rows));
        page += &format!("Every law:\n\n{}\n", page::laws(&rows));
        fs::write(folder.join("laws.csv"), page::law_file(&rows))?;
    }
    if everything || asked("precision") {
        let comparisons = comparisons()?;
        page += &format!("Head:\n\n{}\n", page::head(&comparisons, 1e-6, TOLERANCE));
        page += &format!("Result:\n\n{}\n", page::ratios(&comparisons, 1e-6));
        fs::write(folder.join("ratios.csv"), page::ratio_file(&comparisons))?;
        for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
            report += &format!("\n## Ratios at the errors of the rival at {tolerance:e}\n\n");
            report += &ratio_table(&comparisons, tolerance);
        }
        let (data, figure) = (folder.join("work-precision.csv"), folder.join("work-precision.png"));
        fs::write(&data, points(&comparisons))?;
        if let Err(error) = draw(&data, &figure) {
            eprintln!("no figure: {error:#}");
        }
    }
    fs::write(folder.join("report.md"), &report)?;
    fs::write(folder.join("page.md"), &page)?;
    println!("{report}\nwritten to {}", folder.display());
    Ok(())
}

fn latencies() -> Vec<Row> {
    let mut rows = Vec::new();
    for cylinder in case::all() {
        for size in [1e-3, 1e-2] {
            let found = latency::measure(&cylinder, TOLERANCE, size, case::DURATION, 20);
            rows.push((cylinder.name.clone(), size, found));
        }
    }
    rows
}

fn comparisons() -> Result<Vec<Comparison>> {
    let asked: Vec<String> = env::args().skip(1).collect();
    let mut cases = case::compared();
    if cases.iter().any(|case| asked.contains(&case.name)) {
        cases.retain(|case| asked.contains(&case.name));
    }
    let measured = cases.into_iter().map(|case| {
        eprintln!("comparing {}", case.name);
        let reference = precision::reference(&case);
        Ok(Comparison { curves: precision::measure(&case, &reference, 3)?, name: case.name })
    });
    measured.collect()
}
