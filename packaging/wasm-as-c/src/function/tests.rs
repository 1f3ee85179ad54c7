use anyhow::ensure;
use wasmparser::BinaryReader;

use super::*;

/// A function beside an imported one without arguments, of number 0, and one that takes a number, of number 2. There are two global
/// variables and a memory of one page; the code begins with the local variables.
fn function(parameters: &[Type], result: Option<Type>, code: &[&[u8]]) -> Result<Function> {
    let code = [&code.concat(), END].concat();
    let signatures = [
        Signature { parameters: parameters.to_vec(), result },
        Signature { parameters: Vec::new(), result: Some(Type::I32) },
        Signature { parameters: vec![Type::F64], result: None },
    ];
    let surroundings = Surroundings {
        functions: &[1, 0, 2],
        imports: &["host".to_owned()],
        signatures: &signatures,
        globals: &[Type::I32, Type::F64],
        memory: 65_536,
        margin: 16_384,
    };
    translate(&FunctionBody::new(BinaryReader::new(&code, 0)), 1, &surroundings)
}

fn lines_of(parameters: &[Type], result: Option<Type>, code: &[&[u8]]) -> Result<Vec<String>> {
    Ok(function(parameters, result, code)?.text.lines().map(str::to_owned).collect())
}

/// The lines of a function of one address.
fn lines(operators: &[&[u8]]) -> Result<Vec<String>> {
    lines_of(&[Type::I32], None, &[NO_LOCALS, &operators.concat()])
}

/// The lines between the head and the last brace of a function that takes a number and returns one of the same type.
fn inner(of: Type, operators: &[&[u8]]) -> Result<Vec<String>> {
    let mut text = lines_of(&[of], Some(of), &[NO_LOCALS, &operators.concat()])?;
    ensure!(text.pop().as_deref() == Some("}"), "no end");
    Ok(text.split_off(1))
}

/// Statements that compare an address with the bounds.
fn comparisons(operators: &[&[u8]]) -> Result<Vec<String>> {
    Ok(lines(operators)?.into_iter().filter(|line| line.starts_with("within(")).collect())
}

const NO_LOCALS: &[u8] = &[0];
const ADDRESS: &[u8] = &[0x20, 0];
const LOAD: &[u8] = &[0x2b, 3, 0, 0x1a];
const LOAD_AT_16: &[u8] = &[0x2b, 3, 16, 0x1a];
const LOAD_AT_16368: &[u8] = &[0x2b, 3, 0xf0, 0x7f, 0x1a];
const LOAD_AT_20000: &[u8] = &[0x2b, 3, 0xa0, 0x9c, 0x01, 0x1a];
const PLUS_16: &[u8] = &[0x41, 16, 0x6a];
const SET: &[u8] = &[0x21, 0];
const COPY: &[u8] = &[0xfc, 10, 0, 0];
const CHANGE: &[u8] = &[0x41, 1, 0x21, 0];
const BLOCK: &[u8] = &[0x02, 0x40];
const LOOP: &[u8] = &[0x03, 0x40];
const IF: &[u8] = &[0x20, 0, 0x04, 0x40];
const ELSE: &[u8] = &[0x05];
const LEAVE_IF: &[u8] = &[0x20, 0, 0x0d, 0];
const END: &[u8] = &[0x0b];

#[test]
fn an_address_is_compared_once_until_it_changes() -> Result<()> {
    let once = ["within(l0,8u);"];
    assert_eq!(comparisons(&[ADDRESS, LOAD, ADDRESS, LOAD_AT_16])?, once);
    let again = ["within(l0,8u);", "within(l0,24u);"];
    assert_eq!(comparisons(&[ADDRESS, LOAD, CHANGE, ADDRESS, LOAD_AT_16])?, again);
    // An access far from the address; a constant address inside and outside the memory.
    assert_eq!(comparisons(&[ADDRESS, LOAD, ADDRESS, LOAD_AT_20000])?, ["within(l0,8u);", "within(l0,20008u);"]);
    assert_eq!(comparisons(&[&[0x41, 8], LOAD])?, [""; 0]);
    assert_eq!(comparisons(&[&[0x41, 0x7c], LOAD])?, ["within(4294967292u,8u);"]);
    Ok(())
}

