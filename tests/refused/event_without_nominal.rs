//! the nominal of an event is no positive number

#[macro_use]
#[path = "shared/moving.rs"]
mod shared;

moving!(
    1,
    1,
    Event {
        name: "end",
        text: "It arrives",
        nominal: 0.0,
        indicator: |_, _, x, _, ()| 1.0 - x[0],
        happens: |_, _, _, _, ()| (),
    }
);
