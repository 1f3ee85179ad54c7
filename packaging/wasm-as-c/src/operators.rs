//! Operators of WebAssembly in C, except control, variables, memory and calls.

/// A type of values, by the letter of the C variables that hold them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Type {
    /// 32-bit integer, unsigned in C.
    I32,
    /// 64-bit integer, unsigned in C.
    I64,
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

impl Type {
    /// The letter that variables of this type begin with.
    pub fn letter(self) -> char {
        match self {
            Self::I32 => 'i',
            Self::I64 => 'j',
            Self::F32 => 'e',
            Self::F64 => 'd',
        }
    }

    /// Its name in C.
    pub fn in_c(self) -> &'static str {
        match self {
            Self::I32 => "u32",
            Self::I64 => "u64",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

/// An operator that computes one value from others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operator {
    /// Number of operands.
    pub arguments: usize,
    /// Type of the result; comparisons are of type `I32`.
    pub result: Type,
    /// Whether it is a comparison: of type `int` in C.
    pub compares: bool,
    /// The expression; `A` and `B` stand for the arguments.
    pub text: &'static str,
}

/// An access to memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Access {
    /// The function in C that carries it out.
    pub function: &'static str,
    /// The type of a value that is loaded; nothing for a store.
    pub loads: Option<Type>,
}

/// The operator of a name, as the parser calls it.
pub fn operator(name: &str) -> Option<Operator> {
    let line = OPERATORS.lines().find(|line| line.split(' ').next() == Some(name))?;
    let mut words = line.split(' ').skip(1);
    let (arguments, result, text) = (words.next()?, words.next()?, words.next()?);
    let compares = result == "c";
    let result = match result {
        "i" | "c" => Type::I32,
        "j" => Type::I64,
        "e" => Type::F32,
        _ => Type::F64,
    };
    Some(Operator { arguments: arguments.parse().ok()?, result, compares, text })
}

/// The access of a name, as the parser calls it.
pub fn access(name: &str) -> Option<Access> {
    let (result, function) = ACCESSES.iter().find(|(other, ..)| *other == name).map(|(_, it, name)| (*it, *name))?;
    Some(Access { function, loads: result })
}

/// Name, number of arguments, result (`c` of a comparison), expression. Integers are unsigned in C; what would overflow,
/// divide by zero, depend on the sign of zero or round wrongly on some processor is a function of `operators.h`.
const OPERATORS: &str = "\
I32Eqz 1 c !A
I32Eq 2 c (A==B)
I32Ne 2 c (A!=B)
I32LtS 2 c ((s32)A<(s32)B)
I32LtU 2 c (A<B)
I32GtS 2 c ((s32)A>(s32)B)
I32GtU 2 c (A>B)
I32LeS 2 c ((s32)A<=(s32)B)
I32LeU 2 c (A<=B)
I32GeS 2 c ((s32)A>=(s32)B)
I32GeU 2 c (A>=B)
I64Eqz 1 c !A
I64Eq 2 c (A==B)
I64Ne 2 c (A!=B)
I64LtS 2 c ((s64)A<(s64)B)
I64LtU 2 c (A<B)
I64GtS 2 c ((s64)A>(s64)B)
I64GtU 2 c (A>B)
I64LeS 2 c ((s64)A<=(s64)B)
I64LeU 2 c (A<=B)
I64GeS 2 c ((s64)A>=(s64)B)
I64GeU 2 c (A>=B)
F32Eq 2 c (A==B)
F32Ne 2 c (A!=B)
F32Lt 2 c (A<B)
F32Gt 2 c (A>B)
F32Le 2 c (A<=B)
F32Ge 2 c (A>=B)
F64Eq 2 c (A==B)
F64Ne 2 c (A!=B)
F64Lt 2 c (A<B)
F64Gt 2 c (A>B)
F64Le 2 c (A<=B)
F64Ge 2 c (A>=B)
I32Clz 1 i clz32(A)
I32Ctz 1 i ctz32(A)
I32Popcnt 1 i popcnt32(A)
I32Add 2 i (A+B)
I32Sub 2 i (A-B)
I32Mul 2 i (A*B)
I32DivS 2 i div32s(s,A,B)
I32DivU 2 i div32(s,A,B)
I32RemS 2 i rem32s(s,A,B)
I32RemU 2 i rem32(s,A,B)
I32And 2 i (A&B)
I32Or 2 i (A|B)
I32Xor 2 i (A^B)
I32Shl 2 i (A<<(B&31))
I32ShrS 2 i shr32s(A,B)
I32ShrU 2 i (A>>(B&31))
I32Rotl 2 i rotl32(A,B)
I32Rotr 2 i rotr32(A,B)
I64Clz 1 j clz64(A)
I64Ctz 1 j ctz64(A)
I64Popcnt 1 j popcnt64(A)
I64Add 2 j (A+B)
I64Sub 2 j (A-B)
I64Mul 2 j (A*B)
I64DivS 2 j div64s(s,A,B)
I64DivU 2 j div64(s,A,B)
I64RemS 2 j rem64s(s,A,B)
I64RemU 2 j rem64(s,A,B)
I64And 2 j (A&B)
I64Or 2 j (A|B)
I64Xor 2 j (A^B)
I64Shl 2 j (A<<(B&63))
I64ShrS 2 j shr64s(A,B)
I64ShrU 2 j (A>>(B&63))
I64Rotl 2 j rotl64(A,B)
I64Rotr 2 j rotr64(A,B)
F32Abs 1 e fabsf(A)
F32Neg 1 e (-A)
F32Ceil 1 e ceilf(A)
F32Floor 1 e floorf(A)
F32Trunc 1 e truncf(A)
F32Nearest 1 e rintf(A)
F32Sqrt 1 e sqrtf(A)
F32Add 2 e (A+B)
F32Sub 2 e (A-B)
F32Mul 2 e (A*B)
F32Div 2 e (A/B)
F32Min 2 e min32(A,B)
F32Max 2 e max32(A,B)
F32Copysign 2 e copysignf(A,B)
F64Abs 1 d fabs(A)
F64Neg 1 d (-A)
F64Ceil 1 d ceil(A)
F64Floor 1 d floor(A)
F64Trunc 1 d trunc(A)
F64Nearest 1 d rint(A)
F64Sqrt 1 d sqrt(A)
F64Add 2 d add64(A,B)
F64Sub 2 d sub64(A,B)
F64Mul 2 d (A*B)
F64Div 2 d (A/B)
F64Min 2 d min64(A,B)
F64Max 2 d max64(A,B)
F64Copysign 2 d copysign(A,B)
I32WrapI64 1 i (u32)A
I32TruncF32S 1 i trunc32s(s,A)
I32TruncF32U 1 i trunc32(s,A)
I32TruncF64S 1 i trunc32s(s,A)
I32TruncF64U 1 i trunc32(s,A)
I64ExtendI32S 1 j (u64)(s64)(s32)A
I64ExtendI32U 1 j (u64)A
I64TruncF32S 1 j trunc64s(s,A)
I64TruncF32U 1 j trunc64(s,A)
I64TruncF64S 1 j trunc64s(s,A)
I64TruncF64U 1 j trunc64(s,A)
F32ConvertI32S 1 e (f32)(s32)A
F32ConvertI32U 1 e (f32)A
F32ConvertI64S 1 e (f32)(s64)A
F32ConvertI64U 1 e (f32)A
F32DemoteF64 1 e (f32)A
F64ConvertI32S 1 d (f64)(s32)A
F64ConvertI32U 1 d (f64)A
F64ConvertI64S 1 d (f64)(s64)A
F64ConvertI64U 1 d (f64)A
F64PromoteF32 1 d (f64)A
I32ReinterpretF32 1 i bits32(A)
I64ReinterpretF64 1 j bits64(A)
F32ReinterpretI32 1 e of_bits32(A)
F64ReinterpretI64 1 d of_bits64(A)
I32Extend8S 1 i (u32)(s32)(s8)A
I32Extend16S 1 i (u32)(s32)(s16)A
I64Extend8S 1 j (u64)(s64)(s8)A
I64Extend16S 1 j (u64)(s64)(s16)A
I64Extend32S 1 j (u64)(s64)(s32)A
I32TruncSatF32S 1 i sat32s(A)
I32TruncSatF32U 1 i sat32(A)
I32TruncSatF64S 1 i sat32s(A)
I32TruncSatF64U 1 i sat32(A)
I64TruncSatF32S 1 j sat64s(A)
I64TruncSatF32U 1 j sat64(A)
I64TruncSatF64S 1 j sat64s(A)
I64TruncSatF64U 1 j sat64(A)";