#[test]
fn sums_of_an_address_and_a_number_are_known_as_far_as_the_margin() -> Result<()> {
    let once = ["within(l0,8u);"];
    assert_eq!(comparisons(&[ADDRESS, LOAD, ADDRESS, PLUS_16, LOAD])?, once);
    assert_eq!(comparisons(&[ADDRESS, LOAD, ADDRESS, PLUS_16, SET, ADDRESS, LOAD_AT_16])?, once);
    // The last byte of the margin, and one that is beyond it by 8, and a number that is no small one.
    assert_eq!(comparisons(&[ADDRESS, LOAD, ADDRESS, LOAD_AT_16368])?, once);
    let far = [ADDRESS, LOAD, ADDRESS, PLUS_16, SET, ADDRESS, LOAD_AT_16368];
    assert_eq!(comparisons(&far)?, ["within(l0,8u);", "within(l0,16376u);"]);
    let below = comparisons(&[ADDRESS, LOAD, ADDRESS, &[0x41, 0x70, 0x6a], LOAD])?;
    assert_eq!(below, ["within(l0,8u);", "within(i0,8u);"]);
    // Bounds of an address are lost when it changes.
    assert_eq!(comparisons(&[ADDRESS, PLUS_16, SET, ADDRESS, LOAD])?, once);
    Ok(())
}

#[test]
fn copying_and_filling_of_a_known_size_compares_as_other_accesses_do() -> Result<()> {
    let of = |from: &[u8], size: &[u8]| lines(&[ADDRESS, from, size, COPY]);
    let small = of(&[0x20, 0, 0x41, 16, 0x6a], &[0x41, 40])?;
    assert_eq!(small[2..4], ["within(l0,40u);", "copy_known(m,l0,(l0+16u),40u);"]);
    let filled = lines(&[ADDRESS, &[0x41, 0, 0x41, 40, 0xfc, 11, 0]])?;
    assert_eq!(filled[2..4], ["within(l0,40u);", "fill_known(m,l0,0u,40u);"]);
    // A size of 20,000 bytes, and one that is not known.
    assert_eq!(of(ADDRESS, &[0x41, 0xa0, 0x9c, 0x01])?[1], "copy(s,l0,l0,20000u);");
    assert_eq!(of(ADDRESS, ADDRESS)?[1], "copy(s,l0,l0,l0);");
    Ok(())
}

#[test]
fn an_address_is_compared_again_where_a_path_comes_in_that_did_not_or_changed_it() -> Result<()> {
    let twice = ["within(l0,8u);", "within(l0,24u);"];
    let of = |before: &[&[u8]]| comparisons(&[&before.concat(), ADDRESS, LOAD_AT_16]);
    assert_eq!(of(&[BLOCK, LEAVE_IF, ADDRESS, LOAD, END])?, twice);
    assert_eq!(of(&[ADDRESS, LOAD, BLOCK, LEAVE_IF, CHANGE, END])?, twice);
    assert_eq!(of(&[IF, ADDRESS, LOAD, END])?, twice);
    assert_eq!(of(&[ADDRESS, LOAD, IF, CHANGE, END])?, twice);
    assert_eq!(of(&[IF, ADDRESS, LOAD, ELSE, END])?, twice);
    assert_eq!(of(&[IF, ELSE, ADDRESS, LOAD, END])?, twice);
    // Comparisons in the first part do not count in the second.
    assert_eq!(comparisons(&[IF, ADDRESS, LOAD, ELSE, ADDRESS, LOAD_AT_16, END])?, twice);
    assert_eq!(comparisons(&[ADDRESS, LOAD, IF, ELSE, ADDRESS, LOAD_AT_16, END])?, twice[..1]);
    // A loop comes back to its begin, and ends behind its last statement.
    assert_eq!(comparisons(&[ADDRESS, LOAD, LOOP, ADDRESS, LOAD_AT_16, CHANGE, LEAVE_IF, END])?, twice);
    assert_eq!(of(&[ADDRESS, LOAD, LOOP, CHANGE, END])?, twice);
    // Nothing changes it on these.
    let once = ["within(l0,8u);"];
    assert_eq!(of(&[ADDRESS, LOAD, BLOCK, LEAVE_IF, END])?, once);
    assert_eq!(of(&[ADDRESS, LOAD, IF, ELSE, END])?, once);
    assert_eq!(of(&[ADDRESS, LOAD, LOOP, LEAVE_IF, END])?, once);
    assert_eq!(of(&[LOOP, ADDRESS, LOAD, LEAVE_IF, END])?, once);
    assert_eq!(of(&[BLOCK, ADDRESS, LOAD, END])?, once);
    Ok(())
}

