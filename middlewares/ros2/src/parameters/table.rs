//! Maps attributes to parameters.
//!
//! An attribute that returns a single plain value makes a parameter named after that member, and
//! one that takes such a value makes it settable: `get_speed(out velocity)` and `set_speed(in
//! velocity)` are the parameter `velocity`. If unrelated attributes have members of the same name,
//! these become separate parameters named `attribute.member`.
//!
//! Every node also has the parameter `use_sim_time`. A component whose attributes make one of that
//! name means something by it, so that theirs is shown instead.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::{Arc, Mutex};

use genom_middleware::{ServiceHandler, ServiceType};
use ros2_client::parameters::ParameterType;

use super::clock::{self, Clock};
use super::value::Shape;

/// A served attribute that is suitable for a parameter.
pub(crate) struct Attribute {
    pub(crate) name: String,
    pub(crate) ty: ServiceType,
    pub(crate) handler: Arc<dyn ServiceHandler>,
    pub(crate) way: Way,
}

/// What an attribute does for its parameter.
#[derive(Clone, Debug)]
pub(crate) enum Way {
    Get(Shape),
    Set(Shape),
}

impl Way {
    /// What an attribute can do for a parameter; `None` if it is not suitable.
    pub(crate) fn of(ty: &ServiceType) -> Option<Self> {
        if ty.input.member_count() == 0 {
            Shape::of(&ty.output).map(Self::Get)
        } else {
            Shape::of(&ty.input).map(Self::Set)
        }
    }

    fn shape(&self) -> &Shape {
        match self {
            Self::Get(shape) | Self::Set(shape) => shape,
        }
    }
}

/// Attributes of an instance, by name.
pub(crate) type Attributes = Arc<Mutex<BTreeMap<String, Arc<Attribute>>>>;

/// A parameter.
#[derive(Clone)]
pub(crate) enum Known {
    /// One that attributes read and set.
    Attributes(Box<Pair>),
    /// `use_sim_time`.
    Clock(Clock),
}

/// The attributes of a parameter, at least one.
#[derive(Clone, Default)]
pub(crate) struct Pair {
    pub(crate) get: Option<(Arc<Attribute>, Shape)>,
    pub(crate) set: Option<(Arc<Attribute>, Shape)>,
}

/// None that there is.
impl Default for Known {
    fn default() -> Self {
        Self::Attributes(Box::default())
    }
}

impl Known {
    /// The shape that it takes or, if read-only, that it returns.
    fn shape(&self) -> Option<&Shape> {
        match self {
            Self::Attributes(pair) => {
                pair.set.as_ref().or(pair.get.as_ref()).map(|(_, shape)| shape)
            }
            Self::Clock(_) => None,
        }
    }

    pub(crate) fn ty(&self) -> ParameterType {
        match self {
            Self::Attributes(_) => self.shape().map_or(ParameterType::NotSet, |shape| shape.ty),
            Self::Clock(_) => ParameterType::Bool,
        }
    }

    pub(crate) fn range(&self) -> Option<(i64, i64)> {
        self.shape()?.range
    }

    pub(crate) fn constraint(&self) -> &str {
        match self {
            Self::Attributes(_) => self.shape().map_or("", |shape| &shape.constraint),
            Self::Clock(_) => clock::CONSTRAINT,
        }
    }

    /// Whether it keeps its value, whatever others ask for.
    pub(crate) fn is_read_only(&self) -> bool {
        match self {
            Self::Attributes(pair) => pair.set.is_none(),
            Self::Clock(_) => true,
        }
    }

    /// How it is read and set, for users.
    pub(crate) fn description(&self) -> String {
        let Self::Attributes(pair) = self else {
            return clock::DESCRIPTION.to_owned();
        };
        let Pair { get, set } = &**pair;
        let mut out = String::new();
        if let Some((attribute, _)) = get {
            _ = write!(out, "read by attribute {}", attribute.name);
        }
        if let Some((attribute, _)) = set {
            let before = if out.is_empty() { "only " } else { ", " };
            _ = write!(out, "{before}set by attribute {}", attribute.name);
        }
        out
    }
}

impl Pair {
    fn add(&mut self, attribute: &Arc<Attribute>) {
        let with = |shape: &Shape| Some((Arc::clone(attribute), shape.clone()));
        match &attribute.way {
            Way::Get(shape) => self.get = with(shape),
            Way::Set(shape) => self.set = with(shape),
        }
    }
}

