//! Memory that is asked for before it is needed, since a failed allocation ends the process.

use crate::failure::Failure;

/// More bytes than an instance takes with its run, and the first one with the table of its model.
const ROOM: usize = 2 << 20;

/// Refuses to go on where the system does not grant the memory of an instance. Not asked of WebAssembly, and of the sources in
/// C made of it: a memory that has grown there never shrinks.
pub fn check_room() -> Result<(), Failure> {
    if cfg!(target_family = "wasm") {
        return Ok(());
    }
    let mut room: Vec<u8> = Vec::new();
    let granted = room.try_reserve_exact(ROOM);
    // Unused memory, whose request an optimiser may otherwise leave out.
    std::hint::black_box(&room);
    granted
        .map_err(|_| Failure::error(format!("the system does not grant the {ROOM} bytes of memory that this may take")))
}