const DEAD: &[u8] = &[0x00];

/// Code behind a trap is unreachable until the end of its block, inner blocks included.
#[test]
fn what_is_never_reached_is_left_out_with_the_blocks_within() -> Result<()> {
    let alive = lines(&[BLOCK, LEAVE_IF, DEAD, END, ADDRESS, LOAD])?;
    assert!(alive.iter().any(|line| line.starts_with("within(l0,")), "{alive:?}");
    for dead in [&[BLOCK, END][..], &[LOOP, BLOCK, END, END], &[IF, ELSE, END], &[BLOCK, END, BLOCK, END]] {
        let nested = [&[BLOCK, LEAVE_IF, DEAD][..], dead, &[END, ADDRESS, LOAD]].concat();
        assert_eq!(lines(&nested)?, alive);
    }
    Ok(())
}

#[test]
fn branches_lead_to_the_end_of_the_block_that_they_count_to() -> Result<()> {
    let to = |depth: u8| lines(&[BLOCK, BLOCK, &[0x20, 0, 0x0d, depth], END, CHANGE, END, ADDRESS, LOAD]);
    let place = |text: &[String], what: &str| text.iter().position(|line| line.contains(what));
    for (depth, is_after_change) in [(0, false), (1, true)] {
        let text = to(depth)?;
        let label = text.iter().find_map(|line| line.split("goto ").nth(1)?.split(';').next()).context("no branch")?;
        let end = place(&text, &format!("{label}:")).context("no label")?;
        let change = place(&text, "l0=1u;").context("no change")?;
        assert_eq!(end > change, is_after_change, "{text:?}");
    }
    let problem = lines(&[BLOCK, &[0x0c, 7], END]).err().map(|error| format!("{error:#}")).unwrap_or_default();
    assert!(problem.contains("a branch out of the function"), "{problem}");
    Ok(())
}

/// Numbers of 64 bits are written with all their bits, as unsigned ones.
#[test]
fn constants_have_all_their_bits() -> Result<()> {
    for (bytes, expected) in [(0x05, "5ull"), (0x7f, "18446744073709551615ull")] {
        let text = lines(&[ADDRESS, &[0x42, bytes], &[0x37, 3, 0]])?;
        assert!(text.iter().any(|line| line.contains(expected)), "{text:?}");
    }
    Ok(())
}

const RETURN: &[u8] = &[0x0f];

#[test]
fn a_return_ends_the_function_however_deep_it_is() -> Result<()> {
    let text = lines(&[IF, RETURN, END, CHANGE])?;
    assert_eq!(text[1..], ["if(l0){", "return;", "}", "l0=1u;", "}"]);
    let deep = lines(&[BLOCK, LOOP, IF, RETURN, END, END, END, CHANGE])?;
    assert_eq!(deep, text);
    Ok(())
}

