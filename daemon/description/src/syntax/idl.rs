//! Types, constants, expressions and initialisers (genom3.md 2.4 to 2.6).

use super::{Name, Path, Text};
use crate::model::Span;
use crate::token::Pragma;

/// A statement that may stand anywhere: in a module, a component or at top level.
#[derive(Clone, Debug)]
pub enum Idl {
    /// `module m {...};`
    Module {
        /// Word after `module`.
        name: Name,
        /// What it holds.
        statements: Vec<Idl>,
    },
    /// `const T n = e;`
    Const(Const),
    /// `typedef T a, b[2];`
    Typedef(Typedef),
    /// `native n;`
    Native(Name),
    /// `exception a, b {...};`
    Exceptions(Vec<Exception>),
    /// A struct, union or enum on its own.
    Constructed(Constructed),
    /// `struct s;` or `union u;`
    Forward {
        /// Whether it is a union.
        union: bool,
        /// Struct or union that is announced.
        name: Name,
    },
    /// A pragma within a module; its names are resolved in that module.
    Pragma(Pragma, Span),
}

/// `const T n = e;`
#[derive(Clone, Debug)]
pub struct Const {
    /// Declared type.
    pub ty: TypeSpec,
    /// Word before `=`.
    pub name: Name,
    /// Expression after `=`.
    pub value: Expression,
}

/// `typedef T a, b[2];`
#[derive(Clone, Debug)]
pub struct Typedef {
    /// The type named.
    pub ty: TypeSpec,
    /// The new names.
    pub declarators: Vec<Declarator>,
}

/// One exception of a statement.
#[derive(Clone, Debug)]
pub struct Exception {
    /// Word after `exception`.
    pub name: Name,
    /// Its detail, empty for none.
    pub members: Vec<Member>,
}

/// A type at a place where one is used.
#[derive(Clone, Debug)]
pub struct TypeSpec {
    /// What it is.
    pub kind: TypeSpecKind,
    /// Position in the text.
    pub span: Span,
}

/// Kinds of types as written.
#[derive(Clone, Debug)]
pub enum TypeSpecKind {
    /// `boolean`
    Boolean,
    /// `char`
    Char,
    /// `octet`
    Octet,
    /// `short`
    Short,
    /// `unsigned short`
    UnsignedShort,
    /// `long`
    Long,
    /// `unsigned long`
    UnsignedLong,
    /// `long long`
    LongLong,
    /// `unsigned long long`
    UnsignedLongLong,
    /// `float`
    Float,
    /// `double`
    Double,
    /// `any`
    Any,
    /// `string`, `string<n>`
    String(Option<Box<Expression>>),
    /// `sequence<T>`, `sequence<T, n>`
    Sequence(Box<TypeSpec>, Option<Box<Expression>>),
    /// `optional<T>`
    Optional(Box<TypeSpec>),
    /// A name.
    Named(Path),
    /// Defined in place.
    Constructed(Box<Constructed>),
    /// After an error that was reported: compatible with any type.
    Error,
}

/// A struct, union or enum with its body.
#[derive(Clone, Debug)]
pub enum Constructed {
    /// `struct s {...}`
    Struct(Struct),
    /// `union u switch (T) {...}`
    Union(Union),
    /// `enum e {...}`
    Enum(Enum),
}

/// `struct s {...}`
#[derive(Clone, Debug)]
pub struct Struct {
    /// Word after `struct`.
    pub name: Name,
    /// Its members, by type.
    pub members: Vec<Member>,
}

/// `T a, b[2];` in a struct.
#[derive(Clone, Debug)]
pub struct Member {
    /// Their common type.
    pub ty: TypeSpec,
    /// Names with their dimensions, separated by commas.
    pub declarators: Vec<Declarator>,
}

/// `union u switch (T) {...}`
#[derive(Clone, Debug)]
pub struct Union {
    /// Word after `union`.
    pub name: Name,
    /// Type of the discriminant.
    pub switch: TypeSpec,
    /// Members with their labels.
    pub cases: Vec<Case>,
}

/// A member of a union.
#[derive(Clone, Debug)]
pub struct Case {
    /// Labels that select it.
    pub labels: Vec<CaseLabel>,
    /// Type of the member that the labels select.
    pub ty: TypeSpec,
    /// Name of that member, with its dimensions.
    pub declarator: Declarator,
}

/// `case e:` or `default:`.
#[derive(Clone, Debug)]
pub struct CaseLabel {
    /// `None` for `default`.
    pub value: Option<Expression>,
    /// Position in the text.
    pub span: Span,
}

/// `enum e {...}`
#[derive(Clone, Debug)]
pub struct Enum {
    /// Word after `enum`.
    pub name: Name,
    /// Names between the braces, in order: the first is 0.
    pub enumerators: Vec<Name>,
}

/// A name with its array dimensions.
#[derive(Clone, Debug)]
pub struct Declarator {
    /// Word that is declared.
    pub name: Name,
    /// Dimensions, outermost first.
    pub dimensions: Vec<Expression>,
}

/// A constant expression.
#[derive(Clone, Debug)]
pub struct Expression {
    /// Operator and operands, or a literal.
    pub kind: ExpressionKind,
    /// Position in the text.
    pub span: Span,
}

/// Kinds of expressions.
#[derive(Clone, Debug)]
pub enum ExpressionKind {
    /// A literal.
    Literal(Literal),
    /// A constant or an enumerator.
    Name(Path),
    /// `-x`
    Unary(Unary, Box<Expression>),
    /// `a + b - c`: operators of one precedence, from left to right. A list, so that a long sum
    /// does not make a deep tree.
    Chain(Box<Expression>, Vec<(Binary, Expression)>),
    /// After an error that was reported.
    Error,
}

/// Literals.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal {
    /// `TRUE`, `FALSE`
    Boolean(bool),
    /// Integer.
    Integer(u64),
    /// Floating point.
    Float(f64),
    /// Character.
    Char(u8),
    /// Strings, joined.
    String(String),
}

/// Unary operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// `-`
    Minus,
    /// `+`
    Plus,
    /// `~`
    Not,
}

/// Binary operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    /// `|`
    Or,
    /// `^`
    Xor,
    /// `&`
    And,
    /// `<<`
    ShiftLeft,
    /// `>>`
    ShiftRight,
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
    /// `%`
    Remainder,
}

/// `= {...} : "doc"` after a parameter, or an element of a compound.
#[derive(Clone, Debug)]
pub struct Initializer {
    /// `[2] =` or `.x =` before the value.
    pub step: Option<InitialStep>,
    /// The value; `None` when there is only documentation.
    pub value: Option<InitialValue>,
    /// `: "doc"`
    pub doc: Option<Text>,
    /// Position in the text.
    pub span: Span,
}

/// Which element an initialiser is for.
#[derive(Clone, Debug)]
pub enum InitialStep {
    /// `[n]`
    Index(Expression),
    /// `.name`
    Member(Name),
}

/// A value of an initialiser.
#[derive(Clone, Debug)]
pub enum InitialValue {
    /// One value.
    Scalar(Expression),
    /// `{...}`
    Compound(Vec<Initializer>),
}
