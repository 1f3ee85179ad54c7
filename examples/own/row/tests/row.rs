//! The row of blocks under each law: its first motion, and the promises of every model.

use own_row::MODEL;
use pneumatic_servo::conformance;
use pneumatic_servo::model::Setup;

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn under(law: &str) -> Result<Setup, Box<dyn std::error::Error>> {
    Ok(Setup::new(&MODEL).set("friction.law", law)?)
}

/// The promises in stick-slip and in sliding.
fn keeps_promises(law: &str) -> Outcome {
    for velocity in [0.02, 0.2] {
        conformance::run(&under(law)?.set("driveVelocity", velocity)?);
    }
    Ok(())
}

#[test]
fn row_keeps_what_models_promise_under_a_set_valued_law() -> Outcome {
    keeps_promises("Stribeck")
}

#[test]
fn row_keeps_what_models_promise_under_a_bristle() -> Outcome {
    keeps_promises("LuGre")
}

#[test]
fn row_keeps_what_models_promise_under_elements() -> Outcome {
    keeps_promises("GMS")
}

/// The drive pulls the second block with `k*u*t` until friction yields; the first one has not moved by a bit.
#[test]
fn blocks_stick_until_the_spring_overcomes_static_friction() -> Outcome {
    let mut row = under("Stribeck")?.start(0.0)?;
    let yields = row.get("friction.stribeck.Fs")? / (5e3 * 0.02);
    row.advance_to(0.999 * yields)?;
    assert_eq!([row.get("block[1].position")?, row.get("block[2].position")?], [0.0; 2]);
    row.advance_to(1.001 * yields)?;
    assert_eq!(row.get("block[1].position")?, 0.0);
    assert!(row.get("block[2].position")? > 0.0);
    Ok(())
}

#[test]
fn law_with_more_states_than_there_is_room_for_is_refused_by_name() -> Outcome {
    let refused = under("GMS")?.set("friction.gms.N", 5)?.start(0.0).err().map(|error| error.to_string());
    assert_eq!(refused.as_deref(), Some("states = 5 is refused: the friction law may have 4"));
    Ok(())
}
