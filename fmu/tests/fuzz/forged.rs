//! Saved states that somebody has changed and given a checksum that fits.

use crc::{CRC_32_ISO_HDLC, Crc};
use pneumatic_servo::friction::LAWS;

use crate::common::{ERROR, Instance, OK, is_input, is_real};
use crate::random::Random;
use crate::{MODEL, SOLVER_STEPS, limit, variables};

/// Where the content begins: behind magic, version and length.
const CONTENT_AT: usize = 20;
const LENGTH_AT: usize = 12;
const CHECKSUM: usize = size_of::<u32>();

/// Forges a state of a running instance and restores it. It may be refused or lead to values that nobody computed, but the
/// instance stays whole: no internal error, and the honest state brings everything back.
pub fn restore(random: &mut Random) {
    let instance = running(random);
    let honest = instance.fingerprint();
    let forged = forge(&honest, random);
    let (status, mut state) = instance.deserialize(&forged);
    assert!(status == OK || status == ERROR, "deserializing returned {status}: {:?}", instance.messages());
    assert_eq!(state.is_null(), status == ERROR);
    if status == ERROR {
        return;
    }
    let restored = instance.restore(state);
    assert!(restored == OK || restored == ERROR, "restoring returned {restored}: {:?}", instance.messages());
    if restored == OK {
        go_on(&instance, random);
    }
    assert_eq!(instance.forget(&mut state), OK);
    let (status, state) = instance.deserialize(&honest);
    assert_eq!((status, instance.restore(state)), (OK, OK), "{:?}", instance.messages());
    assert!(instance.fingerprint() == honest, "the honest state is another one now");
}

/// An instance of either kind, somewhere in a run under some law.
fn running(random: &mut Random) -> Instance {
    let model = MODEL.get();
    let exchanges = random.one_in(2);
    let instance = if exchanges { Instance::for_exchange(model) } else { Instance::of(model) };
    assert_eq!(instance.set_integer(&[limit().reference], &[SOLVER_STEPS]), OK);
    if let Some(found) = model.table().find("friction.law") {
        let law = LAWS.items[random.below(LAWS.items.len())].0;
        assert_eq!(instance.set_integer(&[found.variable.reference], &[law]), OK);
    }
    instance.initialize();
    if !exchanges {
        (0..random.below(4)).for_each(|index| _ = instance.step(1e-3 * index as f64, 1e-3));
    }
    instance
}

/// Bytes of which a few are others, with the length and the checksum that fit.
fn forge(honest: &[u8], random: &mut Random) -> Vec<u8> {
    let mut content = honest[CONTENT_AT..honest.len() - CHECKSUM].to_vec();
    // Zeros follow what is written.
    let written = content.iter().rposition(|byte| *byte != 0).map_or(1, |last| last + 1);
    for _ in 0..=random.below(4) {
        // The names and numbers of the record come first, the states of the model last: as often the one as the other.
        let from = if random.one_in(2) { 0 } else { written.saturating_sub(300) };
        let place = from + random.below(written - from);
        match random.below(4) {
            0 => content[place] = random.below(256) as u8,
            1 => content.insert(place, random.below(256) as u8),
            2 => _ = content.remove(place),
            _ => {
                let number = random.number().to_le_bytes();
                let room = number.len().min(content.len() - place);
                content[place..place + room].copy_from_slice(&number[..room]);
            }
        }
    }
    let checksum = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&content);
    let mut forged = [&honest[..CONTENT_AT], &content, &checksum.to_le_bytes()].concat();
    let length = forged.len() as u64;
    forged[LENGTH_AT..CONTENT_AT].copy_from_slice(&length.to_le_bytes());
    forged
}

/// Reads everything, steps, and reads again; nothing of it may end in an internal error.
fn go_on(instance: &Instance, random: &mut Random) {
    let reals: Vec<_> = variables().iter().filter(|it| is_real(it)).map(|it| it.reference).collect();
    let inputs: Vec<_> = variables().iter().filter(|it| is_input(it)).collect();
    let mut values = vec![0.0; reals.len()];
    for _ in 0..3 {
        let mut time = [0.0];
        let statuses = [
            instance.get_real(&reals, &mut values),
            inputs.first().map_or(OK, |it| instance.set_real(&[it.reference], &[random.value_for(it)])),
            instance.get_real(&[0], &mut time),
            instance.step(time[0], 1e-3),
        ];
        for status in statuses {
            assert!((0..=ERROR).contains(&status), "returned {status}: {:?}", instance.messages());
        }
    }
}
