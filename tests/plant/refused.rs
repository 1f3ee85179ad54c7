//! Mistakes in the macros and tables of users' laws and models: the compiler refuses them, and says what is wrong.
//!
//! Each file in `tests/refused` begins with what the message says. They are looked at in a crate of its own, as a stranger's is.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const HOME: &str = env!("CARGO_MANIFEST_DIR");

/// Files with mistakes, by name, with the message that each expects.
fn cases() -> Vec<(String, String, PathBuf)> {
    let folder = Path::new(HOME).join("tests/refused");
    let files = fs::read_dir(folder).expect("the folder of mistakes").map(|entry| entry.expect("an entry").path());
    let case = |file: PathBuf| {
        let name = file.file_stem().and_then(|name| name.to_str()).expect("a name").to_owned();
        let text = fs::read_to_string(&file).expect("a readable file");
        let expected = text.strip_prefix("//! ").and_then(|text| text.lines().next()).expect("what is expected");
        (name, expected.to_owned(), file)
    };
    files.filter(|file| file.extension().is_some_and(|it| it == "rs")).map(case).collect()
}

#[test]
fn compiler_refuses_mistakes_and_says_what_is_wrong() {
    let cases = cases();
    assert!(cases.len() >= 11, "{} files", cases.len());
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("refused");
    fs::create_dir_all(&folder).expect("a folder");
    let mut manifest = format!(
        "[package]\nname = \"refused\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[workspace]\n\n[dependencies]\n\
         pneumatic-servo = {{ path = {HOME:?} }}\n"
    );
    for (name, _, file) in &cases {
        manifest += &format!("\n[[bin]]\nname = {name:?}\npath = {file:?}\n");
    }
    // The same model without a mistake, so that it is the mistakes that are refused.
    let sound = Path::new(HOME).join("tests/refused/shared/sound.rs");
    manifest += &format!("\n[[bin]]\nname = \"sound\"\npath = {sound:?}\n");
    fs::write(folder.join("Cargo.toml"), manifest).expect("a manifest");
    fs::copy(Path::new(HOME).join("Cargo.lock"), folder.join("Cargo.lock")).expect("the lock file");
    let check = |name: &str| {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.args(["check", "--offline", "--quiet", "--color", "never", "--bin", name]).current_dir(&folder);
        cargo.env("CARGO_TARGET_DIR", folder.join("target")).env_remove("RUSTFLAGS");
        let output = cargo.output().expect("Cargo");
        (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (passes, messages) = check("sound");
    assert!(passes, "{messages}");
    for (name, expected, _) in &cases {
        let (passes, messages) = check(name);
        assert!(!passes, "{name} is not refused");
        assert!(messages.contains(expected), "{name}: not \"{expected}\", but\n{messages}");
        assert!(!messages.contains("no rules expected"), "{name} is refused by the form of a macro alone:\n{messages}");
    }
}

mod at_the_start {
    use std::cell::Cell;

    use pneumatic_servo::conformance::law::benched;
    use pneumatic_servo::prelude::*;
    use pneumatic_servo::system::Indicator;
    use pneumatic_servo::variables::forget_tables;

    parameters! {
        /// None.
        Parameters {}
    }

    parameters! {
        /// One.
        Own {
            stiffness: f64 = Variable::parameter(20, "k", units::NEWTON_PER_METRE, 1.0);
        }
    }

    states! {
        /// A position.
        State of Moving {
            Position: 10, |moving| moving.magnitude;
        }
    }

    outputs! {
        /// The position and its rate.
        Outputs {
            position = Variable::output(10, "position", units::METRE).depends_on(&[10]).text("Position");
            velocity = Variable::output(11, "velocity", units::METRE_PER_SECOND).derivative_of(10).text("Velocity");
        }
    }

    /// A body that moves at 1 m/s.
    #[derive(Clone, Copy, Debug)]
    struct Moving {
        magnitude: f64,
    }

    /// The same with a fault in its tables.
    #[derive(Clone, Debug)]
    struct Faulty(Moving);

    thread_local! {
        /// The fault: a type for each would be compiled with a solver of its own.
        static FAULT: Cell<usize> = const { Cell::new(SOUND) };
    }

    /// A faulty change, and the message about it.
    type Fault = (fn(&mut Tables), &'static str);

    const FAULTS: &[Fault] = &[
        (
            |tables| tables.computed.push(Variable::output(11, "speed", units::METRE_PER_SECOND)),
            "velocity = 11 is refused: the value reference 11 of velocity is taken by speed",
        ),
        (
            |tables| tables.computed.push(Variable::output(5001, "gain", units::ONE)),
            "gain = 5001 is refused: the value reference 5001 of gain is taken by solver.relativeTolerance",
        ),
        (
            |tables| tables.parameters.push(Variable::parameter(5100, "gain", units::ONE, 1.0)),
            "gain = 5100 is refused: the value reference 5100 of gain is taken by solver.steps",
        ),
        (
            |tables| tables.computed[1].depends_on = Some(vec![77]),
            "no variable has the value reference 77, on which velocity depends",
        ),
        (
            |tables| tables.computed[0].starts_from = vec![78],
            "no variable has the value reference 78, on which position depends",
        ),
        (
            |tables| tables.computed.push(Variable::output(12, "velocity", units::METRE_PER_SECOND)),
            "velocity = 12 is refused: two variables have the name velocity",
        ),
        (
            |tables| tables.parameters.extend(elements().into_iter().rev()),
            "k[2] = 21 is refused: it does not follow the other elements of its array",
        ),
        (
            |tables| tables.parameters.extend(elements().map(|it| Variable { reference: 2 * it.reference, ..it })),
            "k[2] = 42 is refused: it does not follow the other elements of its array",
        ),
        (
            |tables| tables.parameters.extend(elements()),
            "parameters = 2 is refused: the equations do not read this number of values of the table",
        ),
        (
            |tables| tables.computed[1].reference = u32::MAX,
            "velocity = 4294967295 is refused: value references go up to 10000000",
        ),
        (
            |tables| tables.computed[1].derivative_of = None,
            "the value reference = 10 is refused: no variable is the derivative of this state",
        ),
        (
            |tables| tables.computed.push(Variable::output(12, "rate", units::METRE_PER_SECOND).derivative_of(10)),
            "rate = 12 is refused: another variable is the derivative of the same state",
        ),
        (
            |tables| {
                tables.inputs.push(Variable::input(1, "force", units::NEWTON, 0.0));
                tables.computed[1].derivative_of = Some(1);
            },
            "velocity = 11 is refused: force is not computed, and has no derivative",
        ),
        (
            |tables| tables.inputs.push(Variable::input(1, "force", units::NEWTON, 0.0)),
            "inputs = 1 is refused: the equations have 0, not this number of the table",
        ),
        (
            |tables| tables.inputs.push(Variable::output(1, "force", units::NEWTON)),
            "force = 1 is refused: it is among the inputs, but none of them",
        ),
        (
            |tables| tables.computed.push(Variable::parameter(1, "mass", units::KILOGRAM, 1.0)),
            "mass = 1 is refused: it is among the computed variables, but none of them",
        ),
        (
            |tables| tables.computed.push(Variable::output(12, "speed", units::METRE_PER_SECOND)),
            "computed variables = 3 is refused: the equations write 2 of this number in the table",
        ),
        (
            |tables| tables.parameters.push(Variable::parameter(20, "k", units::ONE, 1.0).counts_for(10, 3)),
            "k = 20 is refused: no variable with the value reference 10 has an item 3 to choose, for which k counts",
        ),
        (
            |tables| tables.parameters.push(Variable::parameter(20, "k", units::ONE, 3.0).range(0.0, 2.0)),
            "k = 3 is refused: as the default of k, it must be at most 2",
        ),
        (
            |tables| tables.computed.truncate(0),
            "the value reference = 10 is refused: no variable is the derivative of this state",
        ),
        (|_| (), "the magnitude of position = 0 is refused: it must be a positive number"),
        (|_| (), "parameters = 1 is refused: the equations read this number of values beyond the end of the table"),
        (|_| (), "indicators = 0 is refused: the list of events has 1, the equations this number"),
        (|_| (), "kinks = 7 is refused: there may be 6"),
    ];

    const SOUND: usize = FAULTS.len();
    const KINKED: usize = SOUND - 1;
    const TOLD: usize = SOUND - 2;
    const GREEDY: usize = SOUND - 3;
    const WITHOUT_MAGNITUDE: usize = SOUND - 4;

    fn told(count: usize) -> Vec<Indicator> {
        vec![Indicator { name: "end".to_owned(), nominal: 1.0, text: "It arrives" }; count]
    }

    fn elements() -> [Variable; 2] {
        Variable::parameter(20, "k", units::NEWTON_PER_METRE, 1.0).array([1.0, 2.0])
    }

    impl System<0> for Faulty {
        type Parameters = Moving;
        type State = State;
        type Memory<S: Varying> = ();
        type Indicators<S: Varying> = [S; 0];

        fn tables() -> Tables {
            let (inputs, computed, parameters) = (Vec::new(), Outputs::<f64>::table(), Parameters::table());
            let mut tables = Tables { inputs, computed, parameters };
            if let Some((spoil, _)) = FAULTS.get(FAULT.get()) {
                spoil(&mut tables);
            }
            tables
        }

        fn new(values: &mut Values) -> Result<Self, ParameterError> {
            if FAULT.get() == GREEDY {
                values.read::<Own>()?;
            }
            Ok(Self(Moving { magnitude: if FAULT.get() == WITHOUT_MAGNITUDE { 0.0 } else { 1.0 } }))
        }

        fn parameters(&self) -> &Moving {
            &self.0
        }

        fn indicator_list() -> Vec<Indicator> {
            told(usize::from(FAULT.get() == TOLD))
        }

        fn kink_list() -> Vec<Indicator> {
            told(if FAULT.get() == KINKED { 7 } else { 0 })
        }

        fn start<S: Varying, const N: usize>(&self, _u: &[S; 0]) -> ([S; N], ()) {
            ([S::zero(); N], ())
        }

        fn derivatives<S: Scalar, const N: usize>(&self, _time: S, _x: &[S; N], _u: &[S; 0], _memory: &()) -> [S; N] {
            [S::constant(1.0); N]
        }

        fn outputs<S: Scalar, const N: usize>(
            &self,
            _time: S,
            x: &[S; N],
            _u: &[S; 0],
            _memory: &(),
            computed: &mut [S],
        ) {
            Outputs { position: State::Position.get(x), velocity: S::constant(1.0) }.write(computed);
        }
    }

    static MODEL: Model = Model::of::<Faulty, 0, 1>(
        "Faulty",
        "What moves at 1 m/s",
        Experiment { stop_time: 1.0, step_size: 0.1, signals: &[], panels: &[] },
    );

    #[test]
    fn faults_of_tables_and_states_without_magnitude_are_refused_by_name() -> Result<(), Box<dyn std::error::Error>> {
        for (fault, (_, expected)) in FAULTS.iter().enumerate() {
            FAULT.set(fault);
            // Another thread may be making a table.
            while !forget_tables() {}
            let refused = Setup::new(&MODEL).start(0.0).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(refused.contains(expected), "{refused}, not {expected}");
        }
        FAULT.set(SOUND);
        while !forget_tables() {}
        let mut plant = Setup::new(&MODEL).start(0.0)?;
        plant.advance_to(0.5)?;
        assert!((plant.get("position")? - 0.5).abs() < 1e-12);
        Ok(())
    }

    parameters! {
        /// A law with more states than fit.
        Greedy {
            stiffness: Tunable = Variable::parameter(0, "k", units::NEWTON_PER_METRE, 1.0).text("Stiffness");
        }
    }

    impl FrictionLaw for Greedy {
        type Memory<S: Varying> = ();

        fn states(&self) -> usize {
            11
        }

        fn start<S: Varying>(&self, _contact: &Contact<S>) {}

        fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], _memory: &(), _rates: &mut [S]) -> S {
            contact.position * self.stiffness
        }
    }

    parameters! {
        /// A law that has more states than it names.
        Secretive {
            stiffness: Tunable = Variable::parameter(0, "k", units::NEWTON_PER_METRE, 1.0).text("Stiffness");
        }
    }

    impl FrictionLaw for Secretive {
        type Memory<S: Varying> = ();

        const STATES: &'static [LawState<Self>] = &[LawState::new("shown", units::METRE, |_| 1.0)];

        fn states(&self) -> usize {
            2
        }

        fn start<S: Varying>(&self, _contact: &Contact<S>) {}

        fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], _memory: &(), _rates: &mut [S]) -> S {
            contact.position * self.stiffness
        }
    }

    laws! {
        /// Both beside the laws of the library.
        mod catalogue {
            ..builtin;
            1000 Greedy "greedy" Greedy, "More states than fit";
            1001 Secretive "secretive" Secretive, "More states than it names";
        }
    }

    #[test]
    fn laws_with_other_states_than_fit_or_have_names_are_refused() {
        let cases = [
            ("Greedy", "friction.greedy.states = 11 is refused: a law may have 1 state of the kind Deflection, or 10"),
            ("Secretive", "friction.secretive.states = 2 is refused: the law names 1 states"),
        ];
        for (law, expected) in cases {
            let setup = benched::<catalogue::Friction>(law, "Free");
            let refused = setup.start(0.0).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(refused.starts_with(expected), "{refused}");
        }
    }
}
