//! Components, interfaces and their contents (genom3.md 2.4, dialects.md).

use std::rc::Rc;

use super::{Declarator, Expression, Idl, Initializer, Name, Path, Text, TypeSpec};
use crate::model::Span;
use crate::token::Pragma;

/// A component or interface, or one of the parts that it is written in.
#[derive(Clone, Debug)]
pub struct Body {
    /// Word after `component` or `interface`.
    pub name: Name,
    /// What stands between the braces.
    pub exports: Vec<Export>,
}

/// A statement in a component.
#[derive(Clone, Debug)]
pub enum Export {
    /// Types, constants, modules.
    Idl(Idl),
    /// A property of the component.
    Property(Property),
    /// `ids { ... };` or, in the 2010 paper, `ids: T;`.
    Ids(IdsDeclaration),
    /// An execution task.
    Task(Task),
    /// A port.
    Port(PortDeclaration),
    /// An attribute, function, activity, or service of the papers.
    Service(Service),
    /// `event a, b;` (dialects.md A).
    Events(Vec<Name>),
    /// A pragma that takes effect here.
    Pragma(Pragma, Span),
}

/// `ids {...}`, or `ids name {...}` in the 2011 paper.
#[derive(Clone, Debug)]
pub struct IdsDeclaration {
    /// Name of the struct (2011 paper).
    pub name: Option<Name>,
    /// Members by type.
    pub members: Vec<super::Member>,
    /// Place of the word `ids`.
    pub span: Span,
}

/// `task t {...}`
#[derive(Clone, Debug)]
pub struct Task {
    /// Word after `task`.
    pub name: Name,
    /// What stands between its braces.
    pub properties: Vec<Property>,
}

/// `port [multiple] in|out T p {...}`, `inport T p`, `outport T p`.
#[derive(Clone, Debug)]
pub struct PortDeclaration {
    /// Whether data flow out of the component.
    pub out: bool,
    /// `multiple`
    pub multiple: bool,
    /// Written `inport` or `outport`, as in the papers' dialects.
    pub paper: bool,
    /// Type of the data.
    pub ty: TypeSpec,
    /// Word after the type.
    pub name: Name,
    /// Only `doc` is legal.
    pub properties: Vec<Property>,
    /// Place of the word `port`, `inport` or `outport`.
    pub span: Span,
}

/// Keyword that a service was declared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServiceKind {
    /// `attribute`
    Attribute,
    /// `function`
    Function,
    /// `activity`
    Activity,
    /// `service`, as in the papers.
    Service,
}

/// A service.
#[derive(Clone, Debug)]
pub struct Service {
    /// Word before the name.
    pub kind: ServiceKind,
    /// Word after the keyword.
    pub name: Name,
    /// What stands between its parentheses.
    pub parameters: ServiceParameters,
    /// What stands between its braces.
    pub properties: Vec<Property>,
    /// From keyword to name.
    pub span: Span,
}

/// Parameters of a service.
#[derive(Clone, Debug)]
pub enum ServiceParameters {
    /// Members of the IDS, for attributes and the services of the papers.
    Variables(Vec<VariableParameter>),
    /// With types of their own, for functions and activities.
    Typed(Vec<ServiceParameter>),
}

/// `in T name = init`
#[derive(Clone, Debug)]
pub struct ServiceParameter {
    /// Direction.
    pub direction: Direction,
    /// Type.
    pub ty: TypeSpec,
    /// Name and dimensions.
    pub declarator: Declarator,
    /// Default value and documentation.
    pub initializer: Option<Initializer>,
}

/// `in a.b::name = init`
#[derive(Clone, Debug)]
pub struct VariableParameter {
    /// Direction.
    pub direction: Direction,
    /// Member of the IDS; `None` for the whole of it.
    pub variable: Option<Variable>,
    /// `::name`
    pub rename: Option<Name>,
    /// Default value and documentation.
    pub initializer: Option<Initializer>,
    /// Position in the text.
    pub span: Span,
}

/// Directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// `in`
    In,
    /// `out`
    Out,
    /// `inout`
    InOut,
}

/// `a.b[2].c`
#[derive(Clone, Debug)]
pub struct Variable {
    /// First identifier.
    pub root: Name,
    /// What follows.
    pub steps: Vec<VariableStep>,
}

impl Variable {
    /// The last identifier, which names the parameter.
    #[must_use]
    pub fn last(&self) -> &Name {
        self.steps
            .iter()
            .rev()
            .find_map(|step| match step {
                VariableStep::Member(name) => Some(name),
                VariableStep::Index(_) => None,
            })
            .unwrap_or(&self.root)
    }
}