const ACCESSES: [(&str, Option<Type>, &str); 23] = [
    ("I32Load", Some(Type::I32), "li"),
    ("I64Load", Some(Type::I64), "lj"),
    ("F32Load", Some(Type::F32), "le"),
    ("F64Load", Some(Type::F64), "ld"),
    ("I32Load8S", Some(Type::I32), "li1s"),
    ("I32Load8U", Some(Type::I32), "li1"),
    ("I32Load16S", Some(Type::I32), "li2s"),
    ("I32Load16U", Some(Type::I32), "li2"),
    ("I64Load8S", Some(Type::I64), "lj1s"),
    ("I64Load8U", Some(Type::I64), "lj1"),
    ("I64Load16S", Some(Type::I64), "lj2s"),
    ("I64Load16U", Some(Type::I64), "lj2"),
    ("I64Load32S", Some(Type::I64), "lj4s"),
    ("I64Load32U", Some(Type::I64), "lj4"),
    ("I32Store", None, "si"),
    ("I64Store", None, "sj"),
    ("F32Store", None, "se"),
    ("F64Store", None, "sd"),
    ("I32Store8", None, "si1"),
    ("I32Store16", None, "si2"),
    ("I64Store8", None, "sj1"),
    ("I64Store16", None, "sj2"),
    ("I64Store32", None, "sj4"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_table_can_be_read() {
        for line in OPERATORS.lines() {
            let name = line.split(' ').next().unwrap_or_default();
            let operator = operator(name).unwrap_or_else(|| panic!("{line}"));
            let takes_two = operator.text.contains('B');
            assert_eq!(operator.arguments == 2, takes_two, "{line}");
            assert_eq!(operator.compares, line.split(' ').nth(2) == Some("c"), "{line}");
            // Names begin with the type of the result, of comparisons with the type of the arguments.
            let expected = match &name[..3] {
                _ if operator.compares => Type::I32,
                "I32" => Type::I32,
                "I64" => Type::I64,
                "F32" => Type::F32,
                _ => Type::F64,
            };
            assert_eq!(operator.result, expected, "{line}");
        }
        assert_eq!(operator("I32Add").map(|it| (it.result, it.compares)), Some((Type::I32, false)));
        assert_eq!(operator("F64Lt").map(|it| (it.result, it.compares)), Some((Type::I32, true)));
        assert_eq!((operator("V128Not"), access("V128Load")), (None, None));
        assert_eq!(access("I64Load8S"), Some(Access { function: "lj1s", loads: Some(Type::I64) }));
        assert_eq!(access("F32Store"), Some(Access { function: "se", loads: None }));
    }
}