#[test]
fn a_choice_has_both_its_parts() -> Result<()> {
    const OTHER: &[u8] = &[0x41, 2, 0x21, 0];
    assert_eq!(lines(&[IF, CHANGE, ELSE, OTHER, END])?[1..], ["if(l0){", "l0=1u;", "}else{", "l0=2u;", "}", "}"]);
    // The second part is reached also where the first one leaves.
    assert_eq!(lines(&[IF, RETURN, ELSE, OTHER, END])?[1..], ["if(l0){", "return;", "}else{", "l0=2u;", "}", "}"]);
    Ok(())
}

/// The function at place 3 of the table, with the signature 0.
#[test]
fn a_function_of_the_table_is_called_with_its_arguments() -> Result<()> {
    let call = |table| lines(&[ADDRESS, &[0x41, 3, 0x11, 0, table]]);
    assert_eq!(call(0)?[1..], ["((t0)entry(s,0u,3u))(s,l0);", "}"]);
    assert!(call(1).is_err(), "there is one table");
    Ok(())
}

/// Operators by their bytes; the first argument is a local variable.
const GET: &[u8] = &[0x20, 0];
const ONE: &[u8] = &[0x41, 1];
const FIVE: &[u8] = &[0x41, 5];
const TEE: &[u8] = &[0x22, 0];
const DROP: &[u8] = &[0x1a];
const ADD: &[u8] = &[0x6a];
const EQZ: &[u8] = &[0x45];
const GET_GLOBAL: &[u8] = &[0x23, 0];
const SET_GLOBAL: &[u8] = &[0x24, 0];
const CALL_HOST: &[u8] = &[0x10, 0];
const BLOCK_I32: &[u8] = &[0x02, 0x7f];
const GROW: &[u8] = &[0x40, 0];
const SIZE: &[u8] = &[0x3f, 0];
/// At 8 bytes from the start of memory.
const LOAD_8: &[u8] = &[0x41, 8, 0x28, 2, 0];
const STORE_8: &[u8] = &[0x41, 8, 0x41, 1, 0x36, 2, 0];

/// Values on the stack are kept when a local or global variable, the memory or its size changes.
#[test]
fn values_are_computed_before_what_they_depend_on_changes() -> Result<()> {
    assert_eq!(inner(Type::I32, &[GET, CHANGE])?, ["u32 i0;", "i0=l0;", "l0=1u;", "return i0;"]);
    let sum = [GET, FIVE, ADD, CHANGE];
    assert_eq!(inner(Type::I32, &sum)?, ["u32 i0;", "i0=(l0+5u);", "l0=1u;", "return i0;"]);
    let global = [GET_GLOBAL, ONE, SET_GLOBAL];
    assert_eq!(inner(Type::I32, &global)?, ["u32 i0;", "i0=s->g0;", "s->g0=1u;", "return i0;"]);
    let of_global = [GET_GLOBAL, FIVE, ADD, ONE, SET_GLOBAL];
    assert_eq!(inner(Type::I32, &of_global)?, ["u32 i0;", "i0=(s->g0+5u);", "s->g0=1u;", "return i0;"]);
    let memory = ["u8*const m=s->memory;", "u32 i0;", "i0=li(m,8u,0u);", "si(m,8u,0u,1u);", "return i0;"];
    assert_eq!(inner(Type::I32, &[LOAD_8, STORE_8])?, memory);
    let size = ["u32 i0,i1;", "i0=s->pages;", "i1=grow(s,1u);", "return i0;"];
    assert_eq!(inner(Type::I32, &[SIZE, ONE, GROW, DROP])?, size);
    let call = ["u32 i0,i1;", "i0=s->g0;", "i1=host(s);", "return (i0+i1);"];
    assert_eq!(inner(Type::I32, &[GET_GLOBAL, CALL_HOST, ADD])?, call);
    let copied = inner(Type::I32, &[LOAD_8, ONE, ONE, GET, COPY])?;
    assert_eq!(copied[1..], ["u32 i0;", "i0=li(m,8u,0u);", "copy(s,1u,1u,l0);", "return i0;"]);
    Ok(())
}

