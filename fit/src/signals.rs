//! Signals of a table: which columns they are by their names, in SI units, on one clock.

use crate::Refused;
use crate::arrays::interpolate;
use crate::calibration::Calibration;
use crate::record::unit_of;
use crate::tables::Table;
use crate::units;

/// Inputs of the plant: recorded values of these are in force until the next one, and readings run on straight lines.
pub const COMMANDS: [&str; 3] = ["valveVoltage", "supplyPressure", "externalForce"];
/// Signal that counts above ambient pressure: a gauge unit of it has no offset.
pub const ABOVE_AMBIENT: &str = "pressure";

/// Names that are usual for a signal beside its own, in English and German, without blanks, low lines and hyphens.
const NAMES: [(&str, &[&str]); 10] = [
    ("time", &["t", "time", "zeit", "uhrzeit", "timestamp", "zeitstempel"]),
    (
        "position",
        &[
            "x",
            "pos",
            "position",
            "stroke",
            "displacement",
            "pistonposition",
            "weg",
            "hub",
            "kolbenweg",
            "kolbenposition",
        ],
    ),
    ("velocity", &["v", "vel", "velocity", "speed", "geschwindigkeit", "kolbengeschwindigkeit"]),
    ("frictionForce", &["ff", "friction", "frictionforce", "reibung", "reibkraft", "reibungskraft"]),
    ("force", &["f", "force", "kraft"]),
    ("normalForce", &["fn", "normalforce", "normalkraft"]),
    ("pressure", &["p", "pressure", "druck"]),
    (
        "valveVoltage",
        &[
            "u",
            "voltage",
            "valvevoltage",
            "valvesignal",
            "valvecommand",
            "controlvoltage",
            "spannung",
            "ventilspannung",
            "stellspannung",
            "steuerspannung",
        ],
    ),
    ("supplyPressure", &["ps", "supply", "supplypressure", "versorgungsdruck", "speisedruck"]),
    ("externalForce", &["fext", "externalforce", "externekraft", "lastkraft", "loadforce"]),
];
/// Chambers with their letters and numbers, and names of their pressures: before the letter or number, and behind it.
const CHAMBERS: [(&str, [&str; 2]); 2] = [("chamberA.pressure", ["a", "1"]), ("chamberB.pressure", ["b", "2"])];
const OF_CHAMBER: [[&str; 2]; 10] = [
    ["p", ""],
    ["pressure", ""],
    ["druck", ""],
    ["chamber", ""],
    ["kammer", ""],
    ["chamberpressure", ""],
    ["kammerdruck", ""],
    ["chamber", "pressure"],
    ["kammer", "druck"],
    ["pkammer", ""],
];

/// A column that its name tells to be a signal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Proposed {
    /// The signal.
    pub signal: String,
    /// The place of the column.
    pub place: usize,
    /// The unit that is written, in the table or at the end of the name.
    pub unit: Option<String>,
}

/// Whether a name is usual for a signal.
fn is_usual(name: &str, signal: &str) -> bool {
    let plain: String =
        name.to_lowercase().chars().filter(|letter| !matches!(letter, ' ' | '_' | '-' | '\u{a0}')).collect();
    if let Some((_, sides)) = CHAMBERS.iter().find(|(chamber, _)| *chamber == signal) {
        let is_one = |side: &&str| OF_CHAMBER.iter().any(|[before, behind]| format!("{before}{side}{behind}") == plain);
        return sides.iter().any(is_one);
    }
    NAMES.iter().any(|(known, names)| *known == signal && names.contains(&plain.as_str()))
}

/// Signals by the names of columns: their own names first, then usual ones, then usual ones with a unit behind a low line. No column
/// is taken twice; they are in the order of the signals.
pub fn proposed(names: &[String], units: &[Option<String>], signals: &[&str]) -> Vec<Proposed> {
    let mut found: Vec<Proposed> = Vec::new();
    let in_unit = |name: &str, signal: &str| {
        let (bare, unit) = name.rsplit_once('_')?;
        let is_one = is_usual(bare, signal) && units::to_si(unit, unit_of(signal), false).is_ok();
        is_one.then(|| unit.to_owned())
    };
    let is_named = |signal: &str| names.iter().any(|name| name == signal || is_usual(name, signal));
    // `F_N` is a force in N, and a normal force only where its unit stands elsewhere, or another column is the force.
    let is_of_other = |name: &str, own: &str| {
        let is_one = |other: &&str| *other != own && in_unit(name, other).is_some() && !is_named(other);
        let place = names.iter().position(|one| one == name).expect("a name of the table");
        units.get(place).is_none_or(Option::is_none) && signals.iter().any(is_one)
    };
    let mut take = |matches: &dyn Fn(&str, &str) -> Option<Option<String>>| {
        for signal in signals {
            if found.iter().any(|one| one.signal == *signal) {
                continue;
            }
            let free = (0..names.len()).filter(|place| found.iter().all(|one| one.place != *place));
            let column = free.filter_map(|place| Some((place, matches(&names[place], signal)?))).next();
            if let Some((place, unit)) = column {
                let unit = unit.or_else(|| units.get(place).cloned().flatten());
                found.push(Proposed { signal: (*signal).to_owned(), place, unit });
            }
        }
    };
    take(&|name, signal| (name == signal).then_some(None));
    take(&|name, signal| (is_usual(name, signal) && !is_of_other(name, signal)).then_some(None));
    take(&|name, signal| in_unit(name, signal).map(Some));
    found.sort_by_key(|one| signals.iter().position(|signal| *signal == one.signal));
    found
}