/// A step of a variable.
#[derive(Clone, Debug)]
pub enum VariableStep {
    /// `.name`
    Member(Name),
    /// `[n]`
    Index(Expression),
}

/// A property, which the grammar accepts anywhere (genom3.md 2.4).
#[derive(Clone, Debug)]
pub struct Property {
    /// Keyword and value.
    pub kind: PropertyKind,
    /// The keyword as written.
    pub keyword: Name,
    /// The `:` after the keyword, as in the papers' dialects.
    pub colon: Option<Span>,
}

/// Properties.
#[derive(Clone, Debug)]
pub enum PropertyKind {
    /// `doc`
    Doc(Text),
    /// `version`
    Version(Text),
    /// `lang`, `language:`
    Lang(Text),
    /// `email`
    Email(Text),
    /// `requires`
    Requires(Vec<Text>),
    /// `codels-require`
    CodelsRequire(Vec<Text>),
    /// `clock-rate`
    ClockRate(Quantity),
    /// `provides`
    Provides(Vec<Name>),
    /// `uses`
    Uses(Vec<Name>),
    /// `extends`
    Extends(Vec<Name>),
    /// `throws`
    Throws(Vec<Path>),
    /// `period`
    Period(Quantity),
    /// `delay`
    Delay(Quantity),
    /// `priority`
    Priority(Expression),
    /// `scheduling real-time`
    RealTime,
    /// `stack`: value and the factor of its unit.
    Stack(Expression, u64),
    /// `task`
    Task(Name),
    /// `interrupts`
    Interrupts(Vec<Name>),
    /// `before`
    Before(Vec<Name>),
    /// `after`
    After(Vec<Name>),
    /// `validate`
    Validate(Rc<Codel>),
    /// `local`
    Local(TypeSpec, Vec<Declarator>),
    /// `codel`
    Codel(Rc<Codel>),
    /// `ids: T;` (2010 paper)
    IdsType(Path),
    /// `input: a, b;` (2010 paper)
    Input(Vec<Variable>),
    /// `output: a, b;` (2010 paper)
    Output(Vec<Variable>),
}

/// A time: an expression and its unit.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Expression before the unit.
    pub value: Expression,
    /// Word after the number.
    pub unit: TimeUnit,
}

/// Units of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeUnit {
    /// `s`, or nothing.
    Second,
    /// `ms`
    Millisecond,
    /// `us`
    Microsecond,
}

impl TimeUnit {
    /// How many of it make one second.
    #[must_use]
    pub fn per_second(self) -> f64 {
        match self {
            TimeUnit::Second => 1.0,
            TimeUnit::Millisecond => 1e3,
            TimeUnit::Microsecond => 1e6,
        }
    }
}

/// A codel.
#[derive(Clone, Debug)]
pub struct Codel {
    /// `async`
    pub asynchronous: bool,
    /// Name of the function.
    pub name: Name,
    /// What stands between its parentheses.
    pub parameters: Vec<CodelParameter>,
    /// Triggers and yields of a state-machine codel.
    pub machine: Option<(Vec<Event>, Vec<Event>)>,
    /// `wcet` (genom3.md appendix D).
    pub wcet: Option<Wcet>,
    /// Position of triggers written as labels, `codel a, b:`, as in the papers' dialects.
    pub labels: Option<Span>,
}

/// `wcet 2 ms`
pub type Wcet = Quantity;

/// A state, or a pause before it.
#[derive(Clone, Debug)]
pub struct Event {
    /// `pause::`
    pub pause: bool,
    /// Name of the state, without `pause::`.
    pub name: Name,
}

/// Qualifier of a codel parameter: its source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Qualifier {
    /// `ids`
    Ids,
    /// `local`
    Local,
    /// `port`
    Port,
    /// `remote`
    Remote,
}

/// A parameter of a codel.
#[derive(Clone, Debug)]
pub struct CodelParameter {
    /// `ids`, `local`, `port`, `remote`.
    pub qualifier: Option<Qualifier>,
    /// `inport`, `outport`: as in the papers.
    pub paper: bool,
    /// Direction.
    pub direction: Direction,
    /// `None` for the whole IDS.
    pub variable: Option<Variable>,
    /// `::name`
    pub rename: Option<Name>,
    /// Position in the text.
    pub span: Span,
}
