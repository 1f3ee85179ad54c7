//! The model without a mistake.

#[macro_use]
#[path = "moving.rs"]
mod shared;

moving!(1, 1, Event { name: "end", text: "It arrives", nominal: 1.0 });