/// Independent expressions and constants stay expressions.
#[test]
fn values_that_do_not_change_are_not_computed() -> Result<()> {
    assert_eq!(inner(Type::I32, &[GET, ONE, SET_GLOBAL])?, ["s->g0=1u;", "return l0;"]);
    assert_eq!(inner(Type::I32, &[GET_GLOBAL, CHANGE])?, ["l0=1u;", "return s->g0;"]);
    assert_eq!(inner(Type::I32, &[FIVE, BLOCK, CHANGE, END])?, ["l0=1u;", "return 5u;"]);
    let before_block = ["u32 i0;", "i0=l0;", "l0=1u;", "return i0;"];
    assert_eq!(inner(Type::I32, &[GET, BLOCK, CHANGE, END])?, before_block);
    assert_eq!(inner(Type::I32, &[GET, LOOP, CHANGE, END])?, before_block);
    let read = ["u32 i0;", "i0=s->g0;", "s->g0=1u;", "return i0;"];
    assert_eq!(inner(Type::I32, &[GET_GLOBAL, BLOCK, ONE, SET_GLOBAL, END])?, read);
    // Nothing is written twice into the variable that holds it.
    let called = ["u32 i0;", "i0=host(s);", "l0=1u;", "return i0;"];
    assert_eq!(inner(Type::I32, &[CALL_HOST, BLOCK, CHANGE, END])?, called);
    assert_eq!(lines(&[&[0x01], CHANGE])?, lines(&[CHANGE])?, "a `nop` is nothing");
    Ok(())
}

#[test]
fn a_variable_that_is_set_and_kept_is_taken_again() -> Result<()> {
    assert_eq!(inner(Type::I32, &[FIVE, TEE, GET, ADD])?, ["l0=5u;", "return (l0+l0);"]);
    Ok(())
}

/// The first value where the condition is not 0, with or without its type; comparisons among them are numbers.
#[test]
fn one_of_two_values_is_selected() -> Result<()> {
    const LESS_THAN_FIVE: &[u8] = &[0x20, 0, 0x41, 5, 0x49];
    for select in [&[0x1b][..], &[0x1c, 1, 0x7f]] {
        assert_eq!(inner(Type::I32, &[ONE, FIVE, GET, select])?, ["return (l0?1u:5u);"]);
        let of_comparisons = [GET, EQZ, FIVE, LESS_THAN_FIVE, select];
        assert_eq!(inner(Type::I32, &of_comparisons)?, ["return ((l0<5u)?(u32)!l0:5u);"]);
        let kept = ["u32 i0;", "i0=(l0?1u:5u);", "l0=1u;", "return i0;"];
        assert_eq!(inner(Type::I32, &[ONE, FIVE, GET, select, CHANGE])?, kept);
    }
    Ok(())
}

/// Comparisons are negated as they are, and numbers for all else.
#[test]
fn comparisons_become_numbers_where_they_are_taken() -> Result<()> {
    assert_eq!(inner(Type::I32, &[GET, EQZ, EQZ])?, ["return (u32)!!l0;"]);
    assert_eq!(inner(Type::I32, &[GET, EQZ, ONE, ADD])?, ["return ((u32)!l0+1u);"]);
    assert_eq!(inner(Type::I32, &[ONE, GET, EQZ, ADD])?, ["return (1u+(u32)!l0);"]);
    assert_eq!(lines(&[GET, EQZ, &[0x04, 0x40], CHANGE, END])?[1..], ["if(!l0){", "l0=1u;", "}", "}"]);
    Ok(())
}