/// All parameters, by name. The result does not depend on the order of the attributes.
pub(crate) fn parameters<'a>(
    attributes: impl Iterator<Item = &'a Arc<Attribute>>,
    simulated: bool,
) -> BTreeMap<String, Known> {
    let mut by_member: BTreeMap<&str, Vec<&Arc<Attribute>>> = BTreeMap::new();
    for attribute in attributes {
        by_member.entry(attribute.way.shape().name()).or_default().push(attribute);
    }
    let mut all = BTreeMap::<String, Pair>::new();
    for (member, attributes) in by_member {
        let belong = match attributes.as_slice() {
            [_] => true,
            [one, other] => {
                one.way.shape().ty == other.way.shape().ty
                    && matches!(one.way, Way::Get(_)) != matches!(other.way, Way::Get(_))
            }
            _ => false,
        };
        for attribute in attributes {
            let name = match belong {
                true => member.to_owned(),
                false => format!("{}.{member}", attribute.name),
            };
            all.entry(name).or_default().add(attribute);
        }
    }
    let own = Known::Clock(Clock { simulated });
    let mut all: BTreeMap<_, _> =
        all.into_iter().map(|(name, pair)| (name, Known::Attributes(pair.into()))).collect();
    all.entry(clock::NAME.to_owned()).or_insert(own);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    use genom_middleware::{ActivityId, Replies, ServiceKind};
    use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeTable};

    struct Nothing;

    impl ServiceHandler for Nothing {
        fn request(&self, _: Record, _: Box<dyn Replies>) {}

        fn cancel(&self, _: ActivityId) {}
    }

    fn structure(members: &[(&str, Kind)]) -> DataType {
        let mut table = TypeTable::default();
        let members = members.iter().map(|(name, kind)| {
            let ty = table.add(kind.clone());
            Member { name: (*name).to_owned(), ty }
        });
        let members = members.collect();
        let id = table.add(Kind::Struct { name: ScopedName::new(["demo", "x"]), members });
        DataType::new(&Arc::new(table), id).unwrap()
    }

    fn attribute(name: &str, takes: bool, member: &str, kind: Kind) -> Arc<Attribute> {
        let (value, nothing) = (structure(&[(member, kind)]), structure(&[]));
        let (input, output) = if takes { (value, nothing) } else { (nothing, value) };
        let ty = ServiceType::new(ServiceKind::Attribute, input, output);
        let way = Way::of(&ty).unwrap();
        Arc::new(Attribute { name: name.to_owned(), ty, handler: Arc::new(Nothing), way })
    }

    fn described(attributes: &[Arc<Attribute>]) -> Vec<(String, String)> {
        let forth = parameters(attributes.iter(), false);
        let back = parameters(attributes.iter().rev(), false);
        let tell = |all: BTreeMap<String, Known>| {
            all.into_iter().map(|(name, one)| (name, one.description())).collect::<Vec<_>>()
        };
        let told = tell(forth);
        assert_eq!(told, tell(back), "the order does not matter");
        told
    }

    /// `expected` are those of attributes.
    #[track_caller]
    fn check(attributes: &[Arc<Attribute>], expected: &[(&str, &str)]) {
        let mut told = described(attributes);
        told.retain(|(_, description)| description != clock::DESCRIPTION);
        let owned = expected.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned()));
        assert_eq!(told, owned.collect::<Vec<_>>());
    }

    #[test]
    fn every_node_says_which_clock_it_has_unless_its_component_means_something_else_by_that() {
        let told = described(&[attribute("get_mode", false, "mode", Kind::Boolean)]);
        assert_eq!(told[1], ("use_sim_time".to_owned(), clock::DESCRIPTION.to_owned()));
        assert_eq!(described(&[]).len(), 1);
        let own = attribute("set_clock", true, "use_sim_time", Kind::Boolean);
        let told = described(&[own]);
        assert_eq!(told, [("use_sim_time".into(), "only set by attribute set_clock".into())]);
    }

    #[test]
    fn getter_and_setter_of_a_member_are_one_parameter() {
        check(
            &[
                attribute("set_speed", true, "velocity", Kind::Double),
                attribute("get_speed", false, "velocity", Kind::Double),
                attribute("get_mode", false, "mode", Kind::Boolean),
                attribute("set_name", true, "name", Kind::String { bound: None }),
            ],
            &[
                ("mode", "read by attribute get_mode"),
                ("name", "only set by attribute set_name"),
                ("velocity", "read by attribute get_speed, set by attribute set_speed"),
            ],
        );
    }

    #[test]
    fn members_of_one_name_that_do_not_belong_together_stay_apart() {
        check(
            &[
                attribute("set_left", true, "gain", Kind::Double),
                attribute("set_right", true, "gain", Kind::Double),
                attribute("get_left", false, "gain", Kind::Double),
            ],
            &[
                ("get_left.gain", "read by attribute get_left"),
                ("set_left.gain", "only set by attribute set_left"),
                ("set_right.gain", "only set by attribute set_right"),
            ],
        );
        check(
            &[attribute("set", true, "v", Kind::Double), attribute("get", false, "v", Kind::Long)],
            &[("get.v", "read by attribute get"), ("set.v", "only set by attribute set")],
        );
    }

    #[test]
    fn attributes_of_several_members_are_no_parameters() {
        let two = structure(&[("a", Kind::Double), ("b", Kind::Double)]);
        let ty = |input: &DataType, output: &DataType| {
            ServiceType::new(ServiceKind::Attribute, input.clone(), output.clone())
        };
        assert!(Way::of(&ty(&two, &structure(&[]))).is_none());
        assert!(Way::of(&ty(&structure(&[]), &two)).is_none());
    }
}
