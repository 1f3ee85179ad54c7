//! the nominal of an event is no positive number

#[macro_use]
#[path = "shared/moving.rs"]
mod shared;

moving!(1, 1, Event { name: "end", text: "It arrives", nominal: 0.0 });
