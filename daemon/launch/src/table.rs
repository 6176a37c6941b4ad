//! Types of ROS's messages and services, as IDL types of their names.

use std::sync::Arc;

use genom_middleware::{ServiceKind, ServiceType};
use genom_types::{DataType, Kind, LayoutError, Member, ScopedName, TypeId, TypeTable};

/// A table in which the types of one package are made.
pub(crate) struct Table {
    types: TypeTable,
    package: &'static str,
}

/// Members of a struct, in order.
pub(crate) type Members = Vec<(&'static str, TypeId)>;

impl Table {
    pub(crate) fn of(package: &'static str) -> Self {
        Self { types: TypeTable::default(), package }
    }

    pub(crate) fn add(&mut self, kind: Kind) -> TypeId {
        self.types.add(kind)
    }

    pub(crate) fn string(&mut self) -> TypeId {
        self.add(Kind::String { bound: None })
    }

    pub(crate) fn several(&mut self, element: TypeId) -> TypeId {
        self.add(Kind::Sequence { element, bound: None })
    }

    /// A struct of the package.
    pub(crate) fn message(&mut self, name: &str, members: Members) -> TypeId {
        self.named(ScopedName::new([self.package, name]), members)
    }

    /// A struct of another package.
    pub(crate) fn foreign(&mut self, package: &str, name: &str, members: Members) -> TypeId {
        self.named(ScopedName::new([package, name]), members)
    }

    fn named(&mut self, name: ScopedName, members: Members) -> TypeId {
        let member = |(name, ty): (&str, TypeId)| Member { name: name.to_owned(), ty };
        let members = members.into_iter().map(member).collect();
        self.add(Kind::Struct { name, members })
    }

    /// A service of the package, whose name is that of its input and output.
    pub(crate) fn service(
        mut self,
        name: &str,
        input: Members,
        output: Members,
    ) -> Result<ServiceType, LayoutError> {
        let input = self.named(ScopedName::new([self.package, name, "input"]), input);
        let output = self.named(ScopedName::new([self.package, name, "output"]), output);
        let types = Arc::new(self.types);
        let (input, output) = (DataType::new(&types, input)?, DataType::new(&types, output)?);
        Ok(ServiceType::new(ServiceKind::Function, input, output))
    }

    /// A type of the table.
    pub(crate) fn finish(self, ty: TypeId) -> Result<DataType, LayoutError> {
        DataType::new(&Arc::new(self.types), ty)
    }
}