/// A table of branches leads to the block of each number, and else to the last; what follows is never reached.
#[test]
fn a_table_of_branches_leads_where_its_places_say() -> Result<()> {
    const TABLE: &[u8] = &[0x0e, 2, 0, 1, 1];
    const OTHER: &[u8] = &[0x41, 2, 0x21, 0];
    let text = lines(&[BLOCK, BLOCK, GET, TABLE, OTHER, END, CHANGE, END])?;
    assert_eq!(text[1..], ["switch(l0){case 0:goto L2;default:goto L1;}", "L2:;", "l0=1u;", "L1:;", "}"]);
    // Three places of which the second is the default; the index is a comparison.
    let text = lines(&[BLOCK, BLOCK, BLOCK, GET, EQZ, &[0x0e, 3, 2, 1, 0, 1], END, END, END])?;
    assert_eq!(text[1], "switch((u32)!l0){case 0:goto L1;case 2:goto L3;default:goto L2;}");
    assert_eq!(lines(&[BLOCK, GET, &[0x0e, 1, 1, 0], END])?[1], "switch(l0){case 0:return;default:goto L1;}");
    Ok(())
}

/// The result of a block is in the variable of its place wherever the block is left.
#[test]
fn results_of_blocks_are_in_the_variable_of_their_place() -> Result<()> {
    let constant = ["u32 i0;", "if(l0){i0=5u;goto L1;}", "i0=5u;", "L1:;", "return i0;"];
    assert_eq!(inner(Type::I32, &[BLOCK_I32, FIVE, LEAVE_IF, END])?, constant);
    // Results of a call stay.
    let called = ["u32 i0;", "i0=host(s);", "if(l0)goto L1;", "L1:;", "return i0;"];
    assert_eq!(inner(Type::I32, &[BLOCK_I32, CALL_HOST, LEAVE_IF, END])?, called);
    let left = ["u32 i0;", "{i0=5u;goto L1;}", "L1:;", "return (i0+1u);"];
    assert_eq!(inner(Type::I32, &[BLOCK_I32, FIVE, &[0x0c, 0], END, ONE, ADD])?, left);
    let choice = [GET, &[0x04, 0x7f], FIVE, ELSE, GET, EQZ, END];
    assert_eq!(inner(Type::I32, &choice)?, ["u32 i0;", "if(l0){", "i0=5u;", "}else{", "i0=!l0;", "}", "return i0;"]);
    // Above a value that waits below the block.
    let above = ["u32 i0,i1;", "i0=l0;", "i1=5u;", "return (i0+i1);"];
    assert_eq!(inner(Type::I32, &[GET, BLOCK_I32, FIVE, END, ADD])?, above);
    Ok(())
}

#[test]
fn a_branch_out_of_the_function_returns() -> Result<()> {
    assert_eq!(inner(Type::I32, &[FIVE, &[0x0c, 0]])?, ["return 5u;"]);
    assert_eq!(inner(Type::I32, &[FIVE, GET, &[0x0d, 0]])?, ["if(l0)return 5u;", "return 5u;"]);
    assert_eq!(inner(Type::I32, &[GET, EQZ])?, ["return (u32)!l0;"]);
    assert_eq!(lines(&[LEAVE_IF, CHANGE])?[1..], ["if(l0)return;", "l0=1u;", "}"]);
    assert_eq!(lines(&[DEAD, CHANGE])?[1..], ["trap(s,UNREACHABLE);", "}"]);
    Ok(())
}

/// Behind a choice all is reached unless both parts leave, and none of them to there.
#[test]
fn what_follows_a_choice_is_left_out_where_both_parts_leave() -> Result<()> {
    const OTHER: &[u8] = &[0x41, 2, 0x21, 0];
    const LEAVE: &[u8] = &[0x0c, 0];
    let follows = |first: &[u8], second: &[u8]| {
        Ok::<_, anyhow::Error>(lines(&[IF, first, ELSE, second, END, CHANGE])?.contains(&"l0=1u;".to_owned()))
    };
    assert!(follows(OTHER, OTHER)?);
    assert!(follows(RETURN, OTHER)?);
    assert!(follows(OTHER, RETURN)?);
    assert!(follows(LEAVE, RETURN)?);
    assert!(!follows(RETURN, RETURN)?);
    let left = lines(&[IF, LEAVE, ELSE, RETURN, END, CHANGE])?;
    assert_eq!(left[1..], ["if(l0){", "goto L1;", "}else{", "return;", "}", "L1:;", "l0=1u;", "}"]);
    // A block, and a loop, whose end is not reached.
    assert_eq!(lines(&[BLOCK, RETURN, END, CHANGE])?[1..], ["return;", "}"]);
    assert_eq!(lines(&[LOOP, LEAVE, END, CHANGE])?[1..], ["L1:;", "goto L1;", "}"]);
    assert_eq!(lines(&[LOOP, LEAVE_IF, END, CHANGE])?[1..], ["L1:;", "if(l0)goto L1;", "l0=1u;", "}"]);
    Ok(())
}