/// A column of a table as a signal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chosen {
    /// The signal.
    pub signal: String,
    /// The place of the column.
    pub place: usize,
    /// The unit of its numbers, and the SI unit of the signal.
    pub unit: String,
    /// The SI unit that they are converted to.
    pub si: String,
    /// Whether its sign is the opposite of ours.
    pub is_turned: bool,
}

/// Signals at the samples of one clock.
#[derive(Clone, Debug, PartialEq)]
pub struct OnOneClock {
    /// The samples of each chosen column, in their order.
    pub samples: Vec<Vec<f64>>,
    /// Those that were read at other times than the chosen ones.
    pub others: Vec<String>,
}

impl Table {
    /// Where a column stands, for people.
    fn column(&self, file: &str, place: usize) -> String {
        format!("{file}:{}, column {} ({})", self.first, place + 1, self.names[place])
    }

    /// Where a value of a column stands, for people.
    pub fn place(&self, file: &str, column: usize, row: usize) -> String {
        format!("{file}:{}, column {} ({})", self.lines[row], column + 1, self.names[column])
    }

    /// A column in an SI unit; NaN in empty cells, if it may have them.
    fn in_si(&self, file: &str, chosen: &Chosen, may_have_gaps: bool) -> Result<Vec<f64>, Refused> {
        if let Some(fault) = self.faults.get(&chosen.place)
            && !(may_have_gaps && self.gaps.contains(&chosen.place))
        {
            return Err(Refused(fault.clone()));
        }
        self.check_reading(file, chosen)?;
        let scale = units::to_si(&chosen.unit, &chosen.si, chosen.signal == ABOVE_AMBIENT);
        let scale = scale.map_err(|problem| Refused(format!("{}: {problem}", self.column(file, chosen.place))))?;
        let mut values = units::scaled(&self.columns[chosen.place], scale);
        if chosen.is_turned {
            values.iter_mut().for_each(|value| *value = -*value);
        }
        Ok(values)
    }

    /// The chosen columns in SI units at the samples of that for `time`: commands are held, readings run on straight lines. Without
    /// one for `time` each row is a point of its own.
    ///
    /// A channel has a clock of its own in files of some recorders, or empty cells where it was not read.
    ///
    /// # Errors
    /// In words for the user, for a column that is no numbers, a unit that is none of its signal, and times that do not rise.
    pub fn signals(&self, file: &str, chosen: &[Chosen]) -> Result<OnOneClock, Refused> {
        let Some(at) = chosen.iter().position(|column| column.signal == "time") else {
            let points = chosen.iter().map(|column| self.in_si(file, column, false)).collect::<Result<_, _>>()?;
            return Ok(OnOneClock { samples: points, others: vec![] });
        };
        let time = &chosen[at];
        let in_si = |column: &Chosen| self.in_si(file, column, column.signal != "time");
        let mut samples = chosen.iter().map(in_si).collect::<Result<Vec<_>, _>>()?;
        self.check_time(file, time)?;
        let grid: Vec<f64> = samples[at].iter().copied().filter(|time| time.is_finite()).collect();
        let clock = |place: usize| match self.clocks.is_empty() {
            true => time.place,
            false => self.clocks.get(&place).copied().unwrap_or(0),
        };
        let (mut begin, mut end) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut others = Vec::new();
        for (column, values) in chosen.iter().zip(&mut samples) {
            let own = if column.signal == "time" { time.place } else { clock(column.place) };
            if own == time.place && values.iter().take(grid.len()).all(|value| value.is_finite()) {
                values.truncate(grid.len());
                continue;
            }
            let times = if own == time.place {
                self.in_si(file, time, false)?
            } else {
                let unit = self.units[own].clone().unwrap_or_else(|| time.unit.clone());
                self.in_si(file, &Chosen { place: own, unit, is_turned: false, ..time.clone() }, false)?
            };
            let known = times.iter().zip(values.iter()).filter(|(time, value)| time.is_finite() && value.is_finite());
            let (times, known): (Vec<f64>, Vec<f64>) = known.unzip();
            let [Some(first), Some(last)] = [times.first(), times.last()] else {
                return Err(Refused(format!("{}: it has no sample", self.column(file, column.place))));
            };
            (begin, end) = (begin.max(*first), end.min(*last));
            *values = if COMMANDS.contains(&column.signal.as_str()) {
                let held = |time: &f64| known[times.partition_point(|own| own <= time).saturating_sub(1)];
                grid.iter().map(held).collect()
            } else {
                interpolate(grid.iter().copied(), &times, &known)
            };
            others.push(column.signal.clone());
        }
        if !others.is_empty() {
            let inside: Vec<bool> = grid.iter().map(|time| (begin..=end).contains(time)).collect();
            for values in &mut samples {
                let mut is_inside = inside.iter();
                values.retain(|_| is_inside.next().is_some_and(|is_inside| *is_inside));
            }
        }
        Ok(OnOneClock { samples, others })
    }

