//! Configured FMUs: values from the resources, and what of them is refused.

use std::ffi::CString;
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use pneumatic_servo_fmu::fmi2::types::{CO_SIMULATION, MODEL_EXCHANGE};
use pneumatic_servo_fmu::guid;
use pneumatic_servo_variant::{FILE, LIMIT, guid as guid_of_variant};

use crate::common::fmi3::{Instance3, Way, instantiate_in};
use crate::common::*;

const AXIS: &str = "pneumatic-servo variant 1\nmodel = PneumaticServoCylinder\nname = Axis7\n\
                    inputs = valveVoltage, externalForce\noutputs = position\nparameters = mass.moving\n\n\
                    friction.law = LuGre\nmass.moving = 1.5\nposition0 = 0.1\nsupplyPressure = 650000.0\n";

/// A folder with a file, deleted at the end; blanks in its name are a matter of URIs.
struct Resources(PathBuf);

impl Resources {
    fn with(file: &[u8]) -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("a variant {} {number}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        fs::write(folder.join(FILE), file).expect("a file");
        Self(folder)
    }

    fn uri(&self) -> CString {
        let path = self.0.to_str().expect("UTF-8").replace('\\', "/").replace(' ', "%20");
        CString::new(format!("file:///{}", path.trim_start_matches('/'))).expect("no zero byte")
    }

    fn path(&self) -> CString {
        CString::new(self.0.to_str().expect("UTF-8")).expect("no zero byte")
    }
}

impl Drop for Resources {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn own(file: &[u8]) -> String {
    guid_of_variant(&guid(cylinder()), file)
}

/// The message of a refused instantiation by the GUID that belongs to the file, or by another one.
fn refusal(file: &[u8], guid: Option<&str>) -> String {
    let resources = Resources::with(file);
    let own = own(file);
    let made = Instance::configured(guid.unwrap_or(&own), Some(&resources.uri()), CO_SIMULATION, false);
    let messages = made.err().expect("a refusal");
    let [message] = &messages[..] else { panic!("one message, not {messages:?}") };
    assert_eq!((message.status, &*message.category), (ERROR, "logStatusError"));
    message.text.clone()
}

fn axis(fmu_type: i32) -> Instance {
    let resources = Resources::with(AXIS.as_bytes());
    let made = Instance::configured(&own(AXIS.as_bytes()), Some(&resources.uri()), fmu_type, false);
    made.unwrap_or_else(|messages| panic!("{messages:?}"))
}

/// The same values set one by one in an instance of the model.
fn by_hand() -> Instance {
    let instance = Instance::new();
    assert_eq!(instance.set_integer(&[vr("friction.law")], &[14]), OK);
    let names = ["mass.moving", "position0", "supplyPressure"];
    assert_eq!(instance.set_real(&names.map(vr), &[1.5, 0.1, 6.5e5]), OK);
    instance
}

#[test]
fn run_of_a_variant_is_that_of_the_model_with_its_values_also_after_a_reset() {
    let (variant, model) = (axis(CO_SIMULATION), by_hand());
    model.initialize();
    let expected = model.swing(50);
    for _ in 0..2 {
        variant.initialize();
        assert_eq!(variant.swing(50), expected);
        assert_eq!(variant.reset(), OK);
    }
}

#[test]
fn variant_runs_in_both_versions_and_kinds() {
    assert_eq!(axis(MODEL_EXCHANGE).setup(0.0, None), OK);
    let resources = Resources::with(AXIS.as_bytes());
    let token = CString::new(own(AXIS.as_bytes())).expect("no zero byte");
    for way in [Way::Steps, Way::Events(true), Way::Exchange] {
        let (component, messages) = instantiate_in(way, c"test", &token, Some(&resources.path()));
        assert!(!component.is_null(), "{:?}", messages.lock());
        let instance = Instance3 { component, messages };
        assert_eq!((instance.enter(), instance.exit()), (OK, OK), "{:?}", instance.messages());
        let mut values = [0.0; 2];
        assert_eq!(instance.get(&[vr("position"), vr("mass.moving")], &mut values), OK);
        assert_eq!(values, [0.1, 1.5]);
    }
}

#[test]
fn what_a_variant_has_fixed_cannot_be_set() {
    let variant = axis(CO_SIMULATION);
    assert_eq!(variant.set_real(&[vr("mass.moving"), vr("valveVoltage")], &[2.0, 6.0]), OK);
    for name in ["cylinder.bore", "supplyPressure"] {
        assert_eq!(variant.set_real(&[vr(name)], &[0.03]), ERROR);
        assert!(variant.message().contains(&format!("{name} is fixed in Axis7")));
    }
    assert_eq!(variant.set_real(&[vr("position")], &[0.2]), ERROR);
    assert_eq!(variant.set_real(&[vr("position")], &[0.1]), OK, "the start value of the description");
}

#[test]
fn saved_states_of_another_variant_and_of_the_model_are_refused() {
    let (variant, model) = (axis(CO_SIMULATION), by_hand());
    variant.initialize();
    model.initialize();
    let bytes = |instance: &Instance| instance.serialize(instance.save());
    let (of_variant, of_model) = (bytes(&variant), bytes(&model));
    assert_eq!(variant.deserialize(&of_variant).0, OK);
    assert_eq!([variant.deserialize(&of_model).0, model.deserialize(&of_variant).0], [ERROR; 2]);
}

#[test]
fn damaged_and_foreign_files_are_refused_by_name() {
    let good = AXIS.as_bytes();
    let mut flipped = good.to_vec();
    flipped[AXIS.find("1.5").expect("the mass")] ^= 1;
    for (file, guid) in [(&flipped[..], own(good)), (good, guid(cylinder())), (good, own(b"another"))] {
        let text = refusal(file, Some(&guid));
        assert!(text.contains("resources/variant.txt is refused: Axis7") && text.contains(&guid), "{text}");
    }
    let missing = Instance::configured(&own(good), None, CO_SIMULATION, false).err().expect("a refusal");
    assert!(missing[0].text.contains("the resources of a configured FMU"), "{missing:?}");
}

/// Files with a right GUID, as somebody may make them.
#[test]
fn hostile_files_are_refused_by_line_or_name() {
    let with = |line: &str| format!("{AXIS}{line}\n");
    for (file, reason) in [
        (with(&"x".repeat(LIMIT)), "more than 1048576 bytes"),
        (with("mass.moving = 2"), "mass.moving has a value already"),
        (with("cylinder.bore = -0.03"), "cylinder.bore = -0.03 is refused"),
        (with("cylinder.bore = 1e999"), "cylinder.bore = inf is refused"),
        (with("cylinder.bore = true"), "it must be a number in m"),
        (with("friction.lugre.sigma = 1"), "there is no variable friction.lugre.sigma"),
        (AXIS.replace("PneumaticServoCylinder", "Else"), "this library has no model Else"),
        (AXIS.replace("position\n", "position, position\n"), "position is listed twice"),
        (String::new(), "its first line"),
    ] {
        let text = refusal(file.as_bytes(), None);
        assert!(text.contains("resources/variant.txt is refused") && text.contains(reason), "{text}");
    }
    assert!(refusal(b"pneumatic-servo variant 1\n\xff", None).contains("UTF-8"));
}
