//! two events have the same name

#[macro_use]
#[path = "shared/moving.rs"]
mod shared;

moving!(
    1,
    2,
    Event { name: "end", text: "It arrives", nominal: 1.0 },
    Event { name: "end", text: "It arrives", nominal: 1.0 }
);
