//! an event has no name

#[macro_use]
#[path = "shared/moving.rs"]
mod shared;

moving!(1, 1, Event { name: "", text: "It arrives", nominal: 1.0 });