    /// Refuses a calibration of readings in another unit than the table says.
    fn check_reading(&self, file: &str, chosen: &Chosen) -> Result<(), Refused> {
        let (Some(Ok(calibration)), Some(written)) = (Calibration::parse(&chosen.unit), &self.units[chosen.place])
        else {
            return Ok(());
        };
        // Behind a pressure it is a chamber.
        let is_chamber = written == "A" && chosen.signal != "force";
        if is_chamber || *written == chosen.unit || units::spelled(written) == calibration.reading {
            return Ok(());
        }
        let reading = if calibration.reading.is_empty() { "counts" } else { &calibration.reading };
        Err(Refused(format!(
            "{}: the table says {written}, but the calibration {} reads {reading}; which is it?",
            self.column(file, chosen.place),
            chosen.unit
        )))
    }

    /// Refuses times that do not rise, as they are written.
    fn check_time(&self, file: &str, time: &Chosen) -> Result<(), Refused> {
        let times = &self.columns[time.place];
        let sign = if time.is_turned { -1.0 } else { 1.0 };
        let falls = times.windows(2).position(|pair| sign * (pair[1] - pair[0]) <= 0.0);
        let Some(row) = falls else { return Ok(()) };
        Err(Refused(format!(
            "{file}:{}, column {}: time must rise, but {} {unit} follows {} {unit}",
            self.lines[row + 1],
            self.names[time.place],
            times[row + 1],
            times[row],
            unit = time.unit
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::read;

    const RIG: [&str; 8] = [
        "time",
        "valveVoltage",
        "position",
        "velocity",
        "chamberA.pressure",
        "chamberB.pressure",
        "supplyPressure",
        "externalForce",
    ];

    const BENCH: [&str; 4] = ["time", "position", "force", "normalForce"];

    fn told(header: &str) -> Vec<String> {
        told_of(&RIG, header)
    }

    fn told_of(signals: &[&str], header: &str) -> Vec<String> {
        let table =
            read("rig.csv", format!("{header}\n{}\n", vec!["0"; header.split(';').count()].join(";")).as_bytes());
        let table = table.expect("a table");
        let found = proposed(&table.names, &table.units, signals);
        found.iter().map(|one| format!("{} {} {}", one.place, one.signal, one.unit.as_deref().unwrap_or("-"))).collect()
    }

    #[test]
    fn names_in_english_and_german_tell_signals() {
        let expected =
            ["0 time s", "1 valveVoltage V", "2 position mm", "3 chamberA.pressure bar", "4 chamberB.pressure bar"];
        for header in [
            "Zeit [s];Valve voltage [V];Stroke [mm];Pressure A [bar];Pressure B [bar]",
            "Time  [s];Spannung [V];Hub [mm];Druck A [bar];Kammer B Druck [bar]",
            "t [s];valve-signal [V];piston_position [mm];P1 [bar];chamber 2 [bar]",
        ] {
            assert_eq!(told(header), expected, "{header}");
        }
        // Which pressure it is has to be told.
        assert_eq!(told("t;u;x;pressure;pressure C"), ["0 time -", "1 valveVoltage -", "2 position -"]);
        // Its own name comes first, and no column is taken twice.
        assert_eq!(told("t;x_mm;position [um];p_1"), ["0 time -", "2 position um", "3 chamberA.pressure -"]);
        assert_eq!(told("Zeit;x_mm;pA_bar"), ["0 time -", "1 position mm", "2 chamberA.pressure bar"]);
    }

    #[test]
    fn a_force_in_newtons_is_no_normal_force() {
        for (header, expected) in [
            ("t_s;x_mm;F_N", "2 force N"),
            ("t;x;F_N;Fn", "2 force N, 3 normalForce -"),
            // Its unit stands elsewhere, or another column is the force.
            ("t [s];x [mm];F_N [N]", "2 normalForce N"),
            ("t;x;F;F_N", "2 force -, 3 normalForce -"),
            ("t;x;Kraft [kN];F_N", "2 force kN, 3 normalForce -"),
        ] {
            let found = told_of(&BENCH, header);
            assert_eq!(found[2..].join(", "), expected, "{header}");
        }
    }

    fn chosen(signal: &str, place: usize, unit: &str) -> Chosen {
        let si = unit_of(signal).to_owned();
        Chosen { signal: signal.to_owned(), place, unit: unit.to_owned(), si, is_turned: false }
    }

    fn table(text: &str) -> Table {
        read("rig.csv", text.as_bytes()).expect("a table")
    }

    #[test]
    fn columns_are_in_si_units_with_the_sign_that_is_ours() {
        let table = table("t [ms];x [mm];p\n0;250,06;1\n1;250;2\n");
        let turned = Chosen { is_turned: true, ..chosen("position", 1, "mm") };
        let found = table.signals("rig.csv", &[chosen("time", 0, "ms"), turned, chosen("pressure", 2, "barg")]);
        let found = found.expect("signals");
        assert_eq!(found.samples, [vec![0.0, 0.001], vec![-250.06 / 1000.0, -0.25], vec![1e5, 2e5]]);
        assert!(found.others.is_empty());
    }

    #[test]
    fn channels_of_other_clocks_are_brought_to_the_chosen_one() {
        let table = table("t;x;u;F\n0;1;5;\n1;2;;10\n2;3;;\n3;4;6;30\n4;5;7;\n");
        let all = [
            chosen("time", 0, "s"),
            chosen("position", 1, "m"),
            chosen("valveVoltage", 2, "V"),
            chosen("force", 3, "N"),
        ];
        let found = table.signals("rig.csv", &all).expect("signals");
        assert_eq!(found.others, ["valveVoltage", "force"]);
        // From the first sample of the force to its last: the voltage is held, the force runs on a line.
        assert_eq!(found.samples, [[1.0, 2.0, 3.0], [2.0, 3.0, 4.0], [5.0, 5.0, 6.0], [10.0, 20.0, 30.0]]);
    }

    #[test]
    fn what_is_wrong_is_named_by_its_place() {
        let refused = |text: &str, unit: &str| {
            let all = [chosen("time", 0, "s"), chosen("position", 1, unit)];
            table(text).signals("rig.csv", &all).expect_err("a refusal").0
        };
        assert_eq!(refused("t;x\n0;1\n\n1;2\n1;3\n", "m"), "rig.csv:5, column t: time must rise, but 1 s follows 1 s");
        assert_eq!(refused("t;x\n0;1\n1;two\n", "m"), "rig.csv:3, column 2 (x): 'two' is no number");
        assert!(refused("t;x\n0;1\n1;2\n", "V").starts_with("rig.csv:1, column 2 (x): the unit V is refused"));
        assert!(refused("t;x\n0;1\n;2\n", "m").contains("column 1 (t): '' is no number"));
        // A table that says volts has no milliamperes.
        let told = refused("t;x [V]\n0;1\n1;2\n", "4..20 mA = 0..500 mm");
        assert!(told.starts_with("rig.csv:1, column 2 (x): the table says V, but"), "{told}");
    }

    #[test]
    fn two_points_calibrate_readings() {
        for header in ["t;x [V]", "t;x", "t;x [0..10 V = 0..500 mm]"] {
            let all = [chosen("time", 0, "s"), chosen("position", 1, "0..10 V = 0..500 mm")];
            let found = table(&format!("{header}\n0;1\n1;2\n")).signals("rig.csv", &all).expect("signals");
            assert_eq!(found.samples[1], [0.05, 0.1], "{header}");
        }
    }

    #[test]
    fn rows_without_a_time_are_points() {
        let table = table("v [mm/s];F\n5;1\n-2;2\n5;3\n");
        let all = [chosen("velocity", 0, "mm/s"), chosen("frictionForce", 1, "N")];
        let found = table.signals("rig.csv", &all).expect("points");
        assert_eq!(found.samples, [[0.005, -0.002, 0.005], [1.0, 2.0, 3.0]]);
    }
}
