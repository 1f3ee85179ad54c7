//! an event does not say in words what happens

#[macro_use]
#[path = "shared/moving.rs"]
mod shared;

moving!(1, 1, Event { name: "end", text: "", nominal: 1.0 });