/// Parameters are declared in the head; local variables begin at 0, by their types, and variables of places follow them.
#[test]
fn variables_are_declared_by_their_types() -> Result<()> {
    const LOCALS: &[u8] = &[4, 1, 0x7e, 2, 0x7c, 1, 0x7f, 1, 0x7d];
    let text = lines_of(&[Type::I32], None, &[LOCALS, CALL_HOST, CALL_HOST, DROP, DROP])?;
    let declared = ["u32 l4=0,i0,i1;", "u64 l1=0;", "f32 l5=0;", "f64 l2=0,l3=0;"];
    assert_eq!(text, [&["void w1(Module*s,u32 l0){"][..], &declared, &["i0=host(s);", "i1=host(s);", "}"]].concat());
    Ok(())
}

/// Products go into a variable: a compiler may contract them with a sum in one expression.
#[test]
fn products_are_statements_of_their_own() -> Result<()> {
    let of = |of, product, sum| inner(of, &[GET, GET, GET, product, sum]);
    assert_eq!(of(Type::F64, &[0xa2], &[0xa0])?, ["f64 d1;", "d1=(l0*l0);", "return add64(l0,d1);"]);
    assert_eq!(of(Type::F32, &[0x94], &[0x92])?, ["f32 e1;", "e1=(l0*l0);", "return (l0+e1);"]);
    assert_eq!(of(Type::I32, &[0x6c], &[0x6a])?, ["return (l0+(l0*l0));"]);
    Ok(())
}

#[test]
fn numbers_are_written_with_the_digits_that_give_their_bits() -> Result<()> {
    let double = |value: f64| inner(Type::F64, &[&[0x44], &value.to_le_bytes()]);
    let single = |value: f32| inner(Type::F32, &[&[0x43], &value.to_le_bytes()]);
    for (value, text) in [
        (0.1, "0.1"),
        (3.0, "3.0"),
        (-0.0, "(-0.0)"),
        (-2.5e-300, "(-2.5e-300)"),
        (f64::INFINITY, "of_bits64(9218868437227405312ull)"),
        (f64::NEG_INFINITY, "of_bits64(18442240474082181120ull)"),
    ] {
        assert_eq!(double(value)?, [format!("return {text};")]);
    }
    for (value, text) in [(0.5, "0.5f"), (-0.5, "(-0.5f)"), (f32::INFINITY, "of_bits32(2139095040u)")] {
        assert_eq!(single(value)?, [format!("return {text};")]);
    }
    assert_eq!(inner(Type::I32, &[&[0x41, 0x7f]])?, ["return 4294967295u;"]);
    Ok(())
}

/// Expressions have 160 letters at most; longer ones go into a variable.
#[test]
fn long_expressions_are_computed() -> Result<()> {
    // Thirty sums `(...+l0)` of 5 letters around `l0` have 152, a further one of a number of four digits 160.
    let thirty = [GET, &[GET, ADD].concat().repeat(30)].concat();
    let longest = inner(Type::I32, &[&thirty, &[0x41, 0xd2, 0x09], ADD])?;
    assert_eq!((longest.len(), longest[0].len()), (1, "return ;".len() + 160));
    assert!(longest[0].ends_with("+1234u);"), "{longest:?}");
    let longer = inner(Type::I32, &[&thirty, &[0x41, 0xb9, 0xe0, 0x00], ADD])?;
    assert_eq!((longer.len(), &*longer[0], &*longer[2]), (3, "u32 i0;", "return i0;"));
    assert!(longer[1].starts_with("i0=((") && longer[1].ends_with("+12345u);"), "{longer:?}");
    Ok(())
}

