//! there must be as many indicators as events

#[macro_use]
#[path = "shared/moving.rs"]
mod shared;

moving!(
    1,
    1,
    Event { name: "end", text: "It arrives", nominal: 1.0 },
    Event { name: "middle", text: "It is half way", nominal: 1.0 }
);