#[test]
fn calls_take_their_arguments_in_order_and_are_listed() -> Result<()> {
    let two = function(&[Type::I32, Type::I64], None, &[NO_LOCALS, GET, &[0x42, 5, 0x10, 1]])?;
    assert!(two.text.ends_with("{\nw1(s,l0,5ull);\n}\n"), "{}", two.text);
    assert_eq!(two.calls, [1]);
    let half = [&[0x44][..], &0.5f64.to_le_bytes()].concat();
    let number = function(&[], None, &[NO_LOCALS, CALL_HOST, DROP, &half, &[0x10, 2]])?;
    assert!(number.text.ends_with("{\nu32 i0;\ni0=host(s);\nw2(s,0.5);\n}\n"), "{}", number.text);
    assert_eq!(number.calls, [2], "imported functions have no text of their own");
    // The index and the argument are on the stack as comparisons.
    let through = lines(&[GET, EQZ, GET, EQZ, &[0x11, 0, 0]])?;
    assert_eq!(through[1], "((t0)entry(s,0u,(u32)!l0))(s,(u32)!l0);");
    Ok(())
}

/// An access has its size behind its offset, and another name where the compiler does not say that it is aligned.
#[test]
fn accesses_are_of_their_size_and_alignment() -> Result<()> {
    for (access, bytes, name) in [
        ([0x28, 2, 0], 4, "li"),
        ([0x28, 1, 0], 4, "liu"),
        ([0x2d, 0, 0], 1, "li1"),
        ([0x2f, 1, 3], 5, "li2"),
        ([0x2f, 0, 3], 5, "li2u"),
    ] {
        let text = inner(Type::I32, &[GET, &access])?;
        assert_eq!(text[1..3], [format!("within(l0,{bytes}u);"), format!("return {name}(m,l0,{}u);", access[2])]);
    }
    let stored = lines(&[GET, GET, EQZ, &[0x36, 2, 4]])?;
    assert_eq!(stored[1..4], ["u8*const m=s->memory;", "within(l0,8u);", "si(m,l0,4u,(u32)!l0);"]);
    // Where it is out of bounds is behind the last statement, which returns.
    assert_eq!(stored[4..], ["return;", "X:trap(s,OUT_OF_BOUNDS);", "}"]);
    assert_eq!(inner(Type::I32, &[GET, &[0x28, 2, 0]])?.last().map(String::as_str), Some("X:trap(s,OUT_OF_BOUNDS);"));
    Ok(())
}

/// The last eight bytes of a page of 65,536, and one further.
#[test]
fn addresses_that_are_constant_are_compared_beyond_the_memory() -> Result<()> {
    assert_eq!(comparisons(&[&[0x41, 0xf8, 0xff, 0x03], LOAD])?, [""; 0]);
    assert_eq!(comparisons(&[&[0x41, 0xf9, 0xff, 0x03], LOAD])?, ["within(65529u,8u);"]);
    Ok(())
}

#[test]
fn what_is_not_translated_is_named_with_its_place() {
    let problem = |code: &[&[u8]]| lines(code).err().map(|error| format!("{error:#}")).unwrap_or_default();
    let table = problem(&[&[0xfc, 16, 0]]);
    assert!(table.contains("TableSize") && table.ends_with("at byte 1: it is not translated"), "{table}");
    let arguments = problem(&[&[0x02, 0, 0x0b]]);
    assert!(arguments.ends_with("blocks with arguments or several results are not translated"), "{arguments}");
    assert!(problem(&[DROP]).ends_with("the stack is empty"));
    assert!(problem(&[GET, BLOCK, DROP, END]).ends_with("the stack is empty"), "what is below a block is not in it");
}
